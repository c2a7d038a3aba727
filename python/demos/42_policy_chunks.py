"""A policy's chunks followed at 1 kHz: late, with seams and gaps, and a loop that misses periods.

Writes chunks.json and chunks.png: python python/demos/42_policy_chunks.py [FOLDER]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import leadthrough as lt

plt.style.use("leadthrough.drawing.figures")
folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
arm, RATE, POLICY = lt.Arm.load("panda"), 1000.0, 30.0
home = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7])
table = lt.Box((1.0, 1.6, 0.05), (0.6, 0.0, 0.0))
rng = np.random.default_rng(0)


def policy(observed):  # a second of actions, each chunk a little beside the one before
    turn = 2.0 * np.pi * 0.3 * (observed + np.arange(30) / POLICY)[:, None]
    motion = home + (1.0 - np.cos(turn)) * [0.3, 0.1, 0.2, -0.2, 0.2, 0.1, 0.3]
    return motion + rng.normal(0.0, 0.02, 7) + rng.normal(0.0, 0.001, motion.shape)


# When a chunk was observed and when it comes: the third is 800 ms late, the sixth never comes.
arrivals = {0.0: 0.15, 0.7: 0.85, 1.4: 2.2, 2.1: 2.25, 2.8: 2.95, 4.2: 4.35}
chunks = {observed: policy(observed) for observed in arrivals}

follower = lt.guard.Chunks(lt.Guard(arm, [table], rate=RATE), rate=POLICY)
follower.start(home)
sent = [follower.guard.state]
missed = range(3000, 3021)  # the loop did something else
for tick in [tick for tick in range(1, 6001) if tick not in missed]:
    for observed, arrival in arrivals.items():
        if tick == round(arrival * RATE):
            due = follower.put(chunks[observed], observed)
            print(f"{arrival:.2f} s: chunk of {observed:.1f} s, {due} of 30 actions still due")
    sent.append(follower.next(tick / RATE))

times = np.array([tick for tick in range(6001) if tick not in missed]) / RATE
states = [[getattr(state, part) for state in sent] for part in ("q", "qd", "qdd")]
clock = np.arange(len(sent)) / RATE
motion = lt.JointTrajectory(clock, *states, joint_names=arm.joint_names)
kept, clear = lt.check_limits(motion, arm.limits).ok, arm.check(motion, [table]).ok
lt.write_motion(motion, folder / "chunks.json")
figure, axes = plt.subplots(3, 1, figsize=(9, 6), sharex=True, layout="constrained")
for observed, rows in chunks.items():
    axes[0].plot(observed + np.arange(30) / POLICY, rows[:, 0], "C1.", markersize=3)
    axes[0].axvline(arrivals[observed], color="0.8", linewidth=1)
for axis, part, unit in zip(axes, states, ("rad", "rad/s", "rad/s²"), strict=True):
    axis.plot(times, np.array(part)[:, 0], "C0")
    axis.set_ylabel(unit)
axes[0].set_title("first joint: actions (dots), their arrival (lines) and commands at 1 kHz")
axes[-1].set_xlabel("time in s")
figure.savefig(folder / "chunks.png", dpi=120)
print(f"limits kept: {kept}, clear: {clear}; wrote {folder / 'chunks.json'}")

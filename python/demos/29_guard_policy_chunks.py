"""Guard for a policy's action chunks, good and bad: admitted, corrected or refused with reasons.

Writes commanded.json and commanded.png: python python/demos/29_guard_policy_chunks.py [FOLDER]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import leadthrough as lt

plt.style.use("leadthrough.drawing.figures")
folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
arm, RATE = lt.Arm.load("panda"), 50.0
q = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7])
table = lt.Box((1.0, 1.6, 0.05), (0.6, 0.0, 0.0))
post = lt.Cylinder(0.05, 1.0, (0.45, -0.3, 0.5))
guard = lt.Guard(arm, [table, post], rate=RATE)
guard.admit(q[None], q)
commanded = [guard.state]
figure, axes = plt.subplots(figsize=(9, 3.5), layout="constrained")
times = np.arange(1, 51)[:, None] / RATE


def wave(size):  # a second of motion that begins and ends at rest
    return size * (1.0 - np.cos(2.0 * np.pi * times)) * [0.5, 0.3, 0.2, -0.3, 0.4, 0.2, 0.5]


chunks = {
    "slow": wave(0.2),
    "with a jump": wave(0.2) + 0.3 * (times > 0.5),
    "too fast": wave(1.5),
    "with noise": wave(0.2) + np.random.default_rng(0).normal(0.0, 0.002, (50, 7)),
    "with a NaN": np.where(np.arange(50)[:, None] == 10, np.nan, wave(0.2)),
    "into the post": times**2 * [-1.0, 0.2, 0, 0.2, 0, 0, 0],
}
for name, chunk in chunks.items():
    begin = len(commanded) / RATE
    axes.plot(begin + times, guard.state.q[0] + chunk[:, 0], "C1--")
    axes.text(begin, -0.4 if "NaN" in name else -0.6, name)
    print(f"{name}: {guard.admit(guard.state.q + chunk)}")
    # Sent to the controller, one every period.
    commanded += [guard.next() for _ in range(guard.remaining)]
# A person steps in while the arm moves.
guard.admit(guard.state.q + wave(0.6))
person = lt.shapes.MovingObstacle(lt.Capsule(0.25, 1.2, (0.2, 0.7, 0.6)), speed=0.8)
print(f"a person: {guard.update_obstacles([table, post, person])}")
commanded += [guard.next() for _ in range(guard.remaining)]
clock = np.arange(len(commanded)) / RATE
states = [[getattr(state, part) for state in commanded] for part in ("q", "qd", "qdd")]
sent = lt.JointTrajectory(clock, *states, joint_names=arm.joint_names)
kept, clear = lt.check_limits(sent, arm.limits).ok, arm.check(sent, [table, post]).ok
lt.write_motion(sent, folder / "commanded.json")
axes.plot(clock, sent.positions[:, 0], "C0")
axes.set(title="asked for (dashed) and sent", xlabel="time in s", ylabel="first joint in rad")
figure.savefig(folder / "commanded.png", dpi=120)
print(f"limits kept: {kept}, clear: {clear}; wrote {folder / 'commanded.json'}")

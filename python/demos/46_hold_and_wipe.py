"""One arm holds a plate and tilts it, the other wipes it: the wiping is learned on the plate.

Writes wiping.png: python python/demos/46_hold_and_wipe.py [FOLDER]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.spatial import KDTree

import leadthrough as lt
from leadthrough import rotations

plt.style.use("leadthrough.drawing.figures")
folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
panda = lt.Arm.load("panda")
pair = lt.DualArm(panda, panda, base=((0.0, -0.8, 0.0), (1.0, 0.0, 0.0, 0.0)))
down = np.array([0.0, 1.0, 0.0, 0.0])

# Shown once, in the plate's frame: loops of 2 s with a hand's noise, the tool pointing onto it.
rng, clock = np.random.default_rng(0), np.linspace(0.0, 6.0, 301)
angle = np.pi * clock
loops = np.column_stack([0.05 * np.cos(angle), 0.04 * np.sin(2.0 * angle) - 0.2, 0.0 * angle])
loops[:, :2] += 0.004 * np.cumsum(rng.normal(size=(301, 2)), axis=0) / np.sqrt(301)
shown = lt.PoseTrajectory(clock, loops, np.tile(down, (301, 1)))
wiping = lt.RhythmicDMP(period=2.0).fit([shown]).generate(duration=8.0, dt=0.04)

# Meanwhile the other arm tilts the plate about its long side, and back.
s = np.sin(np.pi * wiping.times / 8.0) ** 2
turn = rotations.exp(s[:, None] * [0.0, 0.35, 0.0])
plate = lt.PoseTrajectory(wiping.times, np.tile([0.5, -0.3, 0.35], (len(s), 1)), turn)
grasps = ((0.0, 0.12, 0.0), down), wiping
pair = pair.with_object(lt.Box((0.3, 0.3, 0.01), (0.0, -0.08, -0.01)), (grasps[0], grasps[0]))
joints = pair.follow(plate, grasps, scene=[])
run = lt.keep_timing(joints, pair.limits, rate=250.0)
print(f"{run.duration:.2f} s inside all limits: {pair.check(run, [])}")

hand, _ = pair.relative_pose(run.positions)
seen = np.array([0.0, 0.12, 0.0]) + hand * [
    1.0,
    -1.0,
    -1.0,
]  # from the plate: both hands point down
wanted, _ = wiping.at(np.linspace(0.0, 8.0, 4001))
near = KDTree(wanted).query(seen)[0].max()
print(f"the wiping hand keeps to its path on the plate within {1e3 * near:.2f} mm")

figure, (view, tilt) = plt.subplots(1, 2, figsize=(7, 3.2), layout="constrained")
view.plot(*shown.positions.T[:2], "C7", alpha=0.35, label="shown")
view.plot(*seen.T[:2], "C0", label="executed, seen from the plate")
view.set_aspect("equal")
view.set(xlabel="x in m", ylabel="y in m")
view.legend(loc="upper center", bbox_to_anchor=(0.5, 1.25))
tilt.plot(plate.times, np.degrees(0.35 * s))
tilt.set(xlabel="time in s", ylabel="tilt of the plate in degrees")
figure.savefig(folder / "wiping.png", dpi=120)
print(f"wrote {folder / 'wiping.png'}")

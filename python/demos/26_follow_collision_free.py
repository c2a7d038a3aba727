"""Collision-free following: the tool stays on its path, the elbow goes around the shelf.

Writes around.png: python python/demos/26_follow_collision_free.py [FOLDER]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import leadthrough as lt

plt.style.use("leadthrough.drawing.figures")
folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
arm = lt.Arm.load("panda")

# The hand points down and moves from one side to the other in front of the arm.
times = np.linspace(0.0, 3.0, 151)
side = 0.35 - 0.7 * lt.trajectories.minimum_jerk_time_scaling(times / 3.0)
line = np.column_stack([np.full(151, 0.45), side, np.full(151, 0.35)])
asked = lt.PoseTrajectory(times, line, np.tile([0.0, 1.0, 0.0, 0.0], (151, 1)))
q0 = [0.6, -0.5, 0.0, -2.4, 0.0, 2.0, 1.4]

shelf = lt.Box((0.1, 0.4, 0.2), (-0.15, 0.0, 0.65))  # behind the elbow
straight = arm.follow(asked, q0=q0)
around = arm.follow(asked, scene=lt.Scene([shelf], 0.01), q0=q0)

figure = plt.figure(figsize=(7, 3.5), layout="constrained")
axes = figure.subplots()
for name, joints in (("without the shelf", straight), ("around the shelf", around)):
    report = arm.check(joints, lt.Scene([shelf], 0.01))
    error = arm.path_report(joints, asked).position_error.max()
    nearest = report.obstacles.minimum_distance
    print(
        f"{name}: {1e3 * nearest:.1f} mm from it at the nearest, tool off by {1e6 * error:.1f} um"
    )
    axes.plot(joints.times, 1e3 * report.obstacles.distances, label=name)
axes.axhline(0.0, color="C7", linewidth=0.8)
axes.set_xlabel("time in s")
axes.set_ylabel("whole arm to shelf in mm")
axes.legend()
figure.savefig(folder / "around.png", dpi=120)
print(f"wrote {folder / 'around.png'}")

"""Collision check of the whole arm: the tool is clear of a shelf, but the elbow is not.

Writes collision.png: python python/demos/12_whole_arm_collision.py [FOLDER]
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
times = np.linspace(0.0, 3.0, 301)
side = 0.35 - 0.7 * lt.trajectories.minimum_jerk_time_scaling(times / 3.0)  # from rest to rest
line = np.column_stack([np.full(301, 0.45), side, np.full(301, 0.35)])
asked = lt.PoseTrajectory(times, line, np.tile([0.0, 1.0, 0.0, 0.0], (301, 1)))
q0 = [0.6, -0.5, 0.0, -2.4, 0.0, 2.0, 1.4]
followed = arm.follow(asked, q0=q0, on_rate_limit="exceed_limits")  # slowed down in the next line
joints = lt.keep_timing(followed, arm.limits, rate=400.0)

shelf = lt.Box((0.1, 0.4, 0.2), (-0.15, 0.0, 0.65))  # behind the elbow
tool, _ = arm.forward_kinematics(joints.positions)
to_tool = shelf.distance(tool)
report = arm.check(joints, [shelf])
print(f"the tool keeps {to_tool.min():.2f} m from the shelf; the whole arm:")
print(report)

figure = plt.figure(figsize=(7, 3.5), layout="constrained")
axes = figure.subplots()
axes.plot(joints.times, to_tool, "--", label="tool to shelf")
axes.plot(joints.times, report.obstacles.distances, label="whole arm to shelf")
axes.plot(joints.times, report.itself.distances, label="arm to itself")
axes.plot(report.first.time, report.first.distance, "ko", label="first hit")
axes.axhline(0.0, color="C7", linewidth=0.8)
axes.set_xlabel("time, s")
axes.set_ylabel("distance, m")
axes.legend(loc="center right")
figure.savefig(folder / "collision.png", dpi=120)
print(f"wrote {folder / 'collision.png'}")

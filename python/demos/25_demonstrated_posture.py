"""Reaches demonstrated with the elbow out: new goals keep the demonstrated posture.

Writes posture.png: python python/demos/25_demonstrated_posture.py [FOLDER]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import leadthrough as lt

plt.style.use("leadthrough.drawing.figures")
folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
arm = lt.Arm.load("panda")

# Three recordings of a person who guides the arm, its elbow turned out to pass beside something.
rng = np.random.default_rng(0)
times = np.linspace(0.0, 3.0, 151)
rise = lt.trajectories.minimum_jerk_time_scaling(times / times[-1])
first, way = (
    np.array([0.5, -0.6, -1.2, -2.2, 0.6, 2.0, 1.4]),
    np.array([0.6, 0.3, 0.2, 0.4, 0, 0, 0]),
)
shown = []
for _ in range(3):
    joints = first + rng.normal(0.0, 0.01, 7) + np.outer(rise, way)
    joints += rng.normal(0.0, 5e-4, joints.shape)  # encoders
    shown.append(arm.poses(lt.JointTrajectory(times, joints, joint_names=arm.joint_names)))
skill = lt.DMP().fit(shown)
skill.save(folder / "elbow_out.npz")  # with the joints
skill = lt.load_skill(folder / "elbow_out.npz")

figure = plt.figure(figsize=(8, 4), layout="constrained")
axes = figure.subplots()
usual = skill.generate()
for offset in ((0.0, 0.0, 0.0), (0.08, 0.0, 0.05), (0.0, -0.1, 0.05)):
    goal = usual.positions[-1] + offset, usual.orientations[-1]
    tip = skill.generate(goal=goal)
    made = arm.follow(tip)  # starts and stays near tip.joints
    away = np.abs(made.positions[0] - first).max()
    bare = arm.follow(lt.PoseTrajectory(tip.times, tip.positions, tip.orientations))
    elsewhere = np.abs(bare.positions[0] - first).max()
    print(f"goal moved by {offset} m: starts {away:.3f} rad from where it was shown", end=" ")
    print(f"({elsewhere:.2f} rad without the joints)")
    axes.plot(made.times, made.positions[:, 2], label=f"goal moved by {offset} m")
axes.plot(times, first[2] + rise * way[2], "k--", linewidth=1, label="shown")
axes.set(xlabel="time [s]", ylabel="panda_joint3 [rad]", title="the elbow as it was shown")
axes.legend()
figure.savefig(folder / "posture.png", dpi=120)
print(f"wrote {folder / 'posture.png'}")

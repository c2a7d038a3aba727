"""A data set for policies from three demonstrations: motions for random goals and an obstacle.

Writes the folder episodes, for LeRobot, and episodes.png:
python python/demos/43_augment_demonstrations.py [FOLDER]
Needs the extra `lerobot`.
"""

import shutil
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import leadthrough as lt

plt.style.use("leadthrough.drawing.figures")
folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
arm = lt.Arm.load("panda")
home = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7])
phase = np.linspace(0.0, 1.0, 51)
rise = lt.trajectories.minimum_jerk_time_scaling(phase)[:, None]
demonstrations = [
    arm.poses(lt.JointTrajectory(3.0 * phase, home + rise * turn, joint_names=arm.joint_names))
    for turn in np.add([0.6, 0.4, 0, 0.3, 0, 0.1, 0.2], [[0.05] * 7, [0.0] * 7, [-0.05] * 7])
]
skill = lt.DMP().fit(demonstrations)

out = folder / "episodes"
shutil.rmtree(out, ignore_errors=True)
goal = skill.generate().positions[-1]
ball = lt.shapes.RandomObstacle(lt.Sphere(0.04, (0.55, -0.1, 0.6)), (0.05, 0.1, 0.05))
found = lt.augment(
    skill,
    arm,
    [ball],
    episodes=15,
    out=out,
    goals=lt.validation.TargetRegion.around(goal, (0.12, 0.12, 0.08)),
)
print(found)

figure, axes = plt.subplots(1, 2, figsize=(9, 4), layout="constrained")
for episode in lt.io.stream_recordings(out):
    tip = arm.forward_kinematics(episode.recording.positions)[0]
    axes[0].plot(tip[:, 0], tip[:, 1], "C0", linewidth=0.8)
    axes[1].plot(episode.recording.times, episode.recording.positions[:, 0], "C0", linewidth=0.8)
for motion in demonstrations:
    axes[0].plot(*motion.positions[:, :2].T, "C1")
axes[0].set(
    title="tip: 3 demonstrated, 15 written", xlabel="x in m", ylabel="y in m", aspect="equal"
)
axes[1].set(title="first joint of the episodes", xlabel="time in s", ylabel="rad")
figure.savefig(folder / "episodes.png", dpi=120)
print(f"wrote {out} and {folder / 'episodes.png'}")

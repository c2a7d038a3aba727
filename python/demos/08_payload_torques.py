"""Joint torques of a Panda, without and with a drill, and manipulability of its configurations.

Writes torques.png: python python/demos/08_payload_torques.py [FOLDER]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import leadthrough as lt

plt.style.use("leadthrough.drawing.figures")
folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
arm = lt.Arm.load("panda")

# A drill of 2 kg, 10 cm beyond the fingertips; the tip of its bit is 25 cm in front of them.
drill = lt.Capsule(0.04, 0.12, (0.0, 0.0, 0.1))
drilling = arm.with_attached(drill, mass=2.0).with_tool((0.25, 0.0, 0.1))
print(drilling.describe())

# Reach out from near the base until the elbow is almost straight.
phase = np.linspace(0.0, 1.0, 201)
swing = lt.trajectories.minimum_jerk_time_scaling(phase)
near, far = (
    np.array([0.0, -1.0, 0.0, -2.7, 0.0, 1.7, 0.8]),
    np.array([0.0, 1.2, 0.0, -0.2, 0, 1.5, 0.8]),
)
positions = near + np.outer(swing, far - near)
moved = lt.JointTrajectory(2.5 * phase, positions, joint_names=arm.joint_names)
motion = lt.keep_timing(moved, arm.limits, rate=80.0)
moves = (motion.positions, motion.velocities, motion.accelerations)

figure = plt.figure(figsize=(10, 6), layout="constrained")
(alone, loaded), (posture, volume) = figure.subplots(2, 2, sharex=True)
loaded.sharey(alone)
for axes, robot, title in (
    (alone, arm, "without a load"),
    (loaded, drilling, "with a drill of 2 kg"),
):
    torques = 100 * robot.inverse_dynamics(*moves) / arm.limits.effort
    axes.plot(motion.times, torques, label=[f"joint {i + 1}" for i in range(7)])
    axes.plot(motion.times, 100 * robot.gravity_torques(moves[0]) / arm.limits.effort, "k:", lw=1)
    axes.set_title(f"{title}: torque, % of the limit (dotted: gravity)", fontsize=10)
    joint = int(np.abs(torques).max(axis=0).argmax())
    print(f"{title}: at most {np.abs(torques).max():.0f} % of the limit, in joint {joint + 1}")
    for axes_, value in ((posture, robot.condition_number), (volume, robot.manipulability)):
        axes_.semilogy(motion.times, value(moves[0]), label=title)
alone.legend(fontsize=8)
posture.set_title("condition number (0.3 m per rad)", fontsize=10)
volume.set_title("manipulability (independent of the tool)", fontsize=10)
posture.legend(fontsize=8)
for axes in (posture, volume):
    axes.set_xlabel("time in s")
figure.savefig(folder / "torques.png", dpi=120)
print(f"wrote {folder / 'torques.png'}")

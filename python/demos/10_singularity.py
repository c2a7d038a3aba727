"""A straight line past a singularity of the Panda: the plain inverse, compared with follow.

Writes singularity.png: python python/demos/10_singularity.py [FOLDER]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import leadthrough as lt

plt.style.use("leadthrough.drawing.figures")
folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
arm = lt.Arm.load("panda")
posture = np.array([0, 0.02, 1.57, -1.8, 0, 1.6, 0.7])  # the shoulder's axes nearly in one plane
position, orientation = arm.forward_kinematics(posture)

# The line passes through this pose in the direction that requires the fastest joints.
_, _, directions = np.linalg.svd(np.linalg.pinv(arm.jacobian(posture))[:, :3])
times = np.linspace(0.0, 1.5, 601)
along = 0.24 * lt.trajectories.minimum_jerk_time_scaling(times / 1.5) - 0.12  # m, from rest to rest
line = lt.PoseTrajectory(times, position + np.outer(along, directions[0]), [orientation] * 601)


def plain_inverse(q):
    """Joints by q += J^+ dx alone."""
    rows = [q]
    for goal, turned in zip(line.positions[1:], line.orientations[1:], strict=True):
        here, orientation = arm.forward_kinematics(rows[-1])
        back = lt.rotations.inverse(orientation[None])
        turn = lt.rotations.log(lt.rotations.compose(turned[None], back))[0]
        step = np.linalg.pinv(arm.jacobian(rows[-1])) @ np.concatenate([goal - here, turn])
        rows.append(rows[-1] + step)
    return lt.JointTrajectory(times, rows)


ways = {
    "slow": arm.follow(line, q0=posture, on_rate_limit="slow"),
    "deviate": arm.follow(line, q0=posture, on_rate_limit="deviate", deviation=(1e-3, 5e-3)),
}
ways = {"plain inverse": plain_inverse(ways["slow"].positions[0]), **ways}
figure = plt.figure(figsize=(9, 7), layout="constrained")
axes = figure.subplots(3, 1, sharex=True)
for name, joints in ways.items():
    report = arm.path_report(joints, line, position_tolerance=1e-3, orientation_tolerance=5e-3)
    print(f"{name}: {report.summary()}\n")
    axes[0].semilogy(joints.times, report.velocity_ratio, label=name)
    axes[1].semilogy(joints.times, 1e3 * report.position_error + 1e-6)
    axes[2].semilogy(joints.times, report.condition_number)
axes[0].axhline(1.0, color="C7", linestyle="--", linewidth=0.8)
for ax, text in zip(axes, ["speed / limit", "error in mm", "condition"], strict=True):
    ax.set_ylabel(text)
axes[0].legend()
axes[2].set_xlabel("time in s")
figure.savefig(folder / "singularity.png", dpi=110)
print(f"wrote {folder / 'singularity.png'}")

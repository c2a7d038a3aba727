"""All configurations of a UR3 for one pose, the one closest to a reference, and a free tool axis.

Writes solutions.png: python python/demos/09_inverse_kinematics_solutions.py [FOLDER]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import leadthrough as lt

plt.style.use("leadthrough.drawing.figures")
folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
arm = lt.Arm.load("ur3")
links = ["upper_arm_link", "forearm_link", "wrist_1_link", "wrist_2_link", "wrist_3_link", "tool0"]


def skeleton(q):
    """Origins of the links (links + 1, 3), in m."""
    points = [np.zeros(3)]
    for number, link in enumerate(links):
        part = lt.Arm.from_urdf(arm.document, base=arm.base, tip=link)
        points.append(part.forward_kinematics(q[: min(number + 2, 6)])[0])
    return np.array(points)


home = np.array([0.0, -1.6, 1.4, -1.4, -1.57, 0.0])
position, downwards = np.array([0.25, 0.15, 0.12]), np.array([0.0, 1.0, 0.0, 0.0])

near_home = lt.arm.IkOptions(mode="closest", posture=home)
ways = arm.inverse_kinematics_all(position, downwards, options=near_home)
print(f"{len(ways)} configurations,", "complete" if ways.complete else "others may exist")
for q in ways.q:
    print(np.round(np.degrees(q)).astype(int), f"{np.linalg.norm(q - home):.2f} rad from home")
closest = arm.inverse_kinematics(position, downwards, options=near_home)
print(f"the closest: {np.linalg.norm(closest.q - home):.2f} rad")

# Holes on a circle, drilled from above: the rotation about the drill's axis does not matter.
angles = np.linspace(0.0, 2.0 * np.pi, 60)
holes = position + 0.08 * np.column_stack([np.cos(angles), np.sin(angles), 0.0 * angles])
spins = lt.rotations.compose(
    np.tile(downwards, (60, 1)), lt.rotations.exp([[0, 0, a] for a in angles])
)
free_spin = lt.arm.IkOptions(free=("rz",))
drilled = arm.inverse_kinematics_batch(holes, spins, q0=closest.q, options=free_spin)
turning = arm.inverse_kinematics_batch(holes, spins, q0=closest.q)
for name, batch in (("free spin", drilled), ("spin asked for", turning)):
    print(f"{name}: {batch.success.mean():.0%} reached, wrist {np.ptp(batch.q[:, 5]):.1f} rad")

figure = plt.figure(figsize=(12, 6), layout="constrained")
for number, q in enumerate(ways.q):
    axes = figure.add_subplot(2, 4, number + 1, projection="3d")
    axes.plot(*skeleton(q).T, "o-", linewidth=3, markersize=4)
    axes.scatter(*position, color="C1")
    axes.set(xlim=(-0.5, 0.5), ylim=(-0.5, 0.5), zlim=(0, 0.8), title=f"way {number + 1}")
figure.savefig(folder / "solutions.png", dpi=110)
print(f"wrote {folder / 'solutions.png'}")

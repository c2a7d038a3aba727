"""Reachability of a UR3, and its placement for a motion that a Panda demonstrated.

Writes reach.npz, reach.png and ur3_placement.png:
python python/demos/34_reachability_and_placement.py [FOLDER]
"""

import sys
from pathlib import Path

import numpy as np

import leadthrough as lt
from leadthrough.validation import TargetRegion

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
ur3 = lt.Arm.load("ur3")
table = lt.Box((1.5, 1.5, 0.05), (0.0, 0.0, -0.05))
found = lt.reachability.reach_map(ur3, [table], spacing=0.2, orientations=8)
print(f"reached above the table: {found.volume:.2f} m^3, {found.fraction.max():.0%} of all turns")
found.save(folder / "reach.npz")
lt.show.reach_figure(found).savefig(folder / "reach.png")

panda = lt.Arm.load("panda")
phase = np.linspace(0.0, 1.0, 41)[:, None]
home = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7])
shown = lt.JointTrajectory(3.0 * phase[:, 0], home + phase * [0.5, 0.3, 0, 0.3, 0, 0.1, 0.2])
poses = panda.poses(shown)
there = lt.PoseTrajectory(poses.times, poses.positions, poses.orientations)  # no Panda's joints
area = TargetRegion([-0.2, -0.4, 0.2], [0.4, 0.4, 0.2])
stand = lt.reachability.place_base(there, ur3, area=area, spacing=0.1, yaws=4)
whole = int((stand.manipulability > 0.0).sum())
print(f"the whole motion is reached from {whole} of {len(stand.bases)} places")
assert stand.best is not None
assert stand.joints is not None
print(f"best at {stand.best[:3].round(2)}, facing {np.degrees(stand.best[3]):.0f} degrees")
print(f"joints of {len(stand.joints)} samples, clear of itself: {ur3.check(stand.joints).ok}")
lt.show.placement_figure(stand).savefig(folder / "ur3_placement.png")
print(f"wrote {folder / 'reach.png'} and {folder / 'ur3_placement.png'}")

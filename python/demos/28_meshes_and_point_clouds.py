"""Obstacles as meshes and point clouds: a bin, a shelf as a depth camera sees it, a drum.

Writes obstacles.ply, bin.obj and obstacles.html:
python python/demos/28_meshes_and_point_clouds.py [FOLDER]
"""

import sys
from pathlib import Path
from time import process_time

import numpy as np

import leadthrough as lt

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
arm = lt.Arm.load("panda")

# Ten thousand points on two boards behind the elbow, with a millimetre of noise.
rng = np.random.default_rng(0)
points = rng.uniform((-0.2, -0.2, 0.55), (-0.1, 0.2, 0.75), (10_000, 3))
points[:, 2] = np.where(points[:, 2] < 0.65, 0.55, 0.75) + 0.001 * rng.normal(size=10_000)
head = "ply\nformat binary_little_endian 1.0\nelement vertex 10000\n"
head += "".join(f"property double {axis}\n" for axis in "xyz") + "end_header\n"
(folder / "obstacles.ply").write_bytes(head.encode() + points.tobytes())
shelf = lt.read_point_cloud(folder / "obstacles.ply", radius=0.006)

# A bin of one closed surface, in millimetres, which counts as four walls and a bottom.
text, sides = "", ((-1, -1), (1, -1), (1, 1), (-1, 1))
for wide, deep, z in ((310, 330, 0), (310, 330, 120), (300, 320, 120), (300, 320, 5)):
    text += "".join(f"v {sx * wide / 2} {sy * deep / 2} {z}\n" for sx, sy in sides)
for ring in (1, 5, 9):
    for k in range(4):
        a, b = ring + k, ring + (k + 1) % 4
        text += f"f {a} {b} {b + 4} {a + 4}\n"
text += "f 4 3 2 1\nf 13 14 15 16\n"
(folder / "bin.obj").write_text(text)
bin_ = lt.read_mesh(folder / "bin.obj", scale=0.001, position=(0.45, 0.0, 0.07))
drum = lt.Cylinder(0.12, 0.5, (0.2, -0.6, 0.25))
around = [shelf, bin_, drum]

# The hand dips into the bin and comes out again while the elbow passes the shelf.
times = np.linspace(0.0, 4.0, 201)
turn = 2.0 * np.pi * lt.trajectories.minimum_jerk_time_scaling(times / 4.0)
path = np.column_stack(
    [np.full(201, 0.45), 0.02 * np.sin(turn), 0.33 - 0.06 * (1.0 - np.cos(turn))]
)
asked = lt.PoseTrajectory(times, path, np.tile([0.0, 1.0, 0.0, 0.0], (201, 1)))
joints = arm.follow(asked, scene=around, q0=[0.0, -0.5, 0.0, -2.4, 0.0, 2.0, 0.8])
print(arm.check(joints, lt.Scene(around, 0.005)))

begin = process_time()
clear = arm.is_clear(joints.positions, around)
each = 1e6 * (process_time() - begin) / len(clear)
print(f"clear of {len(shelf.points):,} points, bin and drum: {clear.all()}, {each:.0f} us each")
lt.show.view(arm, joints, scene=around, html=folder / "obstacles.html")
print(f"wrote {folder / 'obstacles.html'}")

"""Two arms carry a tray past a box, level and clear of the box, of themselves and of each other.

Writes tray.png: python python/demos/41_two_arms.py [FOLDER]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import leadthrough as lt

plt.style.use("leadthrough.drawing.figures")
folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
panda = lt.Arm.load("panda")
pair = lt.DualArm(panda, panda, base=((0.0, -0.8, 0.0), (1.0, 0.0, 0.0, 0.0)))

# The tray goes up, forwards over the box, and down; both hands point down at its edges.
times = np.linspace(0.0, 4.0, 101)
s = lt.trajectories.minimum_jerk_time_scaling(times / 4.0)
path = np.column_stack([0.27 + 0.4 * s, np.full(101, -0.4), 0.25 + 0.25 * np.sin(np.pi * s)])
motion = lt.PoseTrajectory(times, path, np.tile([1.0, 0.0, 0.0, 0.0], (101, 1)))
down = (0.0, 1.0, 0.0, 0.0)
grasps = (((0.0, 0.2, 0.0), down), ((0.0, -0.2, 0.0), down))
pair = pair.with_object(lt.Box((0.25, 0.38, 0.02), (0.0, 0.0, -0.01)), grasps)
scene = lt.Scene([lt.Box((0.06, 0.5, 0.26), (0.475, -0.4, 0.13))], margin=0.01)

joints = pair.follow(motion, grasps, scene=scene)
run = lt.retime(joints, pair.limits)
report = pair.check(run, scene)
position, _ = pair.relative_pose(run.positions)
error = np.linalg.norm(position - position[0], axis=1).max()
print(f"{len(run.joint_names)} joints, {run.duration:.2f} s inside all limits: {report}")
print(f"the hands keep their distance to {1e6 * error:.1f} um, {len(run)} samples at 1 kHz")

elbows = [lt.Arm.load("panda", tip=f"panda_link{i}") for i in range(1, 8)]
figure = plt.figure(figsize=(7, 3.4), layout="constrained")
view, clear = figure.subplots(1, 2)
for sample, shade in ((0, 0.25), (len(run) // 2, 0.5), (len(run) - 1, 1.0)):
    for side, q in zip(("C0", "C1"), pair.split(run.positions[sample]), strict=True):
        points = [arm.forward_kinematics(q[: len(arm.joint_names)])[0] for arm in [*elbows, panda]]
        x, _, z = np.transpose([[0.0, 0.0, 0.0], *points])
        view.plot(x, z, side, alpha=shade, linewidth=2)
view.plot(*path[:, [0, 2]].T, "k:")
view.add_patch(plt.Rectangle((0.445, 0.0), 0.06, 0.26, color="C7"))
view.set_aspect("equal")
view.set_xlabel("x in m")
view.set_ylabel("z in m")
clear.plot(run.times, 1e3 * report.obstacles.distances)
clear.axhline(10.0, color="C7", linestyle="--")
clear.set_xlabel("time in s")
clear.set_ylabel("to the box and between the arms in mm")
figure.savefig(folder / "tray.png", dpi=120)
print(f"wrote {folder / 'tray.png'}")

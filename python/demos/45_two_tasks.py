"""Two arms reach over the same place on paths of their own: one waits until the other has passed.

Writes two_tasks.png: python python/demos/45_two_tasks.py [FOLDER]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import leadthrough as lt
from leadthrough.arm import coordinate

plt.style.use("leadthrough.drawing.figures")
folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
panda = lt.Arm.load("panda")
pair = lt.DualArm(panda, panda, base=((0.0, -0.6, 0.0), (1.0, 0.0, 0.0, 0.0)))


def reach(begin, end, duration):
    """Joints of one arm along a straight line of its tip, in its own base frame."""
    s = lt.trajectories.minimum_jerk_time_scaling(np.linspace(0.0, 1.0, 101))[:, None]
    path = np.array(begin) + s * (np.array(end) - begin)
    times = np.linspace(0.0, duration, 101)
    return panda.follow(lt.PoseTrajectory(times, path, np.tile([0.0, 1.0, 0.0, 0.0], (101, 1))))


left = reach([0.35, 0.2, 0.4], [0.6, -0.35, 0.25], 2.0)
right = reach([0.6, 0.35, 0.3], [0.35, -0.2, 0.4], 6.0)
times = np.linspace(0.0, 6.0, 301)
together = np.hstack([left.at(np.minimum(times, left.duration)), right.at(times)])
found = coordinate(pair, left, right)
run = lt.retime(found.joints, pair.limits)
for wait in found.waits:
    print(f"{wait.side} waits from {wait.begin:.2f} to {wait.end:.2f} s: {', '.join(wait.bodies)}")
print(f"retimed inside all limits: {run.duration:.2f} s, {pair.check(run)}")

figure = plt.figure(figsize=(8, 3.4), layout="constrained")
above, distance = figure.subplots(1, 2, width_ratios=[1, 2])
positions, _ = pair.forward_kinematics(found.joints.positions)
for k, side in enumerate(("left", "right")):
    above.plot(*positions[:, k, :2].T, label=f"{side} hand")
for wait in found.waits:
    (x, y, _), _ = panda.forward_kinematics(wait.q)
    above.plot(x, y - 0.6 * (wait.side == "right"), "ko", label=f"{wait.side} waits here")
above.set_aspect("equal")
above.set(xlabel="x in m", ylabel="y in m")
above.set_xlim(0.1, 0.85)
above.legend(fontsize=7, loc="center left")
distance.plot(times, 1e3 * pair.distance(together, []), "C7", label="nobody waits")
gaps = pair.distance(found.joints.positions, [])
distance.plot(found.joints.times, 1e3 * gaps, "C2", label="coordinated")
for wait in found.waits:
    distance.axvspan(wait.begin, wait.end, color="C2", alpha=0.15)
distance.set(xlabel="time in s", ylabel="between the arms in mm")
distance.legend(fontsize=7)
figure.savefig(folder / "two_tasks.png", dpi=120)
print(f"wrote {folder / 'two_tasks.png'}")

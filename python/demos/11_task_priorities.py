"""Task priorities of a Panda: tool on a line, elbow clear of a ball, preferred posture last.

Each task moves the arm only in the null space of those above it.
Writes task_priorities.png: python python/demos/11_task_priorities.py [FOLDER]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import leadthrough as lt
from leadthrough.arm import JointLimitTask, ObstacleTask, PoseTask, PostureTask, TaskStack

plt.style.use("leadthrough.drawing.figures")
folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
arm = lt.Arm.load("panda")
start = np.array([0.0, -0.3, 0.0, -2.0, 0.0, 1.7, 0.8])
position, orientation = arm.forward_kinematics(start)

# A ball in the elbow's way; the elbow itself counts as a sphere of radius 8 cm.
ball = lt.Sphere(0.06, (0.13, 0.04, 0.64))
elbow = ObstacleTask(ball, 0.08, margin=0.08, link="panda_link4")
posture = PostureTask(start, gain=2.0)


def tool(time):
    """A task that moves 24 cm down and up again in 4 s; its twist is the velocity feed-forward."""
    phase = 0.5 * np.pi * time
    place = position - np.array([0.0, 0.0, 0.12 * (1.0 - np.cos(phase))])
    twist = (0.0, 0.0, -0.06 * np.pi * np.sin(phase), 0.0, 0.0, 0.0)
    return PoseTask(place, orientation, twist=twist)


def run(*lower):
    def tasks(time):
        return [JointLimitTask(), tool(time), *lower]

    return TaskStack(arm, tasks(0.0)).run(start, duration=4.0, dt=2e-3, tasks=tasks)


runs = {True: run(elbow, posture), False: run(posture)}
upper_arm = lt.Arm.from_urdf(arm.document, base=arm.base, tip="panda_link4")
figure = plt.figure(figsize=(9, 6), layout="constrained")
above, below = figure.subplots(2, 1, sharex=True)
for there, label in ((True, "with the elbow task"), (False, "without the elbow task")):
    motion = runs[there].trajectory
    elbows, _ = upper_arm.forward_kinematics(motion.positions[:, :4])
    above.plot(motion.times, 100 * (ball.distance(elbows) - 0.08), label=label)
above.set_ylabel("elbow to ball, cm")
names = ["1 joint limits", "2 tool's pose", "3 elbow off the ball", "4 posture"]
for name, residual in zip(names, runs[True].residual.T, strict=True):
    below.semilogy(motion.times, np.maximum(residual, 1e-17), label=name)
below.set(xlabel="time, s", ylabel="residual, m/s or rad/s")
above.legend(), below.legend(ncols=2)
figure.savefig(folder / "task_priorities.png", dpi=120)
worst = runs[True].error[:, 1].max()
print(f"the tool stays within {1e6 * worst:.1f} um; wrote {folder / 'task_priorities.png'}")

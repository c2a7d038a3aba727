"""Motion planning past a post: the tool deviates where the wrist has no room.

Writes planned.png and planned.html: python python/demos/27_plan_motion.py [FOLDER]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import leadthrough as lt

plt.style.use("leadthrough.drawing.figures")
folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
arm = lt.Arm.load("ur3")

# A reach from the left to the right in front of the arm, the flange pointing down.
u = np.linspace(0.0, 1.0, 101)
rise = lt.trajectories.minimum_jerk_time_scaling(u)
line = np.column_stack([0.3 + 0.04 * np.sin(np.pi * u), 0.5 * rise - 0.25, np.full(101, 0.2)])
shown = lt.PoseTrajectory(2.5 * u, line, np.tile([0.0, 1.0, 0.0, 0.0], (101, 1)))
skill = lt.DMP().fit([shown])

post = lt.Box((0.06, 0.06, 0.3), (0.25, 0.0, 0.15))  # beside the way of the tool, on the wrist's
straight = arm.follow(skill.generate(obstacles=[post]))
planned = lt.plan_motion(skill, arm, [post])
timed = lt.retime(planned.joints, arm.limits)

figure = plt.figure(figsize=(7, 3.5), layout="constrained")
front, gap = figure.subplots(1, 2)
for name, joints in (("tip only", straight), ("whole arm", planned.joints)):
    positions, _ = arm.forward_kinematics(joints.positions)
    front.plot(positions[:, 1], positions[:, 2], label=name)
    gap.plot(joints.times, 1e3 * arm.check(joints, [post]).obstacles.distances, label=name)
low, high = post.position - 0.5 * post.size, post.position + 0.5 * post.size
front.fill([low[1], high[1], high[1], low[1]], [low[2], low[2], high[2], high[2]], color="C6")
front.set(xlabel="y in m", ylabel="z in m", aspect="equal", title="tool and post from the front")
gap.axhline(0.0, color="C7", linewidth=0.8)
gap.set(xlabel="time in s", ylabel="whole arm to post in mm")
gap.legend(loc="lower left")
figure.savefig(folder / "planned.png", dpi=120)
lt.show.view(arm, timed, scene=[post], html=folder / "planned.html")
print(*planned.reasons, sep="\n")
off, room = 1e3 * planned.deviation, 1e3 * planned.clearance
print(f"tool {off:.0f} mm off its path, arm {room:.0f} mm clear")
print(f"wrote {folder / 'planned.png'} and {folder / 'planned.html'}")

"""View a motion: a self-contained page with a Panda that carries an object around a box.

Writes motion.html: python python/demos/20_view_motion.py [FOLDER]
With --live it opens a page where the goal and the box can be dragged (extra `view`).
"""

import sys
from pathlib import Path

import numpy as np

import leadthrough as lt
from leadthrough.show import view

folder = Path(next((word for word in sys.argv[1:] if word[0] != "-"), "."))
arm = lt.Arm.load("panda")

# Six slightly different demonstrations carry an object over a table, flange down; in m.
rng = np.random.default_rng(1)
times = np.linspace(0.0, 4.0, 200)
way = lt.trajectories.minimum_jerk_time_scaling(times / 4.0)
demonstrations = []
for _ in range(6):
    first, last = rng.normal([(0.40, -0.38, 0.18), (0.50, 0.36, 0.22)], 0.01)
    path = first + np.outer(way, last - first)
    path[:, 0] += rng.normal(0.08, 0.02) * np.sin(np.pi * way)
    path[:, 2] += rng.normal(0.25, 0.03) * np.sin(np.pi * way) ** 2
    poses = lt.PoseTrajectory(times, path, np.tile((0.0, 1.0, 0.0, 0.0), (len(times), 1)))
    demonstrations.append(lt.Demonstration(poses))

box = lt.Box((0.10, 0.10, 0.38), (0.54, -0.02, 0.19))
with_room = lt.Box(box.size + 0.16, box.position)  # room for the hand: only the tip is planned
skill = lt.DMP().fit(demonstrations)
if "--live" in sys.argv:
    view(arm, scene=[box], demonstrations=demonstrations, skill=skill)
    sys.exit()

planned = skill.generate(obstacles=[with_room])
followed = arm.follow(planned, on_rate_limit="exceed_limits")  # slowed down in the next line
joints = lt.keep_timing(followed, arm.limits, rate=100.0)
print(f"{joints.duration:.2f} s; {arm.check(joints, [box])}")
view(
    arm,
    joints,
    scene=[box],
    demonstrations=demonstrations,
    skill=lt.ProMP().fit(demonstrations),  # shows how far the six differ
    goal=planned.positions[-1],
    html=folder / "motion.html",
    title="Around a box",
)
print(f"wrote {folder / 'motion.html'}")

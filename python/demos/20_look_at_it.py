"""Look at a motion: a page with a Panda that carries something around a box, on its own.

Writes look.html: python python/demos/20_look_at_it.py [FOLDER]
With --live it opens a page where goal and box may be dragged (extra `view`).
"""

import sys
from pathlib import Path

import numpy as np

import leadthrough as lt
from leadthrough.show import view

folder = Path(next((word for word in sys.argv[1:] if word[0] != "-"), "."))
arm = lt.Arm.load("panda")

# Six hands carry something over a table, the flange down; each a little differently, m.
rng = np.random.default_rng(1)
times = np.linspace(0.0, 4.0, 200)
share = 10 * (times / 4) ** 3 - 15 * (times / 4) ** 4 + 6 * (times / 4) ** 5
demonstrations = []
for _ in range(6):
    first, last = rng.normal([(0.40, -0.38, 0.18), (0.50, 0.36, 0.22)], 0.01)
    path = first + np.outer(share, last - first)
    path[:, 0] += rng.normal(0.08, 0.02) * np.sin(np.pi * share)
    path[:, 2] += rng.normal(0.25, 0.03) * np.sin(np.pi * share) ** 2
    poses = lt.PoseTrajectory(times, path, np.tile((0.0, 1.0, 0.0, 0.0), (len(times), 1)))
    demonstrations.append(lt.Demonstration(poses))

box = lt.Box((0.10, 0.10, 0.38), (0.54, -0.02, 0.19))
with_room = lt.Box(box.size + 0.16, box.position)  # the hand is wider than the tip that is planned
skill = lt.PoseDMP().fit(demonstrations)
if "--live" in sys.argv:
    view(arm, demonstrations=demonstrations, skill=skill, obstacles=[box])
    sys.exit()

planned = skill.generate(obstacles=[with_room])
joints = lt.scale_to_limits(lt.differentiate(arm.follow(planned)), arm.limits)
print(f"{joints.duration:.2f} s; {arm.check(joints, [box])}")
view(
    arm,
    joints,
    demonstrations=demonstrations,
    skill=lt.ProMP().fit(demonstrations),  # shows how far the six differ
    goal=planned.positions[-1],
    obstacles=[box],
    html=folder / "look.html",
    title="Around a box",
)
print(f"wrote {folder / 'look.html'}")

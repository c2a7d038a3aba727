"""Objects at the prompt: summaries, values between samples, pictures in a notebook.

Writes notebook.html, the drawings that a notebook shows, and skill.png:
python python/demos/24_objects_at_the_prompt.py [FOLDER]
"""

import sys
from pathlib import Path

import numpy as np

import leadthrough as lt

folder = Path(next((word for word in sys.argv[1:] if word[0] != "-"), "."))
arm = lt.Arm.load("panda")

# Four hands carry something over a table and let it go; in m.
rng = np.random.default_rng(2)
times = np.linspace(0.0, 4.0, 200)
way = lt.trajectories.minimum_jerk_time_scaling(times / 4.0)
shown = []
for _ in range(4):
    first, last = rng.normal([(0.40, -0.30, 0.18), (0.50, 0.30, 0.22)], 0.01)
    path = first + np.outer(way, last - first)
    path[:, 2] += rng.normal(0.25, 0.03) * np.sin(np.pi * way) ** 2
    down = np.tile((0.0, 1.0, 0.0, 0.0), (len(times), 1))
    shown.append(lt.PoseTrajectory(times, path, down, [lt.Event(3.9, "open gripper")]))

skill = lt.ProMP().fit(shown)
motion = skill.generate()
joints = lt.retime(arm.follow(motion), arm.limits, rate=250)
table = lt.Box((1.0, 1.0, 0.1), (0.6, 0.0, -0.05))
answers = [arm, skill, motion, joints, lt.check_limits(joints, arm.limits)]
answers.append(arm.check(joints, [table]))

for answer in answers:
    print(repr(answer))

position, orientation = motion.at(2.0)
print(f"after 2 s: {np.round(position, 3)} m; {len(motion)} samples")
lift = motion[: len(motion) // 2]
print(f"the first half: {lift.duration:.2f} s, up to z = {lift.positions[-1, 2]:.2f} m")

try:
    lt.DMP().generate()
except lt.errors.NotFitted as error:
    print(error)

folder.mkdir(parents=True, exist_ok=True)
drawings = "".join(answer._repr_html_() for answer in answers)
(folder / "notebook.html").write_text(f"<!doctype html><meta charset=utf-8>{drawings}")
skill.plot().savefig(folder / "skill.png")
for name in ("notebook.html", "skill.png"):
    print(f"wrote {folder / name}")

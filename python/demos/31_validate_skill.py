"""Validation of a skill: success rate of a Panda for random goals and a random obstacle.

Writes certified.npz and report.html: python python/demos/31_validate_skill.py [FOLDER]
"""

import sys
from pathlib import Path

import numpy as np

import leadthrough as lt
from leadthrough.validation import SamplingPlan, TargetRegion

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
arm = lt.Arm.load("panda")
phase = np.linspace(0.0, 1.0, 51)[:, None]
home = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7])
rows = home + phase**3 * (10 - 15 * phase + 6 * phase**2) * [0.6, 0.4, 0, 0.3, 0, 0.1, 0.2]
shown = lt.JointTrajectory(3.0 * phase[:, 0], rows, joint_names=arm.joint_names)
skill = lt.DMP(weights=20).fit([arm.poses(shown)])

goal = skill.generate().positions[-1]
ball = lt.Sphere(0.04, (0.5, 0.1, 0.8))
found = lt.validate(
    skill,
    arm,
    [lt.shapes.RandomObstacle(ball, (0.05, 0.2, 0.05))],
    goals=TargetRegion.around(goal, (0.15, 0.15, 0.1)),
    plan=SamplingPlan(20, required=0.4),  # or width=0.05: as many as the interval needs
)
print(found)
for cause, count in found.certificate.causes.items():
    print(f"  {count} {cause}")
print(f"holds in: {found.certificate.holds}")
if found.nearest:
    print(f"nearest failure: goal {found.nearest.goal[:3].round(3)}, {found.nearest.detail}")

lt.show.write_validation(folder, found)
file = folder / "certified.npz"
skill.certified(found.certificate).save(file)
print(f"wrote {file} and {folder / 'report.html'}")
loaded = lt.load_skill(file)
assert loaded.certificate is not None
for moved in (0.05, 0.5):
    there = np.add(goal, (0.0, moved, 0.0))
    reasons = loaded.certificate.outside(
        start=loaded.certificate.starts.middle, goal=there, obstacles=[ball]
    )
    print(f"goal {there.round(3)}: {'; '.join(reasons) or 'inside'}")

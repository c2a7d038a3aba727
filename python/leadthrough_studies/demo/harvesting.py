"""A TIAGo picks a fruit that hangs between four at which it was shown how, and puts it in a crate.

The task and its simulated person are those of the agriculture study.
"""

from __future__ import annotations

from leadthrough.arm import FollowOptions
from leadthrough.models import DMP
from leadthrough.motion import Demonstration
from leadthrough.shapes import Box, Scene
from leadthrough.timing import check_limits, retime
from leadthrough_studies.agriculture.skills import chain, learn
from leadthrough_studies.agriculture.tasks import CORNERS, TASKS, amid, floor, load_arm
from leadthrough_studies.demo.performed import Performed

_TASK = "harvesting"
_RATE = 250.0  # Hz
_CELL = (0, 1, 3, 4)  # the targets around the fruit
_CRATE = Box((0.3, 0.3, 0.35), (0.36, -0.42, 0.175))


def run(seed: int = 0) -> Performed:
    """The scene, from demonstrations to joints.

    Args:
        seed: of the simulated person.
    """
    arm = load_arm()
    learned = learn(arm, _TASK, DMP(), _CELL, seed=seed)
    fruit = amid(_TASK, CORNERS[0])
    whole = chain(learned, fruit, lookup="interpolated")
    around = [floor(), _CRATE]
    followed = arm.follow(whole.poses, options=FollowOptions(posture=whole.joints), scene=around)
    joints = retime(followed, arm.limits, rate=_RATE, path_tolerance=1e-3)
    return Performed(
        name="Harvesting",
        told="A TIAGo reaches for a fruit, twists it off, puts it into a crate and goes home.",
        model="DMP",
        learned_from=f"{len(learned.shown)} demonstrations by a simulated person: "
        f"{len(TASKS[_TASK])} steps for {len(_CELL)} fruits",
        asked="a fruit between those that were shown",
        arm=arm,
        demonstrations=tuple(Demonstration(each.poses) for each in learned.shown.values()),
        joints=joints,
        limits=check_limits(joints, arm.limits),
        clearance=arm.check(joints, Scene(around, margin=0.0), tolerance=1e-3),
        obstacles=(_CRATE,),
        goal=fruit,
    )

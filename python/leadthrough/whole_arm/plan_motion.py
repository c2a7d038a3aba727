"""From a skill and an arm to a motion that the whole arm can run."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import KDTree

from leadthrough import check
from leadthrough.arm import Arm
from leadthrough.arm.options import Axis
from leadthrough.errors import IkFailure
from leadthrough.models.protocol import Place, Skill
from leadthrough.motion import Motion
from leadthrough.shapes import Shape, check_shapes
from leadthrough.whole_arm.planned_motion import PlannedMotion
from leadthrough.whole_arm.room import Room
from leadthrough.whole_arm.tip_paths import TipMotion, TipPaths

# Failures to follow that another path of the tip may cure.
_NO_ROOM = ("blocked", "jump")
_SIX = 6  # joints, with which an arm can have any position and orientation


def plan_motion(
    skill: Skill[Motion],
    arm: Arm,
    *,
    start: Place | None = None,
    goal: Place | None = None,
    obstacles: Iterable[Shape] = (),
    margin: float = 0.005,
    self_margin: float = 0.0,
    duration: float | None = None,
    dt: float = 0.01,
    seed: ArrayLike | None = None,
    posture: Motion | ArrayLike | None = None,
    free: Sequence[Axis] | None = None,
    position_tolerance: float = 1e-5,
    orientation_tolerance: float = 1e-5,
    rounds: int = 12,
) -> PlannedMotion:
    """A motion of the skill with which the whole arm keeps clear, between samples too.

    The skill makes the path of the tip, and the arm follows it with what the task leaves free.
    Where that leaves the arm no room, the tip gives way: in the map of a Fast Marching skill the
    places are closed from which the arm cannot stand clear, and the path is planned anew; the path
    of any other skill is moved aside there, by little first.

    Args:
        skill: any skill of poses, of points in 3-D, or of the arm's joints.
        arm: that is to move.
        start: where the motion starts, as `skill.generate` takes it.
        goal: where it ends, likewise.
        obstacles: shapes in the base frame. A skill that supports obstacles takes the tip around
            them.
        margin: distance in m that the arm keeps from obstacles, >= 0.
        self_margin: distance in m that parts of the arm keep from each other, >= 0, where there
            are obstacles.
        duration: s, > 0, by default the skill's.
        dt: s, > 0, upper bound of the sampling step.
        seed: configuration (joints,) near to which the motion starts.
        posture: as `Arm.follow` takes it.
        free: axes of the tip's poses left free, as there.
        position_tolerance: error in m that counts as reached, > 0.
        orientation_tolerance: error in rad that counts as reached, > 0.
        rounds: how often the path of the tip may be planned, >= 1.

    Raises:
        InvalidInput: if an argument is wrong.
        UnsupportedQuery: for a part of the query that the skill does not support.
        NoPath: where obstacles leave the tip no way.
        IkFailure: where the arm cannot follow, also after the path was changed; with the place, the
            reason and, where obstacles are in the way, the bodies.
    """
    shapes = check_shapes(obstacles)
    most = check.integer(rounds, "rounds", at_least=1)
    query: dict[str, Any] = {"start": start, "goal": goal, "duration": duration, "dt": dt}
    query = {name: value for name, value in query.items() if value is not None}
    following: dict[str, Any] = {
        "seed": seed,
        "posture": posture,
        "free": free,
        "position_tolerance": position_tolerance,
        "orientation_tolerance": orientation_tolerance,
        "obstacles": shapes,
        "margin": margin,
        "self_margin": self_margin,
    }
    paths = TipPaths(skill, query, Room(arm, shapes, margin, self_margin, _free_of(arm, free)))
    path = learned = paths.first()
    reasons: list[str] = []
    while True:
        try:
            joints = arm.follow(path, **following)
            break
        except IkFailure as failure:
            if not shapes or failure.status not in _NO_ROOM or len(reasons) + 1 >= most:
                raise
            path = paths.another(path, failure)
            reasons.append(str(failure))
    clearance = arm.check(joints, shapes).obstacles.minimum_distance if shapes else np.inf
    return PlannedMotion(joints, path, _farthest(path, learned), clearance, tuple(reasons))


def _free_of(arm: Arm, free: Sequence[Axis] | None) -> tuple[Axis, ...]:
    """The axes free where the arm stands: of fewer than six joints, it turns as it has to."""
    if free is None and len(arm.joint_names) < _SIX:
        return ("rx", "ry", "rz")
    return tuple(free or ())


def _farthest(path: TipMotion, learned: TipMotion) -> float:
    """How far a path is from another one at the most, m."""
    if path is learned:
        return 0.0
    return float(KDTree(learned.positions).query(path.positions)[0].max())

"""From a skill and an arm to a motion that the whole arm can run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.arm import Arm, FollowOptions, HeldObject, check_arm
from leadthrough.check import IkFailure, InvalidInput, ShortRepr
from leadthrough.models.protocol import Distributed, Skill, check_skill
from leadthrough.motion import JointTrajectory, Motion, PoseTrajectory, Trajectory, normalised_times
from leadthrough.motion_planning.bypass import bypass
from leadthrough.motion_planning.tip_paths import CollisionFreeIk, Query, TipMotion, TipPaths
from leadthrough.shapes import Scene, SceneLike, as_scene

LastResort = Literal["joint_space"]

# Failures to follow that another path of the tip may cure.
_NO_ROOM = ("blocked", "jump")


def plan_motion(
    skill: Skill[Motion],
    arm: Arm | HeldObject,
    scene: SceneLike | None = None,
    query: Query | None = None,
    *,
    q0: ArrayLike | None = None,
    options: FollowOptions | None = None,
    deviation: Deviation | None = None,
    standard_deviations: float | None = None,
    rounds: int = 12,
    last_resort: LastResort | None = None,
) -> PlannedMotion:
    """A motion of the skill with which the whole arm keeps clear, between samples too.

    The skill makes the path of the tip, and the arm follows it with what the task leaves free.
    If that blocks the arm, the tip gives way. First within `deviation` or
    `standard_deviations`, if one is given; then in the map of a Fast Marching skill the
    cells without a collision-free configuration are closed, and the path is planned anew; the path
    of any other skill is moved aside there, in small steps.

    Args:
        skill: any skill of poses, of points in 3-D, or of the arm's joints.
        arm: an arm, or an object that two arms hold, `lt.arm.HeldObject(pair, grasps)`: then the
            object is the tip.
        scene: to keep clear of, by its margins and 0.2 mm more, so that the answer passes
            `arm.check` with the same scene. A skill that supports obstacles takes the tip around
            them. Without a scene nothing is kept clear of.
        query: start, goal, duration and sampling step; by default the demonstrated ones.
        q0: configuration (joints,) near to which the motion starts.
        options: preferred posture, free axes and tolerances, as `Arm.follow` takes them.
        deviation: the most that the tip may be away from a path of the skill's, (m, rad), without
            another path being made; as `Arm.follow` takes it with obstacles.
        standard_deviations: the same as a number of standard deviations of the skill, > 0, of
            positions and orientations; of a ProMP or a GMR.
        rounds: how often the path of the tip may be planned, >= 1.
        last_resort: action if no path of the tip was found that the arm can follow.
            None: raise IkFailure.
            "joint_space": follow the first path up to where the arm is blocked, go on through
            joint space to where it is free again, found by RRT-Connect and certified by the same
            check, and follow the rest. The arm stops at the corners of that way, and its
            tip goes anywhere: the answer's `connected` says when.

    Raises:
        UnsupportedQuery: for a part of the query that the skill does not support.
        NoPath: if obstacles leave the tip no path.
        IkFailure: if the arm cannot follow, also after the path was changed; with the place, the
            reason and, if obstacles block it, the bodies.
    """
    single = _single(
        arm, deviation=deviation, standard_deviations=standard_deviations, last_resort=last_resort
    )
    check_skill(skill)
    around = None if scene is None else as_scene(scene)
    if not isinstance(query, Query | None):
        raise check.refused("query", "a Query", query)
    most = check.integer(rounds, "rounds", at_least=1)
    if last_resort is not None:
        check.choice(last_resort, "last_resort", get_args(LastResort))
    allowed = allowed_deviation(skill, deviation, standard_deviations)
    chosen = FollowOptions() if options is None else options
    following: dict[str, Any] = {"q0": q0, "options": chosen, "scene": around}
    ik = CollisionFreeIk(arm, Scene() if around is None else around, chosen.free)
    paths = TipPaths(skill, Query() if query is None else query, ik)
    path = learned = paths.first()
    failures: list[IkFailure] = []
    connected = None
    while True:
        try:
            joints = arm.follow(path, **following)
            break
        except IkFailure as failure:
            if around is None or failure.status not in _NO_ROOM:
                raise
            failures.append(failure)
        if single is not None and (beside := allowed(path)) is not None:
            try:
                joints = single.follow(path, deviation=beside, **following)
                path = tip_motion(single, path, joints)
                break
            except IkFailure as failure:
                failures[-1] = failure
        try:
            if len(failures) >= most:
                raise failures[-1]
            path = paths.another(path, failures[-1])
        except IkFailure:
            if last_resort is None:
                raise
            joints, path, connected = bypass(ik, learned, failures[0], following)
            break
    clearance = np.inf
    if ik.scene.obstacles:
        clearance = arm.check(joints, ik.scene).obstacles.minimum_distance
    reasons = tuple(str(failure) for failure in failures)
    return PlannedMotion(joints, path, _farthest(path, learned), clearance, reasons, connected)


def _single(arm: Arm | HeldObject, **leaving: object) -> Arm | None:
    """The arm; None for two with an object, which refuse what lets it leave its path."""
    if not isinstance(arm, HeldObject):
        check_arm(arm)
        return arm
    for name, value in leaving.items():
        if value is not None:
            raise check.refused(name, "None for an object that two arms hold", repr(value))
    return None


def _farthest(path: TipMotion, learned: TipMotion) -> float:
    """Largest distance of a path from another one, m."""
    from scipy.spatial import KDTree

    if path is learned:
        return 0.0
    return float(KDTree(learned.positions).query(path.positions)[0].max())


@dataclass(frozen=True, eq=False)
class PlannedMotion(ShortRepr):
    """A motion that the whole arm can run.

    Attributes:
        joints: along the path, certified clear between samples.
        tip: the motion that the tip goes through.
        deviation: the most that the tip is away from the path that the skill makes of the same
            query for the tip alone, m; 0 where the arm could follow it.
        clearance: the least distance of the arm from the obstacles between samples too, m; infinite
            without obstacles.
        reasons: why the tip had to leave that path, one line for each time that it was changed.
        connected: when the arm goes through joint space, with its tip anywhere, from and to, s;
            None where it does not.
    """

    joints: JointTrajectory
    tip: Trajectory | PoseTrajectory
    deviation: float
    clearance: float
    reasons: tuple[str, ...]
    connected: tuple[float, float] | None = None

    @property
    def rounds(self) -> int:
        """Number of plans of the tip's path."""
        return len(self.reasons) + 1


Deviation = tuple[ArrayLike, ArrayLike]
_SPACE = 3  # coordinates of a position


def allowed_deviation(
    skill: Skill[Motion], deviation: Deviation | None, standard_deviations: float | None
) -> Callable[[TipMotion], Deviation | None]:
    """The deviation allowed from a path, by path, as `Arm.follow` takes it."""
    if standard_deviations is None:
        return lambda _: deviation
    if deviation is not None:
        raise InvalidInput(
            "deviation: not used together with standard_deviations; give one of the two"
        )
    count = check.number(standard_deviations, "standard_deviations", above=0.0)
    coordinates = skill.coordinates if isinstance(skill, Distributed) else None
    if coordinates is None or coordinates.kind == "joints" or coordinates.size != _SPACE:
        raise InvalidInput(
            "standard_deviations: this skill has no covariance of the tip's positions; use a "
            "ProMP or GMR of poses or points in 3-D, or state deviation=(m, rad)"
        )
    return lambda path: _spread_deviation(skill, path, count)


def _spread_deviation(skill: Skill[Motion], path: TipMotion, count: float) -> Deviation:
    """The deviation from a path that the skill's covariance allows."""
    assert isinstance(skill, Distributed)
    _, covariance = skill.distribution(normalised_times(path.times) * skill.duration)
    allowed = count**2 * covariance
    if isinstance(path, PoseTrajectory) and allowed.shape[1] > _SPACE:
        return allowed[:, :_SPACE, :_SPACE], allowed[:, _SPACE:, _SPACE:]
    return allowed[:, :_SPACE, :_SPACE], 0.0


def tip_motion(arm: Arm, path: TipMotion, joints: JointTrajectory) -> TipMotion:
    """The motion that the tip goes through, with the path's times and events."""
    positions, orientations = arm.forward_kinematics(np.asarray(joints.positions))
    if isinstance(path, PoseTrajectory):
        return replace(path, positions=positions, orientations=orientations)
    return replace(path, positions=positions)

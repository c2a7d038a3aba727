"""Joint trajectories along a motion of the tip.

The path is solved sample after sample, each from the one before, so the arm never jumps to
another posture. If its velocity and acceleration limits are too low for the motion's pace, as
beside a singularity, one of three must yield: the limits, the times or the path.

Sources: Nakamura and Hanafusa 1986 for the damped step; Pham and Pham 2018 for the slowing.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check
from leadthrough.arm import tracking
from leadthrough.arm.ik_failure import failure, require_reachable, with_reason
from leadthrough.arm.inverse_kinematics import Axis, free_axes, tolerance
from leadthrough.arm.limits import JointLimits, known_acceleration
from leadthrough.arm.model import ArmModel
from leadthrough.arm.recorded_joints import demonstrated_joints, reach_ends
from leadthrough.arm.tip_path import CollisionTest, TipPath, Track, tube_around
from leadthrough.arm.tracking import Start, Tracker, best_track, off_branch, starts
from leadthrough.check import Float64Array, InvalidInput, LimitsInfeasible, ShortRepr
from leadthrough.motion import (
    JointTrajectory,
    Motion,
    PoseTrajectory,
    Trajectory,
    in_order,
    lerp,
    moved_events,
    normalised_times,
    with_derivatives,
)

OnRateLimit = Literal["slow", "deviate", "raise", "exceed_limits"]
_IN_TIME: tuple[OnRateLimit, ...] = ("deviate", "raise")
# Default rates, 1/s, of the motion in the null space: towards a posture, and along demonstrated
# joints, which a slower one would trail behind.
_RATE, _DEMONSTRATED_RATE = 1.0, 10.0
# Default tolerances, m and rad: everywhere, and where they keep the branch of demonstrated joints.
_TOLERANCES, _BRANCH_TOLERANCES = (1e-5, 1e-5), (2e-3, 0.05)
_SHOWN_TOLERANCES = (1e-4, 1e-3)  # if these joints are on the path already


@dataclass(frozen=True, eq=False, kw_only=True)
class FollowOptions(ShortRepr):
    """Options of `Arm.follow`, and of whatever follows a motion; make them once and pass them on.

    Attributes:
        posture: the configuration (joints,) towards which a redundant arm moves in its null space;
            or a JointTrajectory, taken at the same fraction of its duration. By default the
            motion's own `joints`, those that the arm was demonstrated with, if they are this arm's;
            otherwise the middle of the joints' ranges. Without q0 the search starts where a
            trajectory begins. Only where the motion's own joints lead to a dead end does the arm
            start in another posture.
        nullspace_gain: rate in 1/s, >= 0, of the motion towards `posture`; by default 1, and 10
            towards the motion's own joints.
        free: axes of the poses left free, as in `IkOptions`. By default none; an arm of fewer than
            six joints that cannot follow frees as many rotations as it lacks joints, about the axes
            of the tip, or all three, whichever gives the smallest orientation error that way.
            `path_report` reports the error.
            Only with "slow" and "exceed_limits".
        max_step: the most that a joint may move between two samples, rad or m, > 0; a larger step
            is a jump.
        position_tolerance: error in m that counts as reached, > 0; by default 1e-5. All samples but
            those beside a singularity come ten times closer. By default a motion of poses may be
            missed there by 2e-3 where that keeps the arm near the motion's own joints, which the
            exact path would leave by more than 1 rad or a jump; and by 1e-4 where it would leave
            them by more than 0.1 rad though they are on it to 1e-3; `path_report` says by how much.
        orientation_tolerance: error in rad that counts as reached, > 0; the same holds, with 0.05
            and 1e-3.
    """

    posture: Motion | ArrayLike | None = None
    nullspace_gain: float | None = None
    free: Collection[Axis] | None = None
    max_step: float = 0.5
    position_tolerance: float | None = None
    orientation_tolerance: float | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.posture, Motion | None):
            posture = check.frozen(self.posture, "posture", shape=("joints",))
            object.__setattr__(self, "posture", posture)
        if self.nullspace_gain is not None:
            check.number(self.nullspace_gain, "nullspace_gain", at_least=0.0)
        if self.free is not None:
            free_axes(self.free)
        check.number(self.max_step, "max_step", above=0.0)
        tolerance(*self.tolerances)

    @property
    def tolerances(self) -> tuple[float, float]:
        """Errors in m and rad that count as reached."""
        return self._stated_or(_TOLERANCES)

    @property
    def branch_tolerances(self) -> tuple[float, float]:
        """Errors in m and rad that are allowed to keep near the motion's own joints."""
        return self._stated_or(_BRANCH_TOLERANCES)

    @property
    def shown_tolerances(self) -> tuple[float, float]:
        """Errors in m and rad that are allowed to stay where the motion's own joints are."""
        return self._stated_or(_SHOWN_TOLERANCES)

    def _stated_or(self, default: tuple[float, float]) -> tuple[float, float]:
        stated = self.position_tolerance, self.orientation_tolerance
        position, orientation = (
            b if a is None else a for a, b in zip(stated, default, strict=True)
        )
        return position, orientation


def reachable_start(
    arm: ArmModel,
    motion: Trajectory | PoseTrajectory,
    q0: ArrayLike | None,
    options: FollowOptions,
) -> Float64Array | None:
    """A checked q0; an unreachable motion is refused before its samples are solved."""
    path = TipPath.of(motion)
    start = None if q0 is None else check.array(q0, "q0", shape=(arm._chain.joints,))
    joints = demonstrated_joints(arm._chain, motion)
    ends = (None, None) if joints is None else tuple(joints.positions[[0, -1]])
    near = (ends[0] if start is None else start, ends[1])
    shown = joints is not None and reach_ends(arm._chain, joints, motion, options.branch_tolerances)
    allowed = options.branch_tolerances if shown else options.tolerances
    require_reachable(arm, path, free=options.free, tolerances=allowed, near=near)
    return start


def follow(
    arm: ArmModel,
    motion: Trajectory | PoseTrajectory,
    *,
    q0: Float64Array | None,
    on_rate_limit: OnRateLimit = "slow",
    deviation: tuple[ArrayLike, ArrayLike] | None = None,
    options: FollowOptions,
    around: CollisionTest | None = None,
) -> JointTrajectory:
    """Joints along a motion whose ends can be reached."""
    if around is not None and on_rate_limit in _IN_TIME:
        raise InvalidInput(
            f"scene: not used together with on_rate_limit={on_rate_limit!r}; use 'slow' or "
            "'exceed_limits'"
        )
    chain = arm._chain
    tip = TipPath.of(motion)
    joints = demonstrated_joints(chain, motion) if options.posture is None else None
    preferred = options.posture if joints is None else joints
    path = replace(tip, postures=_postures(chain, preferred, tip.times))
    if around is not None and deviation is not None:
        path = replace(path, tube=tube_around(path, deviation))
    near = path.postures[0] if q0 is None and isinstance(preferred, JointTrajectory) else q0
    tracker = Tracker(chain, path, arm.limits, options.tolerances, options.max_step)
    check.choice(on_rate_limit, "on_rate_limit", get_args(OnRateLimit))
    in_time = on_rate_limit in _IN_TIME
    freedoms = tracking.axes_to_try(path, options.free, joints=chain.joints, in_time=in_time)
    allowed = _deviation(deviation if around is None else None, on_rate_limit, options.tolerances)
    default = _RATE if joints is None else _DEMONSTRATED_RATE
    rate = default if options.nullspace_gain is None else options.nullspace_gain
    branch = None
    exact = freedoms == [()] and len(path.orientations) > 0 and path.dimension <= chain.joints
    if near is not None and near is not q0 and exact and not in_time:
        branch = tracking.branch_track(tracker, near, rate, options.branch_tolerances)
    track, free = branch, freedoms[0]
    if track is None or track.reached < len(path):
        others = joints is not None and q0 is None
        track, free = _furthest(
            [replace(tracker, path=replace(path, free=axes)) for axes in freedoms],
            lambda freed: starts(freed, near, rate, others=others),
            lambda freed: _track_function(freed, on_rate_limit, allowed),
            allowed,
        )
    if joints is not None and q0 is None and options.free is None and not in_time:
        track = tracking.as_demonstrated(
            tracker, track, leaving=options.shown_tolerances, ending=options.branch_tolerances
        )
    q = track.q
    if track.reached < len(path) or (around is not None and not around.clear_along(q)):
        # An arm of few joints goes around obstacles by turning its tip away.
        ahead = replace(tracker, path=replace(path, free=free or freedoms[-1]))
        searched = None if in_time else ahead.searched(q0, around)
        if searched is None:
            status = "rate_limit" if in_time else "jump"
            followed = replace(path, free=free)
            missed = failure(chain, arm.limits, followed, track, otherwise=status)
            if branch is not None and branch.reached < len(path):
                missed = with_reason(missed, off_branch(branch))
            raise missed
        q = searched
    return timed(arm.limits, motion, q, on_rate_limit)


def _furthest(
    trackers: Sequence[Tracker],
    starts_of: Callable[[Tracker], Iterable[Start]],
    track_function: Callable[[Tracker], Callable[[Start], Track]],
    allowed: tuple[float, float],
) -> tuple[Track, tuple[Axis, ...]]:
    """Of the trackers' best tracks, the furthest, then the least rotated; its free axes."""
    tracks: list[Track] = []
    for tracker in trackers:
        tracks.append(best_track(tracker, starts_of(tracker), track_function(tracker), allowed))
        if tracks[-1].reached == len(tracker.path) and not tracker.path.free:
            break
    track = tracking.least_rotated(trackers[0].chain, trackers[0].path, tracks)
    return track, trackers[tracks.index(track)].path.free


def _track_function(
    tracker: Tracker, on_rate_limit: OnRateLimit, allowed: tuple[float, float]
) -> Callable[[Start], Track]:
    """How to follow a path from a start."""
    if on_rate_limit == "raise":
        return lambda start: tracker.in_time(start, 0.0, allowed)
    if on_rate_limit == "deviate":
        return lambda start: tracker.deviating(start, allowed)
    return tracker.along


def timed(
    limits: JointLimits,
    motion: Motion,
    q: Float64Array,
    on_rate_limit: OnRateLimit,
) -> JointTrajectory:
    """Joints (n, joints) with times, velocities and the motion's events."""
    times = motion.times
    if on_rate_limit == "slow":
        times = slowed(times, q, limits)
    velocities = velocities_of(times, q)
    if on_rate_limit != "exceed_limits":
        velocities[[0, -1]] = 0.0
    moved = moved_events(motion.events, motion.times, times)
    joints = JointTrajectory(times, q, velocities, joint_names=limits.joint_names, events=moved)
    return with_derivatives(joints)


def checked_options(options: FollowOptions | None) -> FollowOptions:
    if options is None:
        return FollowOptions()
    if not isinstance(options, FollowOptions):
        raise InvalidInput(f"options: expected FollowOptions, got {options!r}")
    return options


def slowed(times: Float64Array, q: Float64Array, limits: JointLimits) -> Float64Array:
    """The times, stretched where joints (n, joints) would exceed their rate limits."""
    stretched, stuck = core.slow_down(times, q, limits.velocity, known_acceleration(limits))
    if stuck >= 0:
        joint = limits.joint_names[stuck]
        raise LimitsInfeasible(
            f"{joint} has to move, but its velocity or acceleration limit is 0", joint=joint
        )
    return stretched


def velocities_of(times: Float64Array, q: Float64Array) -> Float64Array:
    """Time differences of joints (n, joints), of second order."""
    if len(times) == 1:
        return np.zeros_like(q)
    return np.asarray(np.gradient(q, times, axis=0, edge_order=2 if len(times) > 2 else 1))


def _postures(
    chain: core.Chain, posture: Motion | ArrayLike | None, times: Float64Array
) -> Float64Array:
    """The configuration (n, joints) that the arm should keep close to at each of the times."""
    joints = len(chain.joint_names)
    if not isinstance(posture, JointTrajectory):
        if isinstance(posture, Motion):
            raise InvalidInput(
                f"posture: expected joints or a JointTrajectory, got a {type(posture).__name__}"
            )
        if posture is None:
            with np.errstate(invalid="ignore"):  # without limits there is no middle
                preferred = 0.5 * chain.lower + 0.5 * chain.upper
        else:
            preferred = check.array(posture, "posture", shape=(joints,))
        return np.repeat(preferred[None], len(times), axis=0)
    posture = in_order(posture, chain.joint_names, "posture")
    at = posture.times[0] + normalised_times(times) * posture.duration
    return lerp(at, posture.times, posture.positions)


def _deviation(
    deviation: tuple[ArrayLike, ArrayLike] | None,
    on_rate_limit: OnRateLimit,
    allowed: tuple[float, float],
) -> tuple[float, float]:
    """The most that the tip may be away from a sample, m and rad."""
    if on_rate_limit != "deviate":
        if deviation is not None:
            raise InvalidInput(
                "deviation: only used with a scene or with on_rate_limit='deviate'; remove it or "
                "give one of the two"
            )
        return allowed
    if deviation is None:
        raise check.refused(
            "deviation", "the most that the tip may be away from the path, (m, rad)", "None"
        )
    position, orientation = check.array(deviation, "deviation", shape=(2,))
    return positive_errors(position, orientation, "deviation")


def positive_errors(position: object, orientation: object, name: str) -> tuple[float, float]:
    """Errors > 0 of a position in m and of an orientation in rad."""
    return (
        check.number(position, f"{name} in m", above=0.0),
        check.number(orientation, f"{name} in rad", above=0.0),
    )

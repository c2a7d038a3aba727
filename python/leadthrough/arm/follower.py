"""Joint trajectories along a motion of the tip.

The path is solved sample after sample, each from the one before, so the arm never jumps to
another posture. Where its velocity and acceleration limits are too low for the motion's pace, as
beside a singularity, one of three must yield: the limits, the times or the path.

Sources: Nakamura and Hanafusa 1986 for the damped step; Pham and Pham 2018 for the slowing.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import _core, check, events
from leadthrough.arm.clearing import CollisionTest, clear_path
from leadthrough.arm.first_posture import Start, first_postures, seeded
from leadthrough.arm.freedom import axes_to_try, least_turned
from leadthrough.arm.limits import JointLimits, known_acceleration
from leadthrough.arm.missed import failure
from leadthrough.arm.options import Axis, free_axes, tolerance
from leadthrough.arm.recorded import shown_joints
from leadthrough.arm.tracks import TipPath, Track
from leadthrough.arm.tube import tube_around
from leadthrough.check import Float64Array
from leadthrough.errors import IkFailure, InvalidInput, LimitsInfeasible
from leadthrough.motion import (
    JointTrajectory,
    Motion,
    PoseTrajectory,
    Trajectory,
    normalised_times,
)

_SAMPLE_ITERATIONS = 60
# Rates, 1/s, of the motion in the null space: towards a wish, and along joints that were shown,
# which a slower one would trail behind.
_USUAL_RATE, _SHOWN_RATE = 1.0, 10.0
# Damping to try where the arm may leave the path, m^2 per rad^2: from none to (0.1 m per rad)^2,
# which halves the step of a joint that moves the tip by 0.1 m per rad.
_DAMPINGS = (0.0, 1e-5, 1e-4, 1e-3, 1e-2)

TooFast = Literal["slow", "deviate", "raise", "exceed_limits"]
_IN_TIME = ("deviate", "raise")


def follow(
    chain: _core.Chain,
    motion: Trajectory | PoseTrajectory,
    *,
    limits: JointLimits,
    seed: Float64Array | None,
    too_fast: TooFast = "slow",
    deviation: tuple[ArrayLike, ArrayLike] | None = None,
    max_step: float = 0.5,
    posture: Motion | ArrayLike | None = None,
    midrange: float | None = None,
    free: Sequence[Axis] | None = None,
    position_tolerance: float = 1e-5,
    orientation_tolerance: float = 1e-5,
    around: CollisionTest | None = None,
) -> JointTrajectory:
    """See `Arm.follow`."""
    tip = TipPath.of(motion)
    shown = shown_joints(chain, motion) if posture is None else None
    wished = posture if shown is None else shown
    path = replace(tip, postures=_postures(chain, wished, tip.times))
    if around is not None and deviation is not None:
        path = replace(path, tube=tube_around(path, deviation))
    nearby = path.postures[0] if seed is None and isinstance(wished, JointTrajectory) else seed
    allowed = (position_tolerance, orientation_tolerance)
    follower = _Follower(
        chain=chain,
        path=path,
        limits=limits,
        tolerance=tolerance(*allowed),
        allowed=allowed,
        max_step=check.number(max_step, "max_step", above=0.0),
    )
    check.choice(too_fast, "too_fast", get_args(TooFast))
    freedoms = axes_to_try(path, free, joints=len(chain.joint_names), in_time=too_fast in _IN_TIME)
    stated = _deviation(deviation if around is None else None, too_fast, allowed)
    usual = _USUAL_RATE if shown is None else _SHOWN_RATE
    rate = usual if midrange is None else check.number(midrange, "midrange", at_least=0.0)
    tracks = []
    for axes in freedoms:
        leaving = replace(follower, path=replace(path, free=axes))
        starts = _starts(leaving, nearby, rate, others=shown is not None and seed is None)
        tracks.append(_best(leaving, starts, too_fast, stated))
        if tracks[-1].reached == len(path) and not axes:
            break
    track = least_turned(chain, path, tracks)
    complete = track.reached == len(path)
    q = track.q
    if not complete or (around is not None and not around.clear_along(q)):
        followed = replace(path, free=freedoms[tracks.index(track)])
        # An arm of few joints goes around obstacles by turning its tip away.
        ahead = replace(follower, path=replace(path, free=followed.free or freedoms[-1]))
        searched = None if too_fast in _IN_TIME else ahead.searched(seed, around)
        if searched is None:
            on_the_way = "too_fast" if too_fast in _IN_TIME else "jump"
            raise failure(chain, limits, followed, track, on_the_way=on_the_way)
        q = searched
    times = slowed(chain, path.times, q, limits) if too_fast == "slow" else path.times
    velocities = velocities_of(times, q)
    if too_fast != "exceed_limits":
        velocities[[0, -1]] = 0.0
    return JointTrajectory(
        times,
        q,
        velocities,
        joint_names=tuple(chain.joint_names),
        events=events.moved(motion.events, path.times, times),
    )


@dataclass(frozen=True, eq=False)
class _Follower:
    chain: _core.Chain
    path: TipPath
    limits: JointLimits
    tolerance: _core.IkTolerance
    allowed: tuple[float, float]
    max_step: float

    def along(self, start: Start) -> Track:
        """The track along the path, at whatever speed that takes."""
        return self._track(start, self.path)

    def in_time(self, start: Start, damping: float, deviation: tuple[float, float]) -> Track:
        """The track along the path at the path's own pace, inside the limits."""
        first = self._track(start, self.path.only(slice(1)))
        options = _core.PursuitOptions(
            self.limits.velocity, known_acceleration(self.limits), damping, tolerance(*deviation)
        )
        columns = _core.pursue(
            self.chain,
            self.path.times,
            self.path.positions,
            self.path.orientations,
            first.q[0],
            *self.path.pull(start.midrange),
            options,
        )
        return Track.of(columns, deviation)

    def deviating(self, start: Start, deviation: tuple[float, float]) -> Track:
        """Of the tracks with several dampings, the one that stays nearest to the path."""
        tracks = []
        for damping in _DAMPINGS:
            tracks.append(self.in_time(start, damping, deviation))
            if _distance(tracks[-1], self.allowed) <= 1.0:
                break
        return min(tracks, key=lambda track: _rank(track, deviation))

    def searched(
        self, seed: Float64Array | None, around: CollisionTest | None
    ) -> Float64Array | None:
        """Joints (n, joints) found by looking ahead; None if there are none."""
        try:
            q = clear_path(self.chain, self.path, around, start=seed, tolerance=self.tolerance)
        except IkFailure as ended:
            if around is None:
                return None
            if ended.status != "jump":
                raise
            stuck = Track.standing(self.chain, self.path, ended.index, ended.q)
            raise failure(self.chain, self.limits, self.path, stuck, on_the_way="jump") from None
        leaps = np.abs(np.diff(q, axis=0)).max(initial=0.0) > self.max_step
        return None if leaps else q

    def _track(self, start: Start, path: TipPath) -> Track:
        axes = free_axes(path.free)
        options = _core.TrackOptions(self.tolerance, _SAMPLE_ITERATIONS, self.max_step, axes)
        pull = path.pull(start.midrange)
        columns = _core.track(
            self.chain, path.positions, path.orientations, start.q, *pull, options
        )
        return Track.of(columns, self.allowed)


def _postures(
    chain: _core.Chain, posture: Motion | ArrayLike | None, times: Float64Array
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
                wished = 0.5 * chain.lower + 0.5 * chain.upper
        else:
            wished = check.array(posture, "posture", shape=(joints,))
        return np.repeat(wished[None], len(times), axis=0)
    names = posture.joint_names
    if posture.positions.shape[1] != joints or names not in ((), tuple(chain.joint_names)):
        what = list(names) or posture.positions.shape[1]
        raise InvalidInput(
            f"posture: expected the joints {list(chain.joint_names)}, got {what}; "
            "in Python, Arm.joints_of picks the arm's joints of a recording"
        )
    at = posture.times[0] + normalised_times(times) * posture.duration
    return np.column_stack([np.interp(at, posture.times, column) for column in posture.positions.T])


def _deviation(
    deviation: tuple[ArrayLike, ArrayLike] | None, too_fast: TooFast, allowed: tuple[float, float]
) -> tuple[float, float]:
    """The most that the tip may be away from a sample, m and rad."""
    if too_fast != "deviate":
        if deviation is not None:
            raise InvalidInput(
                "deviation: only used with obstacles or with too_fast='deviate'; remove it or give "
                "one of the two"
            )
        return allowed
    if deviation is None:
        raise InvalidInput(
            "deviation: expected the most that the tip may be away from the path, (m, rad), "
            "got None"
        )
    position, orientation = check.array(deviation, "deviation", shape=(2,))
    return (
        check.number(position, "deviation in m", above=0.0),
        check.number(orientation, "deviation in rad", above=0.0),
    )


def _starts(
    follower: _Follower, seed: Float64Array | None, midrange: float, *, others: bool
) -> Iterator[Start]:
    """Where the path may start: next to the seed; without one, or as well, anywhere."""
    rate = midrange if len(follower.chain.joint_names) > follower.path.dimension else 0.0
    if seed is not None:
        yield from seeded(follower.chain, follower.path, seed, rate)
    if seed is None or others:
        yield from first_postures(
            follower.chain,
            follower.path,
            velocity=follower.limits.velocity,
            midrange=rate,
            tracking=(follower.tolerance, _SAMPLE_ITERATIONS, follower.max_step),
        )


def _best(
    follower: _Follower, starts: Iterable[Start], too_fast: TooFast, deviation: tuple[float, float]
) -> Track:
    """The first track that reaches the end and stays on the path, else the best one."""
    best: Track | None = None
    for start in starts:
        if too_fast in ("exceed_limits", "slow"):
            track = follower.along(start)
        elif too_fast == "raise":
            track = follower.in_time(start, 0.0, deviation)
        else:
            track = follower.deviating(start, deviation)
        if best is None or _rank(track, deviation) < _rank(best, deviation):
            best = track
        if best.reached == len(follower.path) and _distance(best, follower.allowed) <= 1.0:
            break
    assert best is not None
    return best


def _rank(track: Track, unit: tuple[float, float]) -> tuple[int, float]:
    return -track.reached, _distance(track, unit)


def _distance(track: Track, unit: tuple[float, float]) -> float:
    return float(
        max(track.position_errors.max() / unit[0], track.orientation_errors.max() / unit[1])
    )


def slowed(
    chain: _core.Chain, times: Float64Array, q: Float64Array, limits: JointLimits
) -> Float64Array:
    """The times, stretched where joints (n, joints) exceed velocity or acceleration limits."""
    stretched, stuck = _core.slow_down(times, q, limits.velocity, known_acceleration(limits))
    if stuck >= 0:
        joint = chain.joint_names[stuck]
        raise LimitsInfeasible(
            f"{joint} has to move, but its velocity or acceleration limit is 0", joint=joint
        )
    return stretched


def velocities_of(times: Float64Array, q: Float64Array) -> Float64Array:
    """Time differences of joints (n, joints), of second order."""
    if len(times) == 1:
        return np.zeros_like(q)
    return np.asarray(np.gradient(q, times, axis=0, edge_order=2 if len(times) > 2 else 1))

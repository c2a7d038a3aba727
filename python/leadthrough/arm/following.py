"""Joint trajectories along a motion of the tip.

The path is solved sample after sample, each from the one before, so the arm never jumps to
another posture. Where its limits of velocity and acceleration do not allow the motion's pace, as
beside a singularity, something has to give: the limits, the times or the path.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from leadthrough import _core, check, events
from leadthrough.arm.first_posture import Start, first_postures, seeded
from leadthrough.arm.limits import JointLimits
from leadthrough.arm.options import ik_options, tolerance
from leadthrough.arm.results import STATUSES
from leadthrough.arm.tracks import TipPath, Track, solve_sample
from leadthrough.check import Float64Array
from leadthrough.errors import IkFailure, InvalidInput, LimitsInfeasible
from leadthrough.motion import JointTrajectory, PoseTrajectory, Trajectory, normalised_times

_SAMPLE_ITERATIONS = 60
# Damping to try where the arm may leave the path, m^2: from none to (0.1 m)^2, by which a joint's
# step shortens to a half where it moves the tip 0.1 m a rad.
_DAMPINGS = (0.0, 1e-5, 1e-4, 1e-3, 1e-2)
_WHAT_GIVES = ("keep", "slow", "deviate", "raise")


def follow(
    chain: _core.Chain,
    motion: Trajectory | PoseTrajectory,
    *,
    limits: JointLimits,
    seed: Float64Array | None = None,
    too_fast: str = "keep",
    deviation: tuple[float, float] | None = None,
    max_step: float = 0.5,
    posture: Any = None,
    midrange: float = 1.0,
    position_tolerance: float = 1e-5,
    orientation_tolerance: float = 1e-5,
) -> JointTrajectory:
    """Joint positions and velocities that take the tip along `motion`, one sample for each of its.

    motion: poses, or points in 3-D that leave the orientation free.
    seed: (joints,), where the search for the first sample's posture starts; without it several
        are followed ahead, and the best is kept.
    too_fast: what gives where velocity and acceleration limits cannot keep the motion's pace.
        "keep": the limits; path and times are kept, for a time law to slow the motion down.
        "slow": the times; just there the motion is stretched, the path is kept.
        "deviate": the path; the tip falls behind by at most `deviation` and returns, on time.
        "raise": nothing, IkFailure with the status "too_fast".
        But for "keep" the arm starts and ends at rest, and an acceleration limit that is not known
        does not count. Between samples the joints move straight.
    deviation: m and rad, the most the tip may be away from a sample; with "deviate" only.
    max_step: the most a joint moves between two samples, rad or m; it makes the answer a path.
    posture: (joints,), or a JointTrajectory, taken at equal shares of the time: where a redundant
        arm moves itself, say as it stood while the motion was shown; by default towards the middle
        of its ranges. Where a trajectory begins, the first posture is searched for, without a seed.
    midrange: rate, 1/s, at which it does.
    position_tolerance, orientation_tolerance: m and rad, what counts as reached; all but samples
        beside a singularity come ten times closer.
    The velocities are the positions' differences in time (second order); accelerations are left
    to the time law. Events keep their samples.
    Raises InvalidInput; LimitsInfeasible where a joint moves that must not; IkFailure with the
    first sample that no posture reached, its status one of IkResult's, "too_fast", or "jump" where
    the pose can be reached but not from the sample before.
    Source: Nakamura and Hanafusa 1986 for the damped step; Pham and Pham 2018 for the slowing.
    """
    tip = TipPath.of(motion)
    path = replace(tip, postures=_postures(chain, posture, tip.times))
    if seed is None and isinstance(posture, JointTrajectory):
        seed = path.postures[0]
    allowed = (position_tolerance, orientation_tolerance)
    follower = _Follower(
        chain=chain,
        path=path,
        limits=limits,
        tolerance=tolerance(*allowed),
        allowed=allowed,
        max_step=check.number(max_step, "max_step", above=0.0),
    )
    gives = check.choice(too_fast, "too_fast", _WHAT_GIVES)
    stated = _deviation(deviation, gives, allowed)
    rate = check.number(midrange, "midrange", at_least=0.0)
    track = _best(follower, _starts(follower, seed, rate), gives, stated)
    if track.reached < len(path):
        raise _failure(follower, track, gives)
    times = _slowed(chain, path.times, track.q, limits) if gives == "slow" else path.times
    velocities = _velocities(times, track.q)
    if gives != "keep":
        velocities[[0, -1]] = 0.0
    happening = events.moved(motion.events, path.times, times)
    names = tuple(chain.joint_names)
    return JointTrajectory(times, track.q, velocities, None, names, happening)


@dataclass(frozen=True, eq=False)
class _Follower:
    chain: _core.Chain
    path: TipPath
    limits: JointLimits
    tolerance: _core.IkTolerance
    allowed: tuple[float, float]
    max_step: float

    def along(self, start: Start) -> Track:
        """The path, whatever speed that takes."""
        return self._track(start, self.path)

    def in_time(self, start: Start, damping: float, deviation: tuple[float, float]) -> Track:
        """The path at its own pace, inside the limits."""
        first = self._track(start, self.path.only(slice(1)))
        options = _core.PursuitOptions(
            self.limits.velocity, acceleration(self.limits), damping, tolerance(*deviation)
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
        """The track that stays nearest to the path, of several dampings."""
        tracks = []
        for damping in _DAMPINGS:
            tracks.append(self.in_time(start, damping, deviation))
            if _distance(tracks[-1], self.allowed) <= 1.0:
                break
        return min(tracks, key=lambda track: _rank(track, deviation))

    def _track(self, start: Start, path: TipPath) -> Track:
        options = _core.TrackOptions(self.tolerance, _SAMPLE_ITERATIONS, self.max_step)
        pull = path.pull(start.midrange)
        columns = _core.track(
            self.chain, path.positions, path.orientations, start.q, *pull, options
        )
        return Track.of(columns, self.allowed)


def _postures(chain: _core.Chain, posture: Any, times: Float64Array) -> Float64Array:
    """Where the arm is to stand at each of the times, (n, joints)."""
    joints = len(chain.joint_names)
    if not isinstance(posture, JointTrajectory):
        if posture is None:
            with np.errstate(invalid="ignore"):  # without limits there is no middle
                wished = 0.5 * chain.lower + 0.5 * chain.upper
        else:
            wished = check.array(posture, "posture", shape=(joints,))
        return np.repeat(wished[None], len(times), axis=0)
    names = posture.joint_names
    if posture.positions.shape[1] != joints or names not in ((), tuple(chain.joint_names)):
        what = list(names) or posture.positions.shape[1]
        raise InvalidInput(f"posture: expected the joints {list(chain.joint_names)}, got {what}")
    at = posture.times[0] + normalised_times(times) * posture.duration
    return np.column_stack([np.interp(at, posture.times, column) for column in posture.positions.T])


def acceleration(limits: JointLimits) -> Float64Array:
    """The acceleration limits, infinite where they are not known."""
    if limits.acceleration is None:
        return np.full(len(limits.joint_names), np.inf)
    return limits.acceleration


def _deviation(deviation: Any, gives: str, allowed: tuple[float, float]) -> tuple[float, float]:
    if gives != "deviate":
        if deviation is not None:
            raise InvalidInput('deviation: expected None but with too_fast="deviate"')
        return allowed
    if deviation is None:
        raise InvalidInput("deviation: expected the most the tip may be away, (m, rad), got None")
    position, orientation = check.array(deviation, "deviation", shape=(2,))
    return (
        check.number(position, "deviation in m", above=0.0),
        check.number(orientation, "deviation in rad", above=0.0),
    )


def _starts(follower: _Follower, seed: Float64Array | None, midrange: float) -> list[Start]:
    rate = midrange if len(follower.chain.joint_names) > follower.path.dimension else 0.0
    if seed is not None:
        return seeded(follower.chain, follower.path, seed, rate)
    return first_postures(
        follower.chain,
        follower.path,
        velocity=follower.limits.velocity,
        midrange=rate,
        tracking=(follower.tolerance, _SAMPLE_ITERATIONS, follower.max_step),
    )


def _best(
    follower: _Follower, starts: list[Start], gives: str, deviation: tuple[float, float]
) -> Track:
    """The track of the first start that reaches the end with nothing given up, else the best."""
    best: Track | None = None
    for start in starts:
        if gives in ("keep", "slow"):
            track = follower.along(start)
        elif gives == "raise":
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


def _slowed(
    chain: _core.Chain, times: Float64Array, q: Float64Array, limits: JointLimits
) -> Float64Array:
    slowed, stuck = _core.slow_down(times, q, limits.velocity, acceleration(limits))
    if stuck >= 0:
        joint = chain.joint_names[stuck]
        raise LimitsInfeasible(f"{joint} has to move, and its limits do not let it", joint=joint)
    return slowed


def _velocities(times: Float64Array, q: Float64Array) -> Float64Array:
    if len(times) == 1:
        return np.zeros_like(q)
    return np.asarray(np.gradient(q, times, axis=0, edge_order=2 if len(times) > 2 else 1))


def _failure(follower: _Follower, track: Track, gives: str) -> IkFailure:
    i, chain, path = track.reached, follower.chain, follower.path
    residual = (float(track.position_errors[i]), float(track.orientation_errors[i]))
    _, status, _ = solve_sample(chain, path, i, track.q[i : i + 1], ik_options())
    on_the_way = "jump" if gives in ("keep", "slow") else "too_fast"
    reason = STATUSES[status[0]] if status[0] else on_the_way
    hint = " (reachable, but not from the sample before)" if reason == on_the_way else ""
    message = (
        f"sample {i} at {path.times[i]:.6g} s: {reason}{hint}, "
        f"{residual[0]:.3g} m and {residual[1]:.3g} rad away"
    )
    return IkFailure(message, index=i, status=reason, residual=residual, q=track.q[i].copy())

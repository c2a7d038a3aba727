"""Joint trajectories along a motion of the tip.

The path is solved sample after sample, each from the one before, so the arm never jumps to
another posture. What remains free is the posture at the start: where no seed is given, several are
followed to the end, and of those that arrive the one is kept whose joints need the least slowing
down.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from leadthrough import _core, check
from leadthrough.arm.options import ik_options, tolerance
from leadthrough.arm.results import STATUSES
from leadthrough.check import Float64Array
from leadthrough.errors import IkFailure, InvalidInput
from leadthrough.motion import JointTrajectory, PoseTrajectory, Trajectory

# Postures to try at the start. An arm with a wrist has up to eight; a few of them repeat.
_STARTS = 24
# Two starts nearer than this in every joint are one, rad or m.
_SAME_POSTURE = 1e-2
_SAMPLE_ITERATIONS = 60


@dataclass(frozen=True, eq=False)
class _Task:
    times: Float64Array
    positions: Float64Array
    orientations: Float64Array  # no rows: free

    def first(self) -> tuple[Float64Array, Float64Array]:
        return self.positions[:1], self.orientations[:1]


@dataclass(frozen=True, eq=False)
class _Track:
    q: Float64Array
    status: NDArray[np.int32]
    position_errors: Float64Array
    orientation_errors: Float64Array

    @property
    def reached(self) -> int:
        """The first sample that was missed, or their number."""
        missed = np.flatnonzero(self.status)
        return int(missed[0]) if len(missed) else len(self.status)


def follow(
    chain: _core.Chain,
    motion: Trajectory | PoseTrajectory,
    *,
    velocity: Float64Array,
    seed: Float64Array | None = None,
    max_step: float = 0.5,
    speed_limit: float | None = None,
    midrange: float = 1.0,
    position_tolerance: float = 1e-5,
    orientation_tolerance: float = 1e-5,
) -> JointTrajectory:
    """Joint positions and velocities that take the tip along `motion`; its times are kept.

    motion: poses, or points in 3-D that leave the orientation free.
    velocity: (joints,) limits, rad/s (m/s).
    seed: (joints,), where the search for the first sample's posture starts.
    max_step: the most a joint moves between two samples, rad or m; it makes the answer a path.
    speed_limit: where given, the joints also keep below this multiple of `velocity` at the
        motion's own pace; without it a motion that is too fast is followed all the same, to be
        slowed down afterwards.
    midrange: rate, 1/s, at which a redundant arm moves itself towards the middle of its ranges.
    position_tolerance, orientation_tolerance: m and rad, what counts as reached; all but samples
        beside a singularity come ten times closer.
    The velocities are the positions' differences in time (second order); accelerations are left
    to the time law.
    Raises InvalidInput; IkFailure with the first sample that no posture reached, its status one of
    IkResult's, or "jump" where the pose can be reached but not from the sample before.
    Source: Nakamura and Hanafusa 1986 for the damped step.
    """
    task = _task(motion)
    options = _core.TrackOptions(
        tolerance(position_tolerance, orientation_tolerance), _SAMPLE_ITERATIONS
    )
    steps = _steps(task, velocity, max_step, speed_limit)
    rate = check.number(midrange, "midrange", at_least=0.0)
    shares = np.minimum(rate * np.diff(task.times, prepend=task.times[0]), 1.0)
    solver = ik_options(midrange=1.0 if rate > 0 and seed is None else 0.0)
    tracks = (
        _Track(
            *_core.track(chain, task.positions, task.orientations, start, steps, shares, options)
        )
        for start in _starts(chain, task, seed, solver)
    )
    best = min(tracks, key=lambda track: (-track.reached, _haste(track, task.times, velocity)))
    if best.reached < len(task.times):
        raise _failure(chain, task, best, solver)
    return JointTrajectory(
        task.times,
        best.q,
        velocities=_velocities(task.times, best.q),
        joint_names=tuple(chain.joint_names),
    )


def _task(motion: Any) -> _Task:
    if isinstance(motion, PoseTrajectory):
        return _Task(motion.times, motion.positions, motion.orientations)
    if isinstance(motion, Trajectory) and motion.positions.shape[1] == 3:
        return _Task(motion.times, motion.positions, np.empty((0, 4)))
    what = type(motion).__name__
    if isinstance(motion, Trajectory):
        what += f" in {motion.positions.shape[1]}-D"
    raise InvalidInput(f"motion: expected a PoseTrajectory or a Trajectory in 3-D, got {what}")


def _steps(
    task: _Task, velocity: Float64Array, max_step: float, speed_limit: float | None
) -> Float64Array:
    steps = np.full((len(task.times), len(velocity)), check.number(max_step, "max_step", above=0.0))
    if speed_limit is not None:
        scale = check.number(speed_limit, "speed_limit", above=0.0)
        steps[1:] = np.minimum(steps[1:], scale * np.diff(task.times)[:, None] * velocity)
    return steps


def _starts(
    chain: _core.Chain, task: _Task, seed: Float64Array | None, solver: _core.IkOptions
) -> Float64Array:
    """Postures for the first sample, the closest one alone where none reaches it."""
    if seed is not None:
        return _core.solve_ik_batch(chain, *task.first(), seed[None], solver, 1)[0]
    seeds = _seeds(chain)
    positions, orientations = (np.repeat(part, len(seeds), axis=0) for part in task.first())
    q, status, position_errors, orientation_errors, _ = _core.solve_ik_batch(
        chain, positions, orientations, seeds, solver, 1
    )
    if not (status == 0).any():
        return q[[np.argmin(position_errors + orientation_errors)]]
    return _distinct(q[status == 0])


def _seeds(chain: _core.Chain) -> Float64Array:
    lower = np.maximum(chain.lower, -np.pi)
    upper = np.minimum(chain.upper, np.pi)
    samples = np.random.default_rng(0).uniform(0.0, 1.0, (_STARTS - 1, len(lower)))
    return np.vstack([chain.middle, lower + samples * (upper - lower)])


def _distinct(q: Float64Array) -> Float64Array:
    kept = q[:1]
    for row in q[1:]:
        if (np.abs(kept - row).max(axis=1) > _SAME_POSTURE).all():
            kept = np.vstack([kept, row])
    return kept


def _haste(track: _Track, times: Float64Array, velocity: Float64Array) -> float:
    """The largest joint speed, as a share of its limit where there is one."""
    limit = np.where(np.isfinite(velocity) & (velocity > 0), velocity, 1.0)
    speeds = np.abs(np.diff(track.q, axis=0)) / np.diff(times)[:, None] / limit
    return float(speeds.max(initial=0.0))


def _velocities(times: Float64Array, q: Float64Array) -> Float64Array:
    if len(times) == 1:
        return np.zeros_like(q)
    return np.asarray(np.gradient(q, times, axis=0, edge_order=2 if len(times) > 2 else 1))


def _failure(chain: _core.Chain, task: _Task, track: _Track, solver: _core.IkOptions) -> IkFailure:
    i = track.reached
    residual = (float(track.position_errors[i]), float(track.orientation_errors[i]))
    _, status, *_ = _core.solve_ik_batch(
        chain,
        task.positions[i : i + 1],
        task.orientations[i : i + 1],
        track.q[i : i + 1],
        solver,
        1,
    )
    reason = STATUSES[status[0]] if status[0] else "jump"
    hint = " (reachable, but not from the sample before)" if reason == "jump" else ""
    message = (
        f"sample {i} at {task.times[i]:.6g} s: {reason}{hint}, "
        f"{residual[0]:.3g} m and {residual[1]:.3g} rad away"
    )
    return IkFailure(message, index=i, status=reason, residual=residual, q=track.q[i].copy())

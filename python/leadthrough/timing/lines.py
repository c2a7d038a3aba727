"""Motions along straight lines that rest between them, in closed form.

A jump averaged over three windows of time: their widths bound velocity, acceleration and jerk. It
is the fastest motion of samples that keep the limits, to a sample or two.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from leadthrough import _core
from leadthrough.arm.limits import JointLimits
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput, LimitsInfeasible
from leadthrough.timing.course import MAX_SAMPLES, computed_for_each
from leadthrough.timing.rates import AT_REST
from leadthrough.timing.samples import Samples
from leadthrough.timing.sections import Lines, Rows


def time_lines(lines: Lines, limits: JointLimits, rate: float) -> Samples:
    """The fastest motion along lines, with its rests."""
    acceleration, jerk = limits.acceleration, limits.jerk
    assert acceleration is not None
    assert jerk is not None
    changes = np.diff(lines.ends, axis=0)
    bound = (limits.velocity > 0.0) & (acceleration > 0.0) & (jerk > 0.0)
    _check_limits(limits, np.abs(changes), bound)
    parts = computed_for_each(rate)
    failed, steps, shares = _core.time_lines(
        np.ascontiguousarray(lines.ends),
        np.where(bound, limits.velocity, 0.0),
        np.where(bound, acceleration, 0.0),
        np.where(bound, jerk, 0.0),
        1.0 / (rate * parts),
        parts,
        MAX_SAMPLES,
    )
    if failed >= 0:
        raise InvalidInput(f"rate: expected at most {MAX_SAMPLES:.0e} samples; lower the rate")
    line = np.repeat(np.arange(len(steps)), steps)
    rests = np.cumsum(np.concatenate([[0], steps]))
    q = np.vstack([lines.ends[:1], lines.ends[line] + shares[:, None] * changes[line]])
    q[rests] = lines.ends
    length = np.append(lines.at[0], lines.at[line] + shares * np.diff(lines.at)[line])
    places = np.interp(length, lines.lengths, lines.rows)
    return _sampled(q, places, rests, rate).with_rests(rests[1:], lines.holds, rate)


def _check_limits(limits: JointLimits, moved: Float64Array, bound: NDArray[np.bool_]) -> None:
    stuck = (moved.max(axis=0) > AT_REST) & ~bound
    if stuck.any():
        name = limits.joint_names[int(np.argmax(stuck))]
        raise LimitsInfeasible(f"{name} moves along the path, but a limit of it is 0", joint=name)
    assert limits.acceleration is not None
    assert limits.jerk is not None
    least = np.minimum(np.minimum(limits.velocity, limits.acceleration), limits.jerk)
    if not ((moved > 0.0) & bound & np.isfinite(least)).any(axis=1).all():
        raise InvalidInput("limits: expected a finite limit of some joint that moves, got none")


def _sampled(q: Float64Array, places: Float64Array, rests: Rows, rate: float) -> Samples:
    """The samples with their central differences, except at rests."""
    steps = np.diff(np.vstack([q[:1], q, q[-1:]]), axis=0) * rate
    velocities = 0.5 * (steps[:-1] + steps[1:])
    accelerations = np.diff(steps, axis=0) * rate
    velocities[rests] = accelerations[rests] = 0.0
    return Samples(np.arange(len(q)) / rate, places, q, velocities, accelerations)

"""Motions along straight lines that rest between them, in closed form.

A jump averaged over three windows of time: their widths bound velocity, acceleration and jerk. It
is the fastest motion of samples that keep the limits, to a few samples.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from leadthrough import _core
from leadthrough.arm.limits import JointLimits
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.errors import LimitsInfeasible
from leadthrough.timing.samples import AT_REST, MAX_SAMPLES, Samples
from leadthrough.timing.sections import Lines


def time_lines(lines: Lines, limits: JointLimits, rate: float) -> Samples:
    """The fastest motion along lines, with its rests."""
    acceleration, jerk = limits.acceleration, limits.jerk
    assert acceleration is not None
    assert jerk is not None
    changes = np.diff(lines.ends, axis=0)
    bound = (limits.velocity > 0.0) & (acceleration > 0.0) & (jerk > 0.0)
    _check_limits(limits, np.abs(changes), bound)
    failed, steps, shares = _core.time_lines(
        np.ascontiguousarray(lines.ends),
        np.where(bound, limits.velocity, 0.0),
        np.where(bound, acceleration, 0.0),
        np.where(bound, jerk, 0.0),
        1.0 / rate,
        MAX_SAMPLES,
    )
    if failed >= 0:
        raise InvalidInput(f"rate: expected at most {MAX_SAMPLES:.0e} samples; lower the rate")
    line = np.repeat(np.arange(len(steps)), steps)
    rests = np.cumsum(np.concatenate([[0], steps]))
    share, speed, push = (column[:, None] for column in np.vstack([np.zeros((1, 3)), shares]).T)
    line = np.concatenate([[0], line])
    q = lines.ends[line] + share * changes[line]
    q[rests] = lines.ends
    length = lines.at[line] + share[:, 0] * np.diff(lines.at)[line]
    motion = Samples(
        np.arange(len(q)) / rate,
        np.interp(length, lines.lengths, lines.rows),
        q,
        speed * changes[line] * rate,
        push * changes[line] * rate**2,
    )
    return motion.with_dwells(rests[1:], lines.dwell_times, rate)


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

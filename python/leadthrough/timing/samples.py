"""Samples of a motion, joined and held; in closed form, those along lines with rests between.

A jump averaged over three windows of time: their widths bound velocity, acceleration and jerk. It
is the fastest motion of samples that keep the limits, to a few samples.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

import leadthrough._core as core
from leadthrough.arm.limits import JointLimits, refuse_zeros
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.timing.sections import Lines

# The most samples of a motion.
MAX_SAMPLES = 1e7
# Joints that move by less, rad or m, are at rest: fitting a constant leaves as much.
AT_REST = 1e-9


@dataclass(frozen=True, eq=False)
class Samples:
    """Samples of a motion."""

    times: Float64Array  # s from the start, (n,)
    rows: Float64Array  # progress, counted in way-points, samples or knots of the path, (n,)
    positions: Float64Array  # rad (m), (n, joints)
    velocities: Float64Array  # rad/s (m/s), (n, joints)
    accelerations: Float64Array  # rad/s^2 (m/s^2), (n, joints)

    @staticmethod
    def at_rest(q: Float64Array) -> Samples:
        """A single sample at rest at a configuration (joints,)."""
        still = np.zeros((1, len(q)))
        return Samples(np.zeros(1), np.zeros(1), q[None].copy(), still, still)

    @staticmethod
    def joined(motions: Sequence[Samples]) -> Samples:
        """All motions; each begins where the one before ends."""
        if len(motions) == 1:
            return motions[0]
        ends = np.cumsum([0.0, *(motion.times[-1] for motion in motions[:-1])])
        cut = [slice(int(i > 0), None) for i in range(len(motions))]
        pairs = list(zip(motions, cut, strict=True))
        times = [end + m.times[c] for end, (m, c) in zip(ends, pairs, strict=True)]
        others = ([vars(m)[name][c] for m, c in pairs] for name in list(vars(motions[0]))[1:])
        return Samples(np.concatenate(times), *map(np.concatenate, others))

    def with_dwell_before(self, time: float, rate: float) -> Samples:
        """The motion after a rest."""
        return Samples.joined([self._rest(0, time, rate), self]) if time > 0.0 else self

    def with_dwell_after(self, time: float, rate: float) -> Samples:
        """The motion followed by a rest."""
        return Samples.joined([self, self._rest(-1, time, rate)]) if time > 0.0 else self

    def with_dwells(self, at: NDArray[np.intp], times: Float64Array, rate: float) -> Samples:
        """The motion with further rests at samples."""
        copies = np.ones(len(self.times), dtype=np.intp)
        copies[at] += np.ceil(times * rate - 1e-9).astype(np.intp)
        if (copies == 1).all():
            return self
        later = np.concatenate([[0], np.cumsum(copies[:-1] - 1)]) / rate
        repeated = self._of(np.repeat(np.arange(len(self.times)), copies))
        within = np.arange(len(repeated.times)) - np.repeat(np.cumsum(copies) - copies, copies)
        return replace(repeated, times=repeated.times + np.repeat(later, copies) + within / rate)

    def some(self, count: int) -> Samples:
        """At most `count` evenly spread samples."""
        return self._of(np.unique(np.linspace(0, len(self.times) - 1, count).astype(np.intp)))

    def _rest(self, end: int, time: float, rate: float) -> Samples:
        """Standing still where the motion begins or ends."""
        count = math.ceil(time * rate - 1e-9) + 1
        positions = np.repeat(self.positions[[end]], count, axis=0)
        still, rows = np.zeros_like(positions), np.repeat(self.rows[end], count)
        return Samples(np.arange(count) / rate, rows, positions, still, still)

    def _of(self, index: NDArray[np.intp]) -> Samples:
        return Samples(*(column[index] for column in vars(self).values()))


def time_lines(lines: Lines, limits: JointLimits, rate: float) -> Samples:
    """The fastest motion along lines, with its rests."""
    acceleration, jerk = limits.acceleration, limits.jerk
    assert acceleration is not None
    assert jerk is not None
    changes = np.diff(lines.ends, axis=0)
    bound = (limits.velocity > 0.0) & (acceleration > 0.0) & (jerk > 0.0)
    _check_limits(limits, np.abs(changes), bound)
    failed, steps, shares = core.time_lines(
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
    refuse_zeros(limits, moved.max(axis=0) > AT_REST)
    assert limits.acceleration is not None
    assert limits.jerk is not None
    least = np.minimum(np.minimum(limits.velocity, limits.acceleration), limits.jerk)
    if not ((moved > 0.0) & bound & np.isfinite(least)).any(axis=1).all():
        raise InvalidInput("limits: expected a finite limit of some joint that moves, got none")

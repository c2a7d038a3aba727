"""Chunks of a policy's actions, put on the clock of a control loop.

A chunk is the uniform cubic B-spline whose control points are its actions: its acceleration is
continuous, it stays in the hull of its actions, so that limits of position and velocity that these
keep hold between them too, it has no lag, and it passes 1/6 of their second difference beside them.
It begins and ends on its first and its last action. A chunk takes over from another, from rest or
after periods that were missed, by the difference e between the state commanded and the chunk: it
decays as the polynomial of degree five from e, e', e'' to 0. Nothing jumps up to the acceleration,
and the chunk's own timing is kept.

Source: de Boor 1978, "A Practical Guide to Splines", for B-splines; Flash and Hogan 1985, for the
polynomial.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from leadthrough.arm import JointLimits
from leadthrough.check import Float64Array

_MAX_PASSES = 8  # of smoothing
_ROOM = 0.7  # of the limits that a chunk may use, so that it can be joined
_JOIN_USE = 0.5  # of the limits that a join is meant to use


@dataclass(frozen=True, eq=False)
class ChunkCurve:
    """The B-spline of a chunk."""

    start: float  # s
    step: float  # s, between actions
    points: Float64Array  # (n + 2, joints); the first and the last one continue the chunk straight
    own: tuple[float, float] | None = None  # start and step of the policy, if this is slower

    @staticmethod
    def of(rows: Float64Array, start: float, step: float) -> ChunkCurve:
        padded = np.concatenate([rows[:1], rows, rows[-1:]])
        if len(rows) > 1:
            padded[0] += rows[0] - rows[1]
            padded[-1] += rows[-1] - rows[-2]
        return ChunkCurve(start, step, padded)

    @property
    def end(self) -> float:
        return self.start + self.step * (len(self.points) - 3)

    def slowed(self, now: float, limits: JointLimits) -> ChunkCurve:
        """The curve, from now on as much slower as its control points demand."""
        now = max(now, self.start)
        left = self.points[max(0, int((now - self.start) / self.step)) :]
        uses = enumerate(_uses(left, self.step, limits), 1)
        slower = max(1.0, *((used / _ROOM) ** (1.0 / order) for order, used in uses))
        if slower == 1.0:
            return self
        start = now - (now - self.start) * slower
        return ChunkCurve(start, self.step * slower, self.points, (self.start, self.step))

    def held(self, now: float) -> ChunkCurve:
        """Its last action alone."""
        last = 0.5 * (self.points[-1:] + self.points[-3:-2])
        return ChunkCurve(now, self.step, last.repeat(4, axis=0))

    def lag(self, now: float) -> float:
        """How far it is behind the policy's own timing, s."""
        if self.own is None:
            return 0.0
        start, step = self.own
        return float(now - start - step * (min(now, self.end) - self.start) / self.step)

    def states(self, times: Float64Array) -> Float64Array:
        """States (n, 3 joints) at times up to its end."""
        place = (times - self.start) / self.step
        piece = np.clip(place.astype(np.intp), 0, max(0, len(self.points) - 4))
        u = (place - piece)[:, None]
        near = np.minimum(piece[:, None] + np.arange(4), len(self.points) - 1)
        a, b, c, d = self.points[near].transpose(1, 0, 2)
        v = 1.0 - u
        q = (a * (v * v * v) + b * (4.0 - 3.0 * u * u * (1.0 + v)) + d * (u * u * u)) / 6.0
        q += c * (4.0 - 3.0 * v * v * (1.0 + u)) / 6.0
        qd = ((b - a) * v * v + (c - b) * (1.0 + 2.0 * u * v) + (d - c) * u * u) / (2.0 * self.step)
        qdd = ((a - 2.0 * b + c) * v + (b - 2.0 * c + d) * u) / self.step**2
        return np.hstack([q, qd, qdd])


def decaying(away: Float64Array, duration: float, times: Float64Array) -> Float64Array:
    """A difference of states (1, 3 joints) at time 0, as it decays to 0: (n, 3 joints)."""
    e, ed, edd = away.reshape(3, -1) * duration ** np.arange(3)[:, None]
    cubic = -10.0 * e - 6.0 * ed - 1.5 * edd
    quartic = 15.0 * e + 8.0 * ed + 1.5 * edd
    quintic = -6.0 * e - 3.0 * ed - 0.5 * edd
    table = np.stack([e, ed, 0.5 * edd, cubic, quartic, quintic])
    s, k = times / duration, np.arange(6.0)[:, None]
    powers = np.vander(s, 6, increasing=True) * (s < 1.0)[:, None]
    rates = powers[:, :5] @ (k * table)[1:] / duration
    bends = powers[:, :4] @ (k * (k - 1.0) * table)[2:] / duration**2
    return np.hstack([powers @ table, rates, bends])


def needed_duration(away: Float64Array, limits: JointLimits) -> float:
    """The shortest duration, s, in which a difference of states decays within half of the limits.

    The peaks of the derivatives of the three parts of the polynomial, over unit time.
    """
    assert limits.acceleration is not None
    assert limits.jerk is not None
    limited = (limits.velocity, limits.acceleration, limits.jerk)
    v, a, j = (_JOIN_USE * limit for limit in limited)
    e, ed, edd = np.abs(away.reshape(3, -1))
    by_position = (1.875 * e / v, np.sqrt(5.774 * e / a), np.cbrt(60.0 * e / j))
    by_rates = (3.6 * ed / a, np.sqrt(36.0 * ed / j), 9.0 * edd / j)
    return float(np.max([*by_position, *by_rates]))


def smoothed(rows: Float64Array, step: float, limits: JointLimits) -> Float64Array:
    """Actions (n, joints) smoothed, without lag, until their B-spline keeps limits, or for long."""
    for _ in range(_MAX_PASSES):
        if max(_uses(rows, step, limits)) <= _ROOM or len(rows) < 3:
            break
        inner = (rows[:-2] + 2.0 * rows[1:-1] + rows[2:]) / 4.0
        rows = np.concatenate([rows[:1], inner, rows[-1:]])
    return rows


def _uses(points: Float64Array, step: float, limits: JointLimits) -> list[float]:
    """The largest fractions of the limits of velocity, acceleration and jerk of a B-spline."""
    assert limits.acceleration is not None
    assert limits.jerk is not None
    allowed = (limits.velocity, limits.acceleration, limits.jerk)
    return [
        float((np.abs(np.diff(points, order, axis=0)) / (limit * step**order)).max(initial=0.0))
        for order, limit in enumerate(allowed, 1)
    ]

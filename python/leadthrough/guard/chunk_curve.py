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

_MAX_PASSES = 4  # of smoothing
_ROOM = 0.7  # of the limits that a chunk may use, so that it can be joined


@dataclass(frozen=True, eq=False)
class ChunkCurve:
    """The B-spline of a chunk."""

    start: float  # s
    step: float  # s, between actions
    points: Float64Array  # (n + 2, joints); the first and the last one continue the chunk straight

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


@dataclass(frozen=True, eq=False)
class Run:
    """Commands, one a period."""

    rows: Float64Array  # (n, 3 joints)
    places: Float64Array  # times on the curve that they are of, s


@dataclass(frozen=True, eq=False)
class Ahead:
    """States of a curve, the first for the state that is commanded now."""

    times: Float64Array  # (n + 1,), s
    states: Float64Array  # (n + 1, 3 joints)

    def joined(self, present: Float64Array, duration: float) -> Run:
        """The next states, onto which the present one (1, 3 joints) is led in a duration, s."""
        since = self.times[1:] - self.times[0]
        rows = self.states[1:] + _decaying(present - self.states[:1], duration, since)
        return Run(rows, self.times[1:])


def _decaying(away: Float64Array, duration: float, times: Float64Array) -> Float64Array:
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


def smoothed(rows: Float64Array, step: float, limits: JointLimits) -> Float64Array:
    """Actions (n, joints) smoothed, without lag, until their B-spline keeps limits, or for long."""
    assert limits.acceleration is not None
    assert limits.jerk is not None
    allowed = [limits.velocity, limits.acceleration, limits.jerk]
    for _ in range(_MAX_PASSES):
        rates = [np.abs(np.diff(rows, order, axis=0)) / step**order for order in (1, 2, 3)]
        used = [(r / a).max(initial=0.0) for r, a in zip(rates, allowed, strict=True)]
        if max(used) <= _ROOM or len(rows) < 3:
            break
        rows = np.concatenate(
            [rows[:1], (rows[:-2] + 2.0 * rows[1:-1] + rows[2:]) / 4.0, rows[-1:]]
        )
    return rows

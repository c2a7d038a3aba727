"""Curves of rotations: slerp, squad, and Bezier curves by repeated slerp.

`evaluate` returns unit quaternions (n, 4), continuous in sign; as first and second derivative it
returns the angular velocity and acceleration (n, 3) in the base frame.

Source: Shoemake 1985 and 1987; Grioli 2023, section 2.4.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from leadthrough import _core, check, rotations
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.repr import ShortRepr
from leadthrough.rotations.interpolation import squad_controls
from leadthrough.trajectories import curve
from leadthrough.trajectories.rotation_rates import Turning, slerp

_MOST_POINTS = 50


class RotationCurve(ShortRepr, ABC):
    """A curve of rotations over an interval of times."""

    @property
    @abstractmethod
    def knots(self) -> Float64Array:
        """Rising times (k,) between which the curve is smooth, the ends of the domain included."""

    @abstractmethod
    def _rotations(self, t: Float64Array) -> Float64Array:
        """Quaternions (n, 4) at times (n,) of the domain."""

    @abstractmethod
    def _turning(self, t: Float64Array) -> Turning:
        """The same, with angular velocities and accelerations."""

    @property
    def domain(self) -> tuple[float, float]:
        """First and last time."""
        return float(self.knots[0]), float(self.knots[-1])

    def evaluate(self, t: ArrayLike, derivative: int = 0) -> Float64Array:
        """Quaternions (n, 4), or angular velocities or accelerations (n, 3), in the base frame.

        Args:
            t: times of the domain, (n,); or one, for a result of one dimension.
            derivative: 0 for quaternions, 1 for velocities in rad/s, 2 for accelerations in
                rad/s^2.

        Raises:
            InvalidInput: if a time lies outside the domain, or the order is another.
        """
        order = check.integer(derivative, "derivative", at_least=0, at_most=2)
        times = curve.times_inside(t, self.domain)
        at = np.atleast_1d(times)
        if order == 0:
            result = self._rotations(at)
        else:
            turning = self._turning(at)
            result = turning.velocity if order == 1 else turning.acceleration
        return result if np.ndim(t) else result[0]


@dataclass(frozen=True, eq=False, init=False)
class Slerp(RotationCurve):
    """The shortest turns between quaternions, at constant speed on each.

    Attributes:
        times: strictly increasing, s, (n,).
        quaternions: unit quaternions (n, 4); made continuous in sign.

    Raises:
        InvalidInput: if the times do not rise, or there are not as many unit quaternions.
    """

    times: Float64Array
    quaternions: Float64Array

    def __init__(self, times: ArrayLike, quaternions: ArrayLike) -> None:
        t, q = checked_samples(times, quaternions)
        vars(self).update(times=t, quaternions=q)

    @property
    def knots(self) -> Float64Array:
        """The times."""
        return self.times

    def _rotations(self, t: Float64Array) -> Float64Array:
        return _core.so3_slerp_through(self.times, self.quaternions, t)

    def _turning(self, t: Float64Array) -> Turning:
        turns = rotations.log(
            rotations.compose(self.quaternions[1:], rotations.inverse(self.quaternions[:-1]))
        )
        rates = (turns / np.diff(self.times)[:, None])[_pieces(self.times, t)]
        return Turning(self._rotations(t), rates, np.zeros((len(t), 3)))


@dataclass(frozen=True, eq=False, init=False)
class Squad(RotationCurve):
    """The curve of `rotations.squad` through quaternions, with a continuous angular velocity.

    Attributes:
        times: strictly increasing, s, (n,).
        quaternions: unit quaternions (n, 4), any three neighbours turning less than half a turn;
            made continuous in sign.

    Raises:
        InvalidInput: if the samples are malformed or turn too far, or the times are too uneven.
    """

    times: Float64Array
    quaternions: Float64Array
    _controls: tuple[Float64Array, Float64Array] = field(init=False, repr=False)

    def __init__(self, times: ArrayLike, quaternions: ArrayLike) -> None:
        t, q = checked_samples(times, quaternions)
        vars(self).update(times=t, quaternions=q, _controls=squad_controls(t, q))

    @property
    def knots(self) -> Float64Array:
        """The times."""
        return self.times

    def _rotations(self, t: Float64Array) -> Float64Array:
        (a, b, leaving, arriving), _, u = self._corners(t)
        chord = _core.so3_slerp(a, b, u)
        handle = _core.so3_slerp(leaving, arriving, u)
        return _core.so3_slerp(chord, handle, 2.0 * u * (1.0 - u))

    def _turning(self, t: Float64Array) -> Turning:
        corners, steps, fraction = self._corners(t)
        a, b, leaving, arriving = (Turning.still(corner) for corner in corners)
        u, rate = fraction[:, None], 1.0 / steps[:, None]
        along = (u, rate, np.zeros_like(u))
        bent = (2.0 * u * (1.0 - u), 2.0 * (1.0 - 2.0 * u) * rate, -4.0 * rate**2)
        return slerp(slerp(a, b, along), slerp(leaving, arriving, along), bent)

    def _corners(
        self, t: Float64Array
    ) -> tuple[tuple[Float64Array, ...], Float64Array, Float64Array]:
        """Samples and inner rotations beside each time, the step there and its fraction passed."""
        i = _pieces(self.times, t)
        leaving, arriving = self._controls
        steps = self.times[i + 1] - self.times[i]
        corners = self.quaternions[i], self.quaternions[i + 1], leaving[i], arriving[i]
        return corners, steps, (t - self.times[i]) / steps


@dataclass(frozen=True, eq=False, init=False)
class RotationBezier(RotationCurve):
    """The Bezier curve of quaternions, by de Casteljau's construction with slerp for lines.

    Attributes:
        quaternions: unit quaternions (n, 4), neighbours less than half a turn apart; made
            continuous in sign.
        times: first and last time, s.

    Raises:
        InvalidInput: if they are fewer than 2 or more than 50, neighbours are half a turn apart, or
            the times do not rise.
    """

    quaternions: Float64Array
    times: tuple[float, float]

    def __init__(self, quaternions: ArrayLike, times: ArrayLike = (0.0, 1.0)) -> None:
        q = rotations.align_signs(quaternions)
        check.integer(len(q), "number of quaternions", at_least=2, at_most=_MOST_POINTS)
        if (rotations.distance(q[1:], q[:-1]) >= np.pi - 1e-9).any():
            raise InvalidInput("quaternions: expected neighbours less than half a turn apart")
        q.setflags(write=False)
        knots = curve.knot_times(times, "times")
        vars(self).update(quaternions=q, times=(float(knots[0]), float(knots[-1])))

    @property
    def knots(self) -> Float64Array:
        """The ends of the domain."""
        return np.array(self.times)

    def _rotations(self, t: Float64Array) -> Float64Array:
        fractions = self._fractions(t)
        level = [np.repeat(q[None], len(t), axis=0) for q in self.quaternions]
        while len(level) > 1:
            level = [_core.so3_slerp(a, b, fractions) for a, b in pairwise(level)]
        return level[0]

    def _turning(self, t: Float64Array) -> Turning:
        fractions = self._fractions(t)[:, None]
        rate = np.full_like(fractions, 1.0 / (self.times[1] - self.times[0]))
        along = (fractions, rate, np.zeros_like(fractions))
        level = [Turning.still(np.repeat(q[None], len(t), axis=0)) for q in self.quaternions]
        while len(level) > 1:
            level = [slerp(a, b, along) for a, b in pairwise(level)]
        return level[0]

    def _fractions(self, t: Float64Array) -> Float64Array:
        first, last = self.times
        return (t - first) / (last - first)


def _pieces(times: Float64Array, t: Float64Array) -> NDArray[np.intp]:
    return np.clip(np.searchsorted(times, t, side="right") - 1, 0, len(times) - 2)


def checked_samples(times: ArrayLike, quaternions: ArrayLike) -> tuple[Float64Array, Float64Array]:
    """Rising times (n,), n >= 2, and unit quaternions (n, 4), continuous in sign; read-only."""
    t = curve.knot_times(times, "times")
    q = rotations.align_signs(check.quaternions(quaternions, "quaternions", shape=(len(t), 4)))
    q.setflags(write=False)
    return t, q

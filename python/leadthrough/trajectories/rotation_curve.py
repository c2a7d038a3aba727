"""Curves of rotations: slerp, squad, Bezier by repeated slerp.

`evaluate` gives unit quaternions (n, 4), continuous in sign; its first and second derivative are
the angular velocity and acceleration (n, 3) in the base frame.
Source: Shoemake 1985 and 1987; Grioli 2023, section 2.4.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from leadthrough import _core, check, rotations
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.rotations.interpolation import squad_controls
from leadthrough.trajectories import curve
from leadthrough.trajectories.rotation_rates import Turning, slerp

_MOST_POINTS = 50
# The shorter arc of two equal quaternions, rad: weights of a straight line to 1e-13.
_LEAST_ARC = 1e-6


class RotationCurve(ABC):
    """What all curves of rotations can do."""

    @property
    @abstractmethod
    def knots(self) -> Float64Array:
        """(k,) rising times between which the curve is smooth, the ends of the domain included."""

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

    def evaluate(self, t: Any, derivative: int = 0) -> Float64Array:
        """Quaternions (n, 4), angular velocities or accelerations (n, 3) at times (n,).

        One row without its axis at one time. derivative: 0, 1 or 2. Raises InvalidInput.
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


@dataclass(frozen=True, eq=False)
class Slerp(RotationCurve):
    """The shortest turns between quaternions (n, 4) at times (n,), at even speed on each.

    Raises InvalidInput.
    """

    times: Float64Array
    quaternions: Float64Array
    _arcs: Float64Array = field(init=False, repr=False)  # half the turns

    def __post_init__(self) -> None:
        _freeze(self)
        a, b = self.quaternions[:-1], self.quaternions[1:]
        chords = [np.linalg.norm(b - a, axis=1), np.linalg.norm(b + a, axis=1)]
        object.__setattr__(self, "_arcs", np.maximum(2.0 * np.arctan2(*chords), _LEAST_ARC))

    @property
    def knots(self) -> Float64Array:
        """The times."""
        return self.times

    def _rotations(self, t: Float64Array) -> Float64Array:
        i = self._pieces(t)
        arc = self._arcs[i]
        angle = arc * ((t - self.times[i]) / (self.times[i + 1] - self.times[i]))
        weights = np.sin([arc - angle, angle]) / np.sin(arc)
        a, b = self.quaternions[i], self.quaternions[i + 1]
        return np.asarray(weights[0][:, None] * a + weights[1][:, None] * b)

    def _turning(self, t: Float64Array) -> Turning:
        turns = rotations.log(
            rotations.compose(self.quaternions[1:], rotations.inverse(self.quaternions[:-1]))
        )
        rates = (turns / np.diff(self.times)[:, None])[self._pieces(t)]
        velocities = np.broadcast_to(rates, (len(t), 3)).copy()
        return Turning(self._rotations(t), velocities, np.zeros((len(t), 3)))

    def _pieces(self, t: Float64Array) -> Any:
        """The piece of every time; where there is one only, as a number, which spares copies."""
        return 0 if len(self.times) == 2 else _pieces(self.times, t)


@dataclass(frozen=True, eq=False)
class Squad(RotationCurve):
    """A curve through quaternions (n, 4) at times (n,) with a continuous angular velocity.

    See `rotations.squad`. Raises InvalidInput.
    """

    times: Float64Array
    quaternions: Float64Array
    _controls: tuple[Float64Array, Float64Array] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        _freeze(self)
        object.__setattr__(self, "_controls", squad_controls(self.times, self.quaternions))

    @property
    def knots(self) -> Float64Array:
        """The times."""
        return self.times

    def _rotations(self, t: Float64Array) -> Float64Array:
        (a, b, leaving, arriving), _, share = self._corners(t)
        chord = _core.so3_slerp(a, b, share)
        handle = _core.so3_slerp(leaving, arriving, share)
        return _core.so3_slerp(chord, handle, 2.0 * share * (1.0 - share))

    def _turning(self, t: Float64Array) -> Turning:
        corners, steps, share = self._corners(t)
        a, b, leaving, arriving = (Turning.still(corner) for corner in corners)
        u, rate = share[:, None], 1.0 / steps[:, None]
        along = (u, rate, np.zeros_like(u))
        bent = (2.0 * u * (1.0 - u), 2.0 * (1.0 - 2.0 * u) * rate, -4.0 * rate**2)
        return slerp(slerp(a, b, along), slerp(leaving, arriving, along), bent)

    def _corners(
        self, t: Float64Array
    ) -> tuple[tuple[Float64Array, ...], Float64Array, Float64Array]:
        """The samples and inner rotations beside each time, the step there and its share passed."""
        i = _pieces(self.times, t)
        leaving, arriving = self._controls
        steps = self.times[i + 1] - self.times[i]
        corners = self.quaternions[i], self.quaternions[i + 1], leaving[i], arriving[i]
        return corners, steps, (t - self.times[i]) / steps


@dataclass(frozen=True, eq=False)
class RotationBezier(RotationCurve):
    """The Bezier curve of quaternions (n, 4), by de Casteljau's construction with slerp for lines.

    Neighbours must be less than half a turn apart. Raises InvalidInput.
    """

    quaternions: Float64Array
    times: tuple[float, float] = (0.0, 1.0)

    def __post_init__(self) -> None:
        q = rotations.align_signs(self.quaternions)
        check.integer(len(q), "number of quaternions", at_least=2, at_most=_MOST_POINTS)
        if (rotations.distance(q[1:], q[:-1]) >= np.pi - 1e-9).any():
            raise InvalidInput("quaternions: expected neighbours less than half a turn apart")
        q.setflags(write=False)
        knots = curve.knot_times(self.times, "times")
        object.__setattr__(self, "quaternions", q)
        object.__setattr__(self, "times", (float(knots[0]), float(knots[-1])))

    @property
    def knots(self) -> Float64Array:
        """The ends of the domain."""
        return np.array(self.times)

    def _rotations(self, t: Float64Array) -> Float64Array:
        shares = self._shares(t)
        level = [np.repeat(q[None], len(t), axis=0) for q in self.quaternions]
        while len(level) > 1:
            level = [_core.so3_slerp(a, b, shares) for a, b in pairwise(level)]
        return level[0]

    def _turning(self, t: Float64Array) -> Turning:
        shares = self._shares(t)[:, None]
        rate = np.full_like(shares, 1.0 / (self.times[1] - self.times[0]))
        along = (shares, rate, np.zeros_like(shares))
        level = [Turning.still(np.repeat(q[None], len(t), axis=0)) for q in self.quaternions]
        while len(level) > 1:
            level = [slerp(a, b, along) for a, b in pairwise(level)]
        return level[0]

    def _shares(self, t: Float64Array) -> Float64Array:
        first, last = self.times
        return (t - first) / (last - first)


def _pieces(times: Float64Array, t: Float64Array) -> NDArray[np.intp]:
    return np.clip(np.searchsorted(times, t, side="right") - 1, 0, len(times) - 2)


def _freeze(rotation_curve: Slerp | Squad) -> None:
    times = curve.knot_times(rotation_curve.times, "times")
    q = check.quaternions(rotation_curve.quaternions, "quaternions", shape=(len(times), 4))
    continuous = rotations.align_signs(q)
    continuous.setflags(write=False)
    object.__setattr__(rotation_curve, "times", times)
    object.__setattr__(rotation_curve, "quaternions", continuous)

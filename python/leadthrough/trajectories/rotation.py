"""Curves of rotations: slerp, squad, Bezier curves by repeated slerp, and a C2 spline.

`evaluate` returns unit quaternions (n, 4), continuous in sign; as first and second derivative it
returns the angular velocity and acceleration (n, 3) in the base frame.

Along a rotation vector phi(t) the rotation exp(phi) turns with J phi' and J phi'' + dJ/dt phi',
where J v = A v + B phi x v + C phi (phi . v) for an angle x = |phi| and A = sin x / x,
B = (1 - cos x) / x^2, C = (x - sin x) / x^3. The spline's pieces are cubic in the rotation vector:
on piece i the rotation is exp(phi(t)) q_i. With angular velocities w at the samples, phi starts
with w_i and ends with J^-1 w_(i+1); the angular acceleration agrees at the inner samples if w
solves a system that is tridiagonal apart from the small term dJ/dt phi', which is iterated.

Source: Shoemake 1985 and 1987; Grioli 2023, section 2.4; Park and Ravani 1997; Sola et al. 2018,
eq. 145.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

import leadthrough._core as core
from leadthrough import check, rotations
from leadthrough.check import FitError, Float64Array, InvalidInput, ShortRepr
from leadthrough.rotations.group import squad_controls
from leadthrough.trajectories import curve

_MAX_POINTS = 50


class RotationCurve(ShortRepr, ABC):
    """A curve of rotations over an interval of times."""

    times: Float64Array | tuple[float, float]  # of the knots

    @property
    def knots(self) -> Float64Array:
        """Rising times (k,) between which the curve is smooth, the ends of the domain included."""
        return np.asarray(self.times)

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
        """
        order = check.integer(derivative, "derivative", at_least=0, at_most=2)
        times = curve.times_inside(t, self.domain)
        result = curve.in_blocks(lambda at: self._derivative(at, order), np.atleast_1d(times))
        return result if np.ndim(t) else result[0]

    def _derivative(self, at: Float64Array, order: int) -> Float64Array:
        if order == 0:
            return self._rotations(at)
        turning = self._turning(at)
        return turning.velocity if order == 1 else turning.acceleration


@dataclass(frozen=True, eq=False, init=False)
class Slerp(RotationCurve):
    """The shortest turns between quaternions, at constant speed on each.

    Attributes:
        times: strictly increasing, s, (n,).
        quaternions: unit quaternions (n, 4); made continuous in sign.
    """

    times: Float64Array
    quaternions: Float64Array

    def __init__(self, times: ArrayLike, quaternions: ArrayLike) -> None:
        t, q = checked_samples(times, quaternions)
        vars(self).update(times=t, quaternions=q)

    def _rotations(self, t: Float64Array) -> Float64Array:
        return core.so3_slerp_through(self.times, self.quaternions, t)

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
        InvalidInput: if the times are too uneven.
    """

    times: Float64Array
    quaternions: Float64Array
    _controls: tuple[Float64Array, Float64Array] = field(init=False, repr=False)

    def __init__(self, times: ArrayLike, quaternions: ArrayLike) -> None:
        t, q = checked_samples(times, quaternions)
        vars(self).update(times=t, quaternions=q, _controls=squad_controls(t, q))

    def _rotations(self, t: Float64Array) -> Float64Array:
        (a, b, leaving, arriving), _, u = self._corners(t)
        chord = core.so3_slerp(a, b, u)
        handle = core.so3_slerp(leaving, arriving, u)
        return core.so3_slerp(chord, handle, 2.0 * u * (1.0 - u))

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
    """

    quaternions: Float64Array
    times: tuple[float, float]

    def __init__(self, quaternions: ArrayLike, times: ArrayLike = (0.0, 1.0)) -> None:
        q = rotations.align_signs(quaternions)
        check.integer(len(q), "number of quaternions", at_least=2, at_most=_MAX_POINTS)
        if (rotations.distance(q[1:], q[:-1]) >= np.pi - 1e-9).any():
            raise InvalidInput("quaternions: expected neighbours less than half a turn apart")
        knots = curve.knot_times(times, "times")
        vars(self).update(quaternions=check.freeze(q), times=(float(knots[0]), float(knots[-1])))

    def _rotations(self, t: Float64Array) -> Float64Array:
        fractions = self._fractions(t)
        level = [np.repeat(q[None], len(t), axis=0) for q in self.quaternions]
        while len(level) > 1:
            level = [core.so3_slerp(a, b, fractions) for a, b in pairwise(level)]
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
    return t, check.freeze(q)


# rad; below it the quotients lose digits to cancellation; their series have this many terms.
_SMALL, _TERMS = 1.0, 10


@dataclass(frozen=True, eq=False)
class Turning:
    """Rotations and how they turn, in the base frame."""

    q: Float64Array  # unit quaternions (n, 4)
    velocity: Float64Array  # angular, rad/s, (n, 3)
    acceleration: Float64Array  # angular, rad/s^2, (n, 3)

    @staticmethod
    def still(q: Float64Array) -> Turning:
        return Turning(q, np.zeros((len(q), 3)), np.zeros((len(q), 3)))

    def then(self, outer: Turning) -> Turning:
        """`outer` after this one."""
        matrices = core.so3_to_matrix(outer.q).reshape(-1, 3, 3)
        carried = products(matrices, self.velocity)
        return Turning(
            core.so3_compose(outer.q, self.q),
            outer.velocity + carried,
            outer.acceleration
            + np.cross(outer.velocity, carried)
            + products(matrices, self.acceleration),
        )

    def inverse(self) -> Turning:
        back = self.q * np.array([1.0, -1.0, -1.0, -1.0])
        matrices = core.so3_to_matrix(back).reshape(-1, 3, 3)
        return Turning(
            back, -products(matrices, self.velocity), -products(matrices, self.acceleration)
        )


def turning_of(phi: Float64Array, first: Float64Array, second: Float64Array) -> Turning:
    """The turning of exp(phi), for rotation vectors phi (n, 3) and their two derivatives."""
    jacobians = core.so3_left_jacobian(phi).reshape(-1, 3, 3)
    return Turning(
        core.so3_exp(phi),
        products(jacobians, first),
        products(jacobians, second) + drift(phi, first),
    )


def vectors_of(turning: Turning) -> tuple[Float64Array, Float64Array, Float64Array]:
    """The shortest rotation vectors (n, 3) with two derivatives; no rotation is half a turn."""
    phi = core.so3_log(turning.q)
    inverses = core.so3_left_jacobian_inverse(phi).reshape(-1, 3, 3)
    first = products(inverses, turning.velocity)
    return phi, first, products(inverses, turning.acceleration - drift(phi, first))


def slerp(
    a: Turning, b: Turning, fraction: tuple[Float64Array, Float64Array, Float64Array]
) -> Turning:
    """From a to b on the shortest turn, at fractions (n, 1) with two derivatives."""
    u, first, second = fraction
    phi, speed, change = vectors_of(b.then(a.inverse()))
    turn = turning_of(
        u * phi, first * phi + u * speed, second * phi + 2.0 * first * speed + u * change
    )
    return turn.then(a)


def drift(phi: Float64Array, first: Float64Array) -> Float64Array:
    """dJ/dt phi' (n, 3), where phi (n, 3) moves by `first` (n, 3)."""
    a, b, c, c_itself = _slopes(np.einsum("ni,ni->n", phi, phi)[:, None])
    along = np.einsum("ni,ni->n", phi, first)[:, None]
    squared = np.einsum("ni,ni->n", first, first)[:, None]
    return np.asarray(
        along * (a * first + b * np.cross(phi, first) + c * along * phi)
        + c_itself * (along * first + squared * phi)
    )


def _slopes(squared: Float64Array) -> tuple[Float64Array, ...]:
    """dA/dx / x, dB/dx / x, dC/dx / x and C at angles x, given x^2."""
    from scipy.special import factorial

    k = np.arange(_TERMS, 0, -1)
    signs = np.where(k % 2, -1.0, 1.0)
    series = [
        np.polyval(signs * 2.0 * k / factorial(2 * k + n), np.minimum(squared, _SMALL**2))
        for n in (1, 2, 3)
    ]
    series.append(
        np.polyval([*(signs / factorial(2 * k + 3)), 1.0 / 6.0], np.minimum(squared, _SMALL**2))
    )
    x = np.sqrt(np.maximum(squared, _SMALL**2))
    a, b, c = np.sin(x) / x, (1.0 - np.cos(x)) / x**2, (x - np.sin(x)) / x**3
    quotients = [(np.cos(x) - a) / x**2, (a - 2.0 * b) / x**2, (b - 3.0 * c) / x**2, c]
    small = squared < _SMALL**2
    return tuple(np.where(small, *pair) for pair in zip(series, quotients, strict=True))


def products(matrices: Float64Array, vectors: Float64Array) -> Float64Array:
    return np.asarray(np.einsum("nij,nj->ni", matrices, vectors))


_AT_REST = (0.0, 0.0, 0.0)
_MAX_ROUNDS = 200
# Angular accelerations agree to this, relative to the largest velocity over the shortest step.
_SETTLED = 1e-13


@dataclass(frozen=True, eq=False, init=False)
class RotationSpline(RotationCurve):
    """The curve through quaternions with continuous angular velocity and acceleration.

    Attributes:
        times: strictly increasing, s, (n,).
        quaternions: unit quaternions (n, 4), neighbours less than half a turn apart; made
            continuous in sign.
        start_velocity: rad/s in the base frame, (3,); at rest by default.
        end_velocity: rad/s in the base frame, (3,); at rest by default.
        velocities: rad/s in the base frame at all times, (n, 3).

    Raises:
        FitError: if the turns are too large or uneven.
    """

    times: Float64Array
    quaternions: Float64Array
    start_velocity: Float64Array
    end_velocity: Float64Array
    velocities: Float64Array = field(init=False)
    _cubics: Float64Array = field(init=False, repr=False)

    def __init__(
        self,
        times: ArrayLike,
        quaternions: ArrayLike,
        start_velocity: ArrayLike = _AT_REST,
        end_velocity: ArrayLike = _AT_REST,
    ) -> None:
        t, q = checked_samples(times, quaternions)
        turns = rotations.log(rotations.compose(q[1:], rotations.inverse(q[:-1])))
        if (np.linalg.norm(turns, axis=1) >= np.pi - 1e-6).any():
            raise InvalidInput("quaternions: expected neighbours less than half a turn apart")
        start = check.frozen(start_velocity, "start_velocity", shape=(3,))
        end = check.frozen(end_velocity, "end_velocity", shape=(3,))
        velocities = check.freeze(_velocities(np.diff(t), turns, start, end))
        vars(self).update(
            times=t,
            quaternions=q,
            start_velocity=start,
            end_velocity=end,
            velocities=velocities,
            _cubics=_cubics(np.diff(t), turns, velocities),
        )

    def _rotations(self, t: Float64Array) -> Float64Array:
        i, (phi, _, _) = self._vectors(t)
        return rotations.compose(rotations.exp(phi), self.quaternions[i])

    def _turning(self, t: Float64Array) -> Turning:
        i, vectors = self._vectors(t)
        return Turning.still(self.quaternions[i]).then(turning_of(*vectors))

    def _vectors(
        self, t: Float64Array
    ) -> tuple[NDArray[np.intp], tuple[Float64Array, Float64Array, Float64Array]]:
        """The piece of each time, and phi with two derivatives there."""
        i = _pieces(self.times, t)
        s = (t - self.times[i])[:, None]
        a, b, c = (self._cubics[i, k] for k in range(3))
        return i, (
            s * (a + s * (b + s * c)),
            a + s * (2.0 * b + 3.0 * s * c),
            2.0 * b + 6.0 * s * c,
        )


def _cubics(steps: Float64Array, turns: Float64Array, velocities: Float64Array) -> Float64Array:
    """(pieces, 3, 3) coefficients of t, t^2 and t^3."""
    h = steps[:, None]
    start = velocities[:-1]
    end = products(rotations.left_jacobian_inverse(turns), velocities[1:])
    return np.stack(
        [
            start,
            (3.0 * turns / h - 2.0 * start - end) / h,
            (start + end - 2.0 * turns / h) / h**2,
        ],
        axis=1,
    )


def _velocities(
    steps: Float64Array, turns: Float64Array, first: Float64Array, last: Float64Array
) -> Float64Array:
    """Angular velocities (n, 3) at the samples, the given ones at the ends."""
    from scipy.linalg import solve_banded

    velocities = np.vstack([first, np.zeros((len(steps) - 1, 3)), last])
    if len(steps) == 1:
        return velocities
    matrix = _matrix(steps, turns)
    scale = np.abs(turns).max() / steps.min() + np.abs(velocities).max() + 1e-300
    for _ in range(_MAX_ROUNDS):
        with np.errstate(all="ignore"):
            found = solve_banded((5, 5), matrix, _right_side(steps, turns, velocities).ravel())
        if not np.isfinite(found).all():
            break
        change = np.abs(found.reshape(-1, 3) - velocities[1:-1]).max()
        velocities[1:-1] = found.reshape(-1, 3)
        if change <= _SETTLED * scale:
            return velocities
    raise FitError("times: the turns are too large or uneven for a spline of rotations")


def _matrix(steps: Float64Array, turns: Float64Array) -> Float64Array:
    """Banded matrix of the inner velocities, without the drift."""
    inner = len(steps) - 1
    rows = np.zeros((inner, 3, inner, 3))
    leaving = 2.0 * rotations.left_jacobian(turns) / steps[:, None, None]
    arriving = 2.0 * rotations.left_jacobian_inverse(turns) / steps[:, None, None]
    for k in range(inner):
        rows[k, :, k] = 4.0 * (1.0 / steps[k] + 1.0 / steps[k + 1]) * np.eye(3)
        if k > 0:
            rows[k, :, k - 1] = leaving[k]
        if k + 1 < inner:
            rows[k, :, k + 1] = arriving[k + 1]
    square = rows.reshape(3 * inner, 3 * inner)
    banded = np.zeros((11, 3 * inner))
    for offset in range(-5, 6):
        diagonal = np.diagonal(square, offset)
        columns = slice(max(offset, 0), max(offset, 0) + len(diagonal))
        banded[5 - offset, columns] = diagonal
    return banded


def _right_side(steps: Float64Array, turns: Float64Array, velocities: Float64Array) -> Float64Array:
    h = steps[:, None]
    right = 6.0 * (turns[1:] / h[1:] ** 2 + turns[:-1] / h[:-1] ** 2)
    arriving = products(rotations.left_jacobian_inverse(turns), velocities[1:])
    right -= drift(turns[:-1], arriving[:-1])
    leaving = products(rotations.left_jacobian(turns), velocities[:-1])
    right[0] -= 2.0 * leaving[0] / steps[0]
    right[-1] -= 2.0 * arriving[-1] / steps[-1]
    return np.asarray(right)

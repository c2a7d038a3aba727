"""Curves of poses, and any curve run by any law: x(t) = f(s(t)), with exact derivatives.

By the chain rule the derivative of order n is the sum over k of f^(k)(s) B_{n,k}(s', s'', ...),
with the partial Bell polynomials B (the formula of Faà di Bruno). Of rotations, the angular
velocity is omega(s) s' and the angular acceleration alpha(s) s'^2 + omega(s) s''.

Source: Grioli 2023, eqs. 1.4 and 1.5, with the second derivative put right.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from math import comb
from typing import overload

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput, ShortRepr
from leadthrough.motion import PoseTrajectory
from leadthrough.trajectories import curve
from leadthrough.trajectories.curve import Curve, PointCurve
from leadthrough.trajectories.rotation import RotationCurve, Turning

# A law may leave the curve's domain by rounding, relative to its length.
_ROUNDING = 1e-9
# Samples of a piece of the law at which it is compared with the domain.
_LOOKED_AT = 33


@overload
def run_by(  # type: ignore[overload-overlap]  # rotations fit the protocol of curves, too
    path: RotationCurve, law: PointCurve
) -> RotationCurve: ...
@overload
def run_by(path: PoseCurve, law: PointCurve) -> PoseCurve: ...
@overload
def run_by(path: Curve, law: PointCurve) -> PointCurve: ...
def run_by(
    path: Curve | RotationCurve | PoseCurve, law: PointCurve
) -> PointCurve | RotationCurve | PoseCurve:
    """A curve of points, rotations or poses, run by a law of its parameter over time.

    Args:
        path: f, over an interval of its parameter s.
        law: s(t), a curve in one dimension with values in the path's domain, such as
            `double_s([0], [1], velocity=..., acceleration=..., jerk=...)`.

    Returns:
        f(s(t)) over the law's domain, of the path's own kind.

    Raises:
        InvalidInput: if the law is not in one dimension, or leaves the path's domain.
    """
    for name, given in (("path", path), ("law", law)):
        check.instance(given, name, Curve | PoseCurve, "a curve")
    _check_law(path.domain, law)
    if isinstance(path, PoseCurve):
        return PoseCurve(_run(path.positions, law), _Rotations(path.orientations, law))
    if isinstance(path, RotationCurve):
        return _Rotations(path, law)
    return _run(path, law)


def _run(path: Curve, law: PointCurve) -> _Points:
    size = len(path.evaluate(path.domain[0]))
    return _Points(path, law, np.eye(size), np.zeros(size))


def _check_law(domain: tuple[float, float], law: PointCurve) -> None:
    if not isinstance(law, PointCurve) or len(law.evaluate(law.domain[0])) != 1:
        raise InvalidInput("law: expected a curve in one dimension, the path's parameter over time")
    knots = np.asarray(law.knots)
    inside = np.linspace(0.0, 1.0, _LOOKED_AT)
    values = law.evaluate((knots[:-1, None] + np.diff(knots)[:, None] * inside).ravel())
    slack = _ROUNDING * (domain[1] - domain[0])
    if values.min() < domain[0] - slack or values.max() > domain[1] + slack:
        raise InvalidInput(
            f"law: expected values in the path's domain, {domain[0]:.6g} to {domain[1]:.6g}, got "
            f"{values.min():.6g} to {values.max():.6g}"
        )


def _knots(path: Curve | RotationCurve, law: PointCurve) -> Float64Array:
    """The law's knots, and the times at which a rising law passes the path's."""
    pieces = pairwise(np.asarray(law.knots).tolist())
    times = np.unique(np.concatenate([np.linspace(*piece, _LOOKED_AT) for piece in pieces]))
    s = law.evaluate(times)[:, 0]
    if not (np.diff(s) >= 0.0).all():
        return np.asarray(law.knots)
    inner = [knot for knot in path.knots[1:-1] if s[0] < knot < s[-1]]
    passed = [_passed(law, float(knot), times, s) for knot in inner]
    return np.union1d(law.knots, np.array(passed))


def _passed(law: PointCurve, value: float, times: Float64Array, s: Float64Array) -> float:
    """The time at which a rising law reaches a value, by bisection to the last bit."""
    row = int(np.searchsorted(s, value))
    low, high = float(times[row - 1]), float(times[row])
    while low < (middle := 0.5 * (low + high)) < high:
        if law.evaluate(middle)[0] < value:
            low = middle
        else:
            high = middle
    return high


@dataclass(frozen=True, eq=False)
class _Points(PointCurve):
    """matrix @ f(s(t)) + offset, with a path f and a law s."""

    path: Curve
    law: PointCurve
    matrix: Float64Array
    offset: Float64Array

    @property
    def domain(self) -> tuple[float, float]:
        return self.law.domain

    @property
    def knots(self) -> Float64Array:
        return _knots(self.path, self.law)

    def _values(self, times: Float64Array, order: int) -> Float64Array:
        at = np.atleast_1d(times)
        s = np.clip(self.law.evaluate(at)[:, 0], *self.path.domain)
        if order == 0:
            found = self.path.evaluate(s) @ self.matrix.T + self.offset
        else:
            bells = _bell(order, [self.law.evaluate(at, k)[:, 0] for k in range(1, order + 1)])
            slopes = [self.path.evaluate(s, k) for k in range(1, order + 1)]
            total = np.einsum("knd,kn->nd", np.array(slopes), np.array(bells))
            found = total @ self.matrix.T
        return np.asarray(found if times.ndim else found[0])

    def _mapped(self, matrix: Float64Array, offset: Float64Array) -> _Points:
        return replace(self, matrix=matrix @ self.matrix, offset=matrix @ self.offset + offset)

    def _stretched(self, factor: float) -> _Points:
        return replace(self, law=self.law.rescaled(factor))


def _bell(order: int, rates: list[Float64Array]) -> list[Float64Array]:
    """Bell polynomials B_{order, k}: B_{n, k} = sum_i C(n - 1, i - 1) x_i B_{n - i, k - 1}."""
    one, nothing = np.ones_like(rates[0]), np.zeros_like(rates[0])
    table = {(0, 0): one}
    for n in range(1, order + 1):
        for k in range(1, n + 1):
            terms = (
                comb(n - 1, i - 1) * rates[i - 1] * table.get((n - i, k - 1), nothing)
                for i in range(1, n - k + 2)
            )
            table[n, k] = sum(terms, nothing)
    return [table[order, k] for k in range(1, order + 1)]


@dataclass(frozen=True, eq=False)
class _Rotations(RotationCurve):
    """Rotations of a path, run by a law."""

    path: RotationCurve
    law: PointCurve

    @property
    def knots(self) -> Float64Array:
        return _knots(self.path, self.law)

    def _rotations(self, t: Float64Array) -> Float64Array:
        return self.path.evaluate(np.clip(self.law.evaluate(t)[:, 0], *self.path.domain))

    def _turning(self, t: Float64Array) -> Turning:
        s = np.clip(self.law.evaluate(t)[:, 0], *self.path.domain)
        first, second = (self.law.evaluate(t, k) for k in (1, 2))
        turning = self.path._turning(s)
        return replace(
            turning,
            velocity=turning.velocity * first,
            acceleration=turning.acceleration * first**2 + turning.velocity * second,
        )


# Domains may differ by rounding, relative to their length.
_SAME = 1e-9


@dataclass(frozen=True, eq=False)
class PoseCurve(ShortRepr):
    """Positions in 3-D and rotations over one domain.

    Attributes:
        positions: a curve in 3-D, m.
        orientations: a curve of rotations over the same domain.
    """

    positions: Curve
    orientations: RotationCurve

    def __post_init__(self) -> None:
        check.instance(self.positions, "positions", Curve, "a curve")
        check.instance(self.orientations, "orientations", RotationCurve, "a curve of rotations")
        a, b = self.positions.domain, self.orientations.domain
        if not np.allclose(a, b, rtol=0.0, atol=_SAME * (a[1] - a[0])):
            raise InvalidInput(f"orientations: expected the domain {a} of positions, got {b}")
        dimensions = len(self.positions.evaluate(a[0]))
        if dimensions != 3:
            raise InvalidInput(f"positions: expected a curve in 3-D, got {dimensions}-D")

    @property
    def domain(self) -> tuple[float, float]:
        """First and last time."""
        return self.positions.domain

    @property
    def knots(self) -> Float64Array:
        """The knots of both."""
        return np.union1d(self.positions.knots, self.orientations.knots)

    def evaluate(self, t: ArrayLike, derivative: int = 0) -> tuple[Float64Array, Float64Array]:
        """Positions and rotations, or linear and angular velocities or accelerations.

        Args:
            t: times of the domain, (n,) or one.
            derivative: 0, 1 or 2.

        Returns:
            Positions (n, 3) and unit quaternions (n, 4), or their derivatives, (n, 3) each, in the
            base frame.
        """
        times = curve.times_inside(t, self.domain)
        return (
            self.positions.evaluate(times, derivative),
            self.orientations.evaluate(times, derivative),
        )

    def sampled(self, times: ArrayLike) -> PoseTrajectory:
        """The poses at given times.

        Args:
            times: strictly increasing, (n,), of the domain.
        """
        t = curve.times_inside(times, self.domain)
        return PoseTrajectory(t, *self.evaluate(t))

"""Rotations with their angular velocities and accelerations, carried through exp and slerp exactly.

All in the base frame. Along a rotation vector phi(t) the rotation exp(phi) turns with J phi' and
J phi'' + dJ/dt phi', where J v = A v + B phi x v + C phi (phi . v) for an angle x = |phi| and
A = sin x / x, B = (1 - cos x) / x^2, C = (x - sin x) / x^3 (Sola et al. 2018, eq. 145).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from leadthrough import _core
from leadthrough.check import Float64Array

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
        """Rotations that do not turn."""
        return Turning(q, np.zeros((len(q), 3)), np.zeros((len(q), 3)))

    def then(self, outer: Turning) -> Turning:
        """`outer` after this one."""
        matrices = _core.so3_to_matrix(outer.q).reshape(-1, 3, 3)
        carried = products(matrices, self.velocity)
        return Turning(
            _core.so3_compose(outer.q, self.q),
            outer.velocity + carried,
            outer.acceleration
            + np.cross(outer.velocity, carried)
            + products(matrices, self.acceleration),
        )

    def inverse(self) -> Turning:
        """The inverse rotations, and how they turn."""
        back = self.q * np.array([1.0, -1.0, -1.0, -1.0])
        matrices = _core.so3_to_matrix(back).reshape(-1, 3, 3)
        return Turning(
            back, -products(matrices, self.velocity), -products(matrices, self.acceleration)
        )


def turning_of(phi: Float64Array, first: Float64Array, second: Float64Array) -> Turning:
    """The turning of exp(phi), for rotation vectors phi (n, 3) and their two derivatives."""
    jacobians = _core.so3_left_jacobian(phi).reshape(-1, 3, 3)
    return Turning(
        _core.so3_exp(phi),
        products(jacobians, first),
        products(jacobians, second) + drift(phi, first),
    )


def vectors_of(turning: Turning) -> tuple[Float64Array, Float64Array, Float64Array]:
    """The shortest rotation vectors (n, 3) with two derivatives; no rotation is half a turn."""
    phi = _core.so3_log(turning.q)
    inverses = _core.so3_left_jacobian_inverse(phi).reshape(-1, 3, 3)
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
    """The products of matrices (n, 3, 3) and vectors (n, 3)."""
    return np.asarray(np.einsum("nij,nj->ni", matrices, vectors))

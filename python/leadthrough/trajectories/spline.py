"""Curves of polynomial pieces."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.interpolate import PPoly

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.trajectories import curve


@dataclass(frozen=True, eq=False)
class Spline:
    """Polynomial pieces from knot to knot.

    knots: (k + 1,) rising. coefficients: (k, terms, d); of piece i at time t the value is the sum
    over j of coefficients[i, j] (t - knots[i])**j. At a knot the piece after it counts.
    Raises InvalidInput.
    """

    knots: Float64Array
    coefficients: Float64Array
    _pieces: PPoly = field(init=False, repr=False)

    def __post_init__(self) -> None:
        knots = curve.knot_times(self.knots, "knots")
        table = check.frozen(
            self.coefficients, "coefficients", shape=(len(knots) - 1, "terms", "d")
        )
        if 0 in table.shape:
            raise InvalidInput(f"coefficients: expected no empty axis, got shape {table.shape}")
        object.__setattr__(self, "knots", knots)
        object.__setattr__(self, "coefficients", table)
        falling = np.ascontiguousarray(table.transpose(1, 0, 2)[::-1])
        object.__setattr__(self, "_pieces", PPoly.construct_fast(falling, knots, False))

    def __reduce__(self) -> tuple[Any, ...]:
        return Spline, (self.knots, self.coefficients)

    @property
    def domain(self) -> tuple[float, float]:
        """First and last time."""
        return float(self.knots[0]), float(self.knots[-1])

    @property
    def degree(self) -> int:
        """The largest degree that the pieces can have."""
        return int(self.coefficients.shape[1]) - 1

    def evaluate(self, t: Any, derivative: int = 0) -> Float64Array:
        """Values or derivatives (n, d) at times (n,), (d,) at one time. Raises InvalidInput."""
        return np.asarray(self._pieces(curve.times_inside(t, self.domain), curve.order(derivative)))

    def smoothness(self, *, tolerance: float = 1e-9) -> Float64Array:
        """(k - 1,) how many derivatives, the value as the first, agree at each inner knot.

        tolerance: difference that counts as none, relative to the largest derivative.
        """
        agree = np.zeros(len(self.knots) - 2)
        going = np.ones(len(self.knots) - 2, dtype=bool)
        widths = np.diff(self.knots)[:, None]
        for k in range(self.degree + 1):
            starts = self.coefficients[1:, k]
            ends = np.zeros_like(starts)
            for j in range(k, self.degree + 1):
                ends += math.comb(j, k) * widths[:-1] ** (j - k) * self.coefficients[:-1, j]
            scale = max(
                float(np.abs(self.coefficients[:, k]).max()), float(np.abs(ends).max(initial=0.0))
            )
            going = going & (np.abs(starts - ends).max(axis=1) <= tolerance * scale)
            agree += going
        return agree

    def transformed(self, matrix: Any, offset: Any = 0.0) -> Spline:
        """The curve of matrix @ x + offset for every x of this one: its points transformed.

        matrix: (e, d). offset: (e,) or a number. Raises InvalidInput.
        """
        a, b = affine(matrix, offset, self.coefficients.shape[2])
        table = self.coefficients @ a.T
        table[:, 0] += b
        return Spline(self.knots, table)

    def rescaled(self, factor: float) -> Spline:
        """The same path, passed `factor` times as slowly: derivative k becomes factor**-k of it."""
        stretch = check.number(factor, "factor", above=0.0)
        powers = stretch ** -np.arange(self.degree + 1.0)
        return Spline(self.knots * stretch, self.coefficients * powers[:, None])


def affine(matrix: Any, offset: Any, width: int) -> tuple[Float64Array, Float64Array]:
    """An affine map, checked: matrix (e, width) and offset (e,)."""
    a = check.array(matrix, "matrix", shape=("e", width))
    b = check.array(offset, "offset", shape=() if np.ndim(offset) == 0 else (len(a),))
    return a, np.broadcast_to(b, len(a))

"""Curves of polynomial pieces."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.trajectories import curve
from leadthrough.trajectories.curve import PointCurve


@dataclass(frozen=True, eq=False, init=False)
class Spline(PointCurve):
    """Polynomial pieces from knot to knot.

    Attributes:
        knots: strictly increasing times (k + 1,); at an inner knot the piece after it counts.
        coefficients: (k, terms, d); the value of piece i at time t is the sum over j of
            coefficients[i, j] (t - knots[i])**j.
    """

    knots: Float64Array
    coefficients: Float64Array

    def __init__(self, knots: ArrayLike, coefficients: ArrayLike) -> None:
        times = curve.knot_times(knots, "knots")
        table = check.frozen(coefficients, "coefficients", shape=(len(times) - 1, "terms", "d"))
        if 0 in table.shape:
            raise InvalidInput(f"coefficients: expected no empty axis, got shape {table.shape}")
        vars(self).update(knots=times, coefficients=table)

    @property
    def domain(self) -> tuple[float, float]:
        """First and last time."""
        return float(self.knots[0]), float(self.knots[-1])

    @property
    def degree(self) -> int:
        """The largest degree that the pieces can have."""
        return int(self.coefficients.shape[1]) - 1

    def smoothness(self, *, tolerance: float = 1e-9) -> Float64Array:
        """How many derivatives, the value counted as the first, agree at each inner knot, (k - 1,).

        Args:
            tolerance: largest difference that counts as none, relative to the largest derivative.
        """
        agree = np.zeros(len(self.knots) - 2)
        going = np.ones(len(self.knots) - 2, dtype=bool)
        for k in range(self.degree + 1):
            starts, ends = self.coefficients[1:, k], self._at_ends(k)
            scale = max(
                float(np.abs(self.coefficients[:, k]).max()), float(np.abs(ends).max(initial=0.0))
            )
            going = going & (np.abs(starts - ends).max(axis=1) <= tolerance * scale)
            agree += going
        return agree

    def _at_ends(self, k: int) -> Float64Array:
        """Derivative k over k! of each piece but the last at its end, (k - 1, d)."""
        widths = np.diff(self.knots)[:-1, None]
        ends = np.zeros_like(self.coefficients[1:, k])
        for j in range(k, self.degree + 1):
            ends += math.comb(j, k) * widths ** (j - k) * self.coefficients[:-1, j]
        return ends

    def _values(self, times: Float64Array, order: int) -> Float64Array:
        rows = self.coefficients.reshape(-1, self.coefficients.shape[2])
        values = core.polynomial_values(
            self.knots, rows, np.atleast_1d(times), min(order, len(rows))
        )
        return values if times.ndim else values[0]

    def _mapped(self, matrix: Float64Array, offset: Float64Array) -> Self:
        table = self.coefficients @ matrix.T
        table[:, 0] += offset
        return replace(self, coefficients=table)

    def _stretched(self, factor: float) -> Self:
        powers = factor ** -np.arange(self.degree + 1.0)
        table = self.coefficients * powers[:, None]
        return replace(self, knots=self.knots * factor, coefficients=table)

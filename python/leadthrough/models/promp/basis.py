"""Basis functions over the phase of a motion: Gaussian, B-spline or rhythmic.

The functions of a basis sum to one at every phase, so that equal weights give a constant.

Source: Paraschos et al. 2018, "Using probabilistic movement primitives in robotics", section 2.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Literal, TypeAlias, get_args

import numpy as np

from leadthrough import _core
from leadthrough.check import Float64Array
from leadthrough.repr import ShortRepr

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

BasisKind: TypeAlias = Literal["bspline", "gaussian", "rhythmic"]
KINDS = get_args(BasisKind)

_DEGREE = 3
# Fewer functions cannot bend, and a period needs three points.
LEAST = 4


@dataclass(frozen=True)
class Basis(ShortRepr):
    """Basis functions of one kind over the phase of a motion."""

    kind: BasisKind  # "gaussian", "bspline" or "rhythmic" (von Mises functions, of period 1)
    count: int  # number of functions, k
    width: float = 1.0
    margin: float = 1.0

    @property
    def is_rhythmic(self) -> bool:
        """Whether phases 0 and 1 are the same."""
        return self.kind == "rhythmic"

    def __call__(self, phases: Float64Array, order: int = 0) -> Float64Array:
        """Values of the functions, or their derivatives with respect to the phase."""
        if self.kind == "bspline":
            return np.asarray(self._spline(phases, order))
        bells = phases, self.centres, self.sharpness, self.is_rhythmic
        return _core.normalised_bells(*bells, order)

    def curves(
        self,
        phases: Float64Array,
        weights: Float64Array,
        paces: Float64Array,
        *,
        most: int,
        threads: int,
    ) -> tuple[list[Float64Array], bool]:
        """Curves of many weights and their derivatives, and whether all are certainly finite."""
        if self.kind == "bspline":
            rows = [self._spline(phases, order) * pace for order, pace in enumerate(paces)]
            return _core.curves_over(np.concatenate(rows), len(paces), weights, most, threads)
        bells = phases, self.centres, self.sharpness, self.is_rhythmic
        return _core.curves_over_bells(*bells, paces, weights, most, threads)

    @cached_property
    def centres(self) -> Float64Array:
        """Centres (k,) of the functions."""
        if self.is_rhythmic:
            return np.asarray(np.arange(self.count) / self.count)
        if self.kind == "gaussian":
            return np.asarray((np.arange(self.count) - self.margin) / self._spacings)
        knots = self._spline.t
        means = [float(knots[i + 1 : i + 1 + _DEGREE].mean()) for i in range(self.count)]
        return np.asarray(means)

    @cached_property
    def roughness(self) -> Float64Array:
        """Matrix R (k, k) such that w @ R @ w sums the squared second differences of weights w."""
        if self.is_rhythmic:
            steps = np.roll(np.eye(self.count), 1, axis=1) - np.eye(self.count)
            differences = steps @ steps
        else:
            differences = np.diff(np.eye(self.count), 2, axis=0)
        return np.asarray(differences.T @ differences)

    @cached_property
    def _spline(self) -> BSpline:
        from scipy.interpolate import BSpline

        inner = np.linspace(0.0, 1.0, self.count - _DEGREE + 1)
        knots = np.concatenate([np.zeros(_DEGREE), inner, np.ones(_DEGREE)])
        return BSpline(knots, np.eye(self.count), _DEGREE)

    @cached_property
    def sharpness(self) -> float:
        """One over the variance of a Gaussian function, or a von Mises one's concentration."""
        if self.is_rhythmic:
            return (self.count / (2.0 * np.pi * self.width)) ** 2
        return (self._spacings / self.width) ** 2

    @property
    def _spacings(self) -> float:
        """How many spacings of Gaussian centres the motion is long."""
        return self.count - 1.0 - 2.0 * self.margin

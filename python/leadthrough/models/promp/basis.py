"""Basis functions over the phase of a motion: Gaussian, B-spline, rhythmic.

Each set sums to one everywhere, so that equal weights are a constant.
Source: Paraschos et al. 2018, "Using probabilistic movement primitives in robotics", section 2.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import BSpline

from leadthrough import _core
from leadthrough.check import Float64Array

KINDS = ("bspline", "gaussian", "rhythmic")

_DEGREE = 3
# Fewer cannot bend, and a period needs three points.
LEAST = 4


@dataclass(frozen=True)
class Basis:
    """count basis functions of a kind over the phase, [0, 1] or, rhythmic, any with period 1.

    width: standard deviation of bells in spacings of their centres; B-splines have none.
    """

    kind: str
    count: int
    width: float = 1.0

    @property
    def is_rhythmic(self) -> bool:
        """Whether phases 0 and 1 are the same."""
        return self.kind == "rhythmic"

    def __call__(self, phases: Float64Array, order: int = 0) -> Float64Array:
        """Values (n, count), or derivatives by the phase, of order 1 or 2, at phases (n,)."""
        if self.kind == "bspline":
            return np.asarray(self._spline(phases, order))
        return _core.normalised_bells(
            phases, self.centres, self._sharpness, self.is_rhythmic, order
        )

    @cached_property
    def centres(self) -> Float64Array:
        """The phases (count,) about which the functions lie; beyond the ends by one Gaussian."""
        if self.is_rhythmic:
            return np.asarray(np.arange(self.count) / self.count)
        if self.kind == "gaussian":
            return np.asarray((np.arange(self.count) - 1.0) / (self.count - 3.0))
        knots = self._spline.t
        means = [float(knots[i + 1 : i + 1 + _DEGREE].mean()) for i in range(self.count)]
        return np.asarray(means)

    @cached_property
    def roughness(self) -> Float64Array:
        """The form (count, count) that sums the squared second differences of weights."""
        if self.is_rhythmic:
            steps = np.roll(np.eye(self.count), 1, axis=1) - np.eye(self.count)
            differences = steps @ steps
        else:
            differences = np.diff(np.eye(self.count), 2, axis=0)
        return np.asarray(differences.T @ differences)

    @cached_property
    def _spline(self) -> BSpline:
        inner = np.linspace(0.0, 1.0, self.count - _DEGREE + 1)
        knots = np.concatenate([np.zeros(_DEGREE), inner, np.ones(_DEGREE)])
        return BSpline(knots, np.eye(self.count), _DEGREE)

    @cached_property
    def _sharpness(self) -> float:
        """Of the bells: for Gaussians one over the variance, for von Mises the concentration."""
        if self.is_rhythmic:
            return (self.count / (2.0 * np.pi * self.width)) ** 2
        return ((self.count - 3.0) / self.width) ** 2

"""Basis functions over the phase of a motion: Gaussian, B-spline, rhythmic.

Each set sums to one everywhere, so that equal weights are a constant.
Source: Paraschos et al. 2018, "Using probabilistic movement primitives in robotics", section 2.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.interpolate import BSpline

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
        return self._normalised(phases, order)

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

    def _normalised(self, phases: Float64Array, order: int) -> Float64Array:
        """Bells over their sum: f = b / S, and by differentiating f S = b."""
        bell, slope, bend = self._bells(phases, order)
        total = bell.sum(axis=1, keepdims=True)
        values = bell / total
        if order == 0:
            return np.asarray(values)
        rise = slope.sum(axis=1, keepdims=True)
        slopes = (slope - values * rise) / total
        if order == 1:
            return np.asarray(slopes)
        bends = bend.sum(axis=1, keepdims=True)
        return np.asarray((bend - 2.0 * slopes * rise - values * bends) / total)

    def _bells(self, phases: Float64Array, order: int) -> tuple[Any, Any, Any]:
        """The unnormalised functions and, up to an order, their derivatives, each (n, count)."""
        offsets = phases[:, None] - self.centres
        if self.is_rhythmic:  # of von Mises
            sharpness = (self.count / (2.0 * np.pi * self.width)) ** 2
            turn = 2.0 * np.pi * offsets
            bell = np.exp(sharpness * (np.cos(turn) - 1.0))
            if order == 0:
                return bell, None, None
            slope = -2.0 * np.pi * sharpness * np.sin(turn)
            bend = -((2.0 * np.pi) ** 2) * sharpness * np.cos(turn)
            return bell, slope * bell, (bend + slope**2) * bell
        precision = ((self.count - 3.0) / self.width) ** 2
        bell = np.exp(-0.5 * precision * offsets**2)
        if order == 0:
            return bell, None, None
        slope = -precision * offsets
        return bell, slope * bell, (slope**2 - precision) * bell

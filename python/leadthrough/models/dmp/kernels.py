"""The canonical system, and the functions of the phase that a primitive's force is made of.

The phase u of this package is time by duration: 0 at the start, 1 at the end. The literature's
canonical state is x = exp(-DECAY u), the solution of tau x' = -DECAY x.
Source: Ijspeert et al. 2013, section 2.1.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from leadthrough.check import Float64Array

DECAY = float(-np.log(0.01))  # x ends at 1 %, as in Pastor et al. 2009
MOST_WEIGHTS = 1000

# A guided hand moves with frequencies below some 2 Hz: four kernels per second.
_WEIGHTS_PER_SECOND = 4.0
_USUAL_WEIGHTS = 50

# A force is tabulated at this many evenly spaced phases per weight, and is linear between them.
_INTERVALS_PER_WEIGHT = 20
# Value of a kernel at its neighbour's centre; 1 at its own.
_OVERLAP = 0.8


def enough_weights(duration: float) -> int:
    """Number of kernels for a motion of a duration, s: 4 per second, from 50 to 1000."""
    return int(min(max(_WEIGHTS_PER_SECOND * duration, _USUAL_WEIGHTS), MOST_WEIGHTS))


@dataclass(frozen=True, eq=False)
class Kernels:
    """Kernels tabulated at evenly spaced phases from 0 to 1."""

    phases: Float64Array  # (m,)
    values: Float64Array  # (m, weights), not normalised
    regressor: Float64Array  # (m, weights), what a weight multiplies where its kernel alone counts
    fade: Float64Array  # (m,) canonical state
    rhythmic: bool  # whether they repeat with period 1

    @cached_property
    def features(self) -> Float64Array:
        """Features (m, weights): the force is features @ weights."""
        return np.asarray(self.values / self.values.sum(axis=1, keepdims=True) * self.regressor)


@lru_cache(maxsize=8)
def discrete(weights: int) -> Kernels:
    """Gaussian kernels in the canonical state x, whose regressor is x / c_i.

    The centres c_i = exp(-DECAY i / (weights - 1)) are evenly spaced in time; the widths follow
    from the overlap. The literature does not divide by c_i; it makes all weights similar in size.
    """
    centres = _canonical_state(np.linspace(0.0, 1.0, weights))
    gaps = -np.diff(centres)
    inverse_widths = -np.log(_OVERLAP) / np.append(gaps, gaps[-1]) ** 2
    phases = _node_phases(weights)
    x = _canonical_state(phases)
    kernels = np.exp(-inverse_widths * (x[:, None] - centres) ** 2)
    return Kernels(phases, kernels, x[:, None] / centres, x, rhythmic=False)


@lru_cache(maxsize=8)
def rhythmic(weights: int) -> Kernels:
    """Von Mises kernels, evenly spaced, whose regressor is 1."""
    phases = _node_phases(weights)
    width = -np.log(_OVERLAP) / (1.0 - np.cos(2.0 * np.pi / weights))
    angles = 2.0 * np.pi * (phases[:, None] - np.arange(weights) / weights)
    kernels = np.exp(width * (np.cos(angles) - 1.0))
    return Kernels(phases, kernels, np.ones_like(kernels), np.zeros_like(phases), rhythmic=True)


def _canonical_state(phases: Float64Array) -> Float64Array:
    return np.asarray(np.exp(-DECAY * phases))


def _node_phases(weights: int) -> Float64Array:
    return np.linspace(0.0, 1.0, _INTERVALS_PER_WEIGHT * weights + 1)

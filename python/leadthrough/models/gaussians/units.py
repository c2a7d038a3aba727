"""The units in which EM measures points.

EM itself does not depend on units; its starts and its least variance do. For motions, positions of
poses share one unit, as a direction in which the demonstrations hardly move tells no phases, and
rotations have theirs. The time counts by slices: a component of average length has deviation one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from leadthrough.check import Float64Array

_ROTATION_UNIT = 1.0  # rad
_POSITION, _ROTATION = slice(1, 4), slice(4, 7)  # columns after the time


@dataclass(frozen=True, eq=False)
class Units:
    """What is subtracted from columns, and what they are divided by."""

    middle: Float64Array  # means (d,) of the columns
    scale: Float64Array  # units (d,) of the columns

    @property
    def log_volume(self) -> float:
        """What log densities in these units exceed those in the columns' own units by."""
        return float(np.log(self.scale).sum())

    def scaled(self, points: Float64Array) -> Float64Array:
        """Points (n, d) in these units."""
        return (points - self.middle) / self.scale

    def scaled_covariances(self, covariances: Float64Array) -> Float64Array:
        """Covariances (k, d, d) in these units."""
        return covariances / self.scale / self.scale[:, None]

    def means(self, scaled: Float64Array) -> Float64Array:
        """Means (k, d) in the columns' own units."""
        return scaled * self.scale + self.middle

    def covariances(self, scaled: Float64Array) -> Float64Array:
        """Covariances (k, d, d) in the columns' own units."""
        return scaled * self.scale * self.scale[:, None]


def own_units(points: Float64Array) -> Units:
    """Means and standard deviations of columns; deviation 1 where all values are the same."""
    middle, deviations = points.mean(axis=0), points.std(axis=0)
    rounding = 1e-12 * np.abs(middle)
    return Units(middle, np.where(deviations > rounding, deviations, 1.0))


def phase_units(own: Units, count: int, *, poses: bool) -> Units:
    """Units of the time and the columns of motions, for components that follow phases."""
    scale = own.scale.copy()
    scale[0] /= count
    if poses:
        scale[_POSITION] = scale[_POSITION].max()
        scale[_ROTATION] = _ROTATION_UNIT
    return Units(own.middle, scale)

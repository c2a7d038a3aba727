"""The units in which EM measures points, and the least variance that it may conclude in them.

EM itself does not depend on units; its starts and its least variance do. Columns that are scaled
to variance one each have a least variance of their own. For poses that is too little: relative to
the reference, orientations vary by hundredths of a radian, and of a few demonstrations the least
deviation is then 1e-5 rad. The likelihood of such thin components outweighs that of all positions,
so that they follow single demonstrations and not the phases of all, and one sample changed by a
millimetre lets another start win. So positions share one unit, and rotations have theirs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.models.mixtures.em import LEAST_VARIANCE

# A deviation of 3 % of the unit, about 1 % of the motion's extent.
LEAST_VARIANCE_OF_POSES = 1e-3
_ROTATION_UNIT = 1.0  # rad
_POSITION, _ROTATION = slice(1, 4), slice(4, 7)  # columns after the time


@dataclass(frozen=True, eq=False)
class Units:
    """What is subtracted from columns, and what they are divided by.

    Attributes:
        middle: means (d,) of the columns.
        scale: units (d,) of the columns.
        least: least variance of a component in any direction, in these units.
    """

    middle: Float64Array
    scale: Float64Array
    least: float = LEAST_VARIANCE

    def scaled(self, points: Float64Array) -> Float64Array:
        """Points (n, d) in these units."""
        return (points - self.middle) / self.scale

    def means(self, scaled: Float64Array) -> Float64Array:
        """Means (k, d) in the columns' own units."""
        return scaled * self.scale + self.middle

    def covariances(self, scaled: Float64Array) -> Float64Array:
        """Covariances (k, d, d) in the columns' own units."""
        return scaled * self.scale * self.scale[:, None]


def own_units(points: Float64Array) -> Units:
    """Means and standard deviations of columns; deviation 1 where all values are the same.

    Args:
        points: points (n, d).
    """
    middle, deviations = points.mean(axis=0), points.std(axis=0)
    rounding = 1e-12 * np.abs(middle)
    return Units(middle, np.where(deviations > rounding, deviations, 1.0))


def pose_units(points: Float64Array) -> Units:
    """Units of the time, which has its own, of positions, which share the widest one's, and rad.

    Args:
        points: times and columns (n, 7) of poses.
    """
    return of_poses(own_units(points))


def of_poses(own: Units) -> Units:
    """Units of poses, as `pose_units` has them, of the columns' own ones.

    Args:
        own: means and standard deviations of the time and the columns.
    """
    scale = own.scale.copy()
    scale[_POSITION] = scale[_POSITION].max()
    scale[_ROTATION] = _ROTATION_UNIT
    return Units(own.middle, scale, LEAST_VARIANCE_OF_POSES)

"""Point clouds, as depth cameras and scanners record them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.shapes import surface
from leadthrough.shapes.shape import IDENTITY, ConvexPart, PointBased, checked_points, pose
from leadthrough.shapes.surface import Surface

MAX_POINTS = 1_000_000  # their tree takes 100 MB


@dataclass(frozen=True, eq=False, init=False)
class PointCloud(PointBased):
    """Balls of one radius around points.

    The balls stand for what lies between the points too: a radius of half the points' spacing, with
    the noise of their measurement added, leaves no holes. They are kept in a tree, so that a check
    of ten thousand takes microseconds.

    Attributes:
        points: (n, 3), n > 0, m in the cloud's own frame.
        radius: of each ball, m, > 0.
        position: of the cloud's frame in the base frame, (3,), m; by default its origin.
        orientation: w, x, y, z of the cloud's frame in the base frame, (4,); by default the
            same.

    Raises:
        InvalidInput: if there are no points or more than a million.
    """

    points: Float64Array
    radius: float
    position: Float64Array
    orientation: Float64Array

    def __init__(
        self,
        points: ArrayLike,
        radius: float,
        position: ArrayLike = (0.0, 0.0, 0.0),
        orientation: ArrayLike = IDENTITY,
    ) -> None:
        seen = checked_points(points, "points")
        if not 0 < len(seen) <= MAX_POINTS:
            raise InvalidInput(
                f"points: expected 1 to {MAX_POINTS:,} points, got {len(seen):,}"
                + ("; keep one point per cube of the radius" if len(seen) else "")
            )
        vars(self).update(
            points=seen,
            radius=check.number(radius, "radius", above=0.0),
            **pose(position, orientation),
        )

    def surface(self) -> Surface:
        return surface.dots(self.points, self.radius)

    def convex_parts(self) -> Iterator[ConvexPart]:
        for point in self._outline():
            yield ConvexPart("sphere", (self.radius,), point, np.array(IDENTITY))

    def _outline(self) -> Float64Array:
        return np.asarray(self.points @ self._rotation.T + self.position)

    @property
    def _rounding(self) -> float:
        return self.radius

    def _compile(self) -> core.Shape:
        return core.cloud_shape(self.points, self.radius, self.position, self.orientation)

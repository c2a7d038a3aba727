"""Obstacles, each with a signed distance: negative inside, zero on the surface.

What planners and kernels have to know of a kind of shape, the shape itself answers.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from leadthrough import _core
from leadthrough.errors import InvalidInput
from leadthrough.shapes.box import Box
from leadthrough.shapes.cloud import PointCloud
from leadthrough.shapes.hull import Hull
from leadthrough.shapes.mesh import Mesh
from leadthrough.shapes.round import Capsule, Cylinder, Sphere

__all__ = [
    "Box",
    "Capsule",
    "Cylinder",
    "Hull",
    "Mesh",
    "PointCloud",
    "Shape",
    "Sphere",
    "check_shapes",
    "compiled",
]

Shape = Box | Sphere | Capsule | Cylinder | Mesh | PointCloud


def check_shapes(obstacles: Iterable[Shape]) -> tuple[Shape, ...]:
    """The obstacles, if all are shapes."""
    if not isinstance(obstacles, Iterable):
        raise InvalidInput(f"obstacles: expected a sequence, got {type(obstacles).__name__}")
    shapes = tuple(obstacles)
    for shape in shapes:
        if not isinstance(shape, Shape):
            raise InvalidInput(
                "obstacles: expected Box, Sphere, Capsule, Cylinder, Mesh or PointCloud, "
                f"got {type(shape).__name__}"
            )
    return shapes


def compiled(shapes: Sequence[Shape]) -> list[_core.Shape]:
    """The shapes as the compiled core takes them."""
    return [shape._compiled for shape in shapes]

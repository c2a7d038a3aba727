"""All shapes: the command line, the messages and the tests read this list."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import leadthrough._core as core
from leadthrough.check import InvalidInput
from leadthrough.shapes.cloud import PointCloud
from leadthrough.shapes.mesh import Mesh
from leadthrough.shapes.primitives import PRIMITIVES
from leadthrough.shapes.shape import Shape

SHAPES: tuple[type[Shape], ...] = (*PRIMITIVES.values(), Mesh, PointCloud)


def names_of(kind: type[Shape]) -> str:
    """The names of the shapes of a kind, as in "Box, Sphere or Mesh"."""
    *others, last = (shape.__name__ for shape in SHAPES if issubclass(shape, kind))
    return f"{', '.join(others)} or {last}"


def check_shapes(obstacles: Iterable[Shape]) -> tuple[Shape, ...]:
    """The obstacles, if all are shapes."""
    if not isinstance(obstacles, Iterable):
        raise InvalidInput(f"obstacles: expected a sequence, got {type(obstacles).__name__}")
    shapes = tuple(obstacles)
    for shape in shapes:
        if not isinstance(shape, Shape):
            raise InvalidInput(f"obstacles: expected {names_of(Shape)}, got {type(shape).__name__}")
    return shapes


def compiled(shapes: Sequence[Shape]) -> list[core.Shape]:
    """The shapes as the compiled core takes them."""
    return [shape._compiled for shape in shapes]

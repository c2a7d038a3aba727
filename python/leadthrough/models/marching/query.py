"""What Fast Marching Learning is asked for: start, goal and obstacles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.models.marching.experience import Experience
from leadthrough.models.place import Place
from leadthrough.shapes import Shape


@dataclass(frozen=True, eq=False)
class Query:
    """Where a path leads, and around what."""

    start: Float64Array  # (d,)
    goal: Float64Array  # (d,)
    obstacles: tuple[Shape, ...] = ()  # shapes in the same frame

    @property
    def ends(self) -> Float64Array:
        """Start and goal, (2, d)."""
        return np.stack([self.start, self.goal])


def query_of(
    demonstrated: Sequence[Experience],
    start: Place | None,
    goal: Place | None,
    obstacles: tuple[Shape, ...] = (),
) -> Query:
    """The query of a user; what is left out is the mean of the demonstrations' ends."""
    first = _end(demonstrated, split(demonstrated, start, "start")[0], "start", 0)
    last = _end(demonstrated, split(demonstrated, goal, "goal")[0], "goal", -1)
    if len(first) != len(last):
        raise InvalidInput(f"goal: expected shape {first.shape}, got {last.shape}")
    return Query(first, last, obstacles)


def split(
    demonstrated: Sequence[Experience], value: Any, name: str
) -> tuple[Any, Float64Array | None]:
    """A query's position, not checked yet, and its orientation (4,) if it has one."""
    of_poses = bool(demonstrated) and demonstrated[0].orientations is not None
    if not of_poses or not isinstance(value, tuple | list) or len(value) != 2:
        return value, None
    return value[0], check.quaternions(value[1], name, shape=(4,))


def _end(
    demonstrated: Sequence[Experience], value: ArrayLike | None, name: str, index: int
) -> Float64Array:
    """A start or goal (d,), by default the mean of the demonstrations' points at an index."""
    if demonstrated:
        if value is None:
            return np.asarray(np.mean([each.path[index] for each in demonstrated], axis=0))
        return check.array(value, name, shape=(demonstrated[0].path.shape[1],))
    if value is None:
        raise InvalidInput(
            f"{name}: expected a point, as there is no demonstration to take it from"
        )
    point = check.array(value, name, shape=("d",))
    if len(point) not in (2, 3):
        raise InvalidInput(f"{name}: expected 2 or 3 coordinates, got {len(point)}")
    return point

"""Quick answers of a Fast Marching skill while a goal and obstacles are dragged."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Generic

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.models.marching.live_map import LiveMap
from leadthrough.models.place import Place
from leadthrough.motion import MotionT_co
from leadthrough.shapes import Shape

if TYPE_CHECKING:
    from leadthrough.models.marching.skill import FastMarchingSkill

# Cells of a map that is kept.
_KEPT_CELLS = 1_000_000
# Room around demonstrations, goal and obstacles, as a fraction of their extent, in which things may
# be dragged before a map that is kept has to be made anew.
_ROOM_TO_DRAG = 0.5


class Preview(Generic[MotionT_co]):
    """Answers of a skill while its query is dragged; made by `FastMarchingSkill.preview`."""

    def __init__(self, skill: FastMarchingSkill[MotionT_co]) -> None:
        self._skill = skill
        self._map: LiveMap | None = None

    @property
    def live_map(self) -> LiveMap | None:
        """The map that is kept; None before the first answer and with another method than "map"."""
        return self._map

    def generate(
        self,
        *,
        start: Place | None = None,
        goal: Place | None = None,
        duration: float | None = None,
        dt: float = 0.04,
        obstacles: Sequence[Shape] = (),
    ) -> MotionT_co:
        """A motion as by `FastMarchingSkill.generate`, which documents arguments and errors."""
        skill = self._skill
        if skill.model.method != "map":
            return skill.generate(
                start=start, goal=goal, duration=duration, dt=dt, obstacles=obstacles
            )
        ends = skill.query(start=start, goal=goal).ends
        found = self._map_around(ends, obstacles).route(ends[0], ends[1], obstacles)
        return skill.in_time(found, start=start, goal=goal, duration=duration, dt=dt)

    def _map_around(self, ends: Float64Array, obstacles: Sequence[Shape]) -> LiveMap:
        if self._map is None or not self._map.grid.contains(ends).all():
            space = self._workspace(ends, obstacles)
            self._map = self._skill.live_map(space, cells=_KEPT_CELLS)
        return self._map

    def _workspace(
        self, ends: Float64Array, obstacles: Sequence[Shape]
    ) -> tuple[Float64Array, Float64Array]:
        """Corners (d,) around demonstrations, ends (2, d) and the middles of obstacles."""
        middles = [shape.position[None, : ends.shape[1]] for shape in obstacles]
        points = np.concatenate([*self._skill.experience, *middles, ends])
        lower, upper = points.min(axis=0), points.max(axis=0)
        margin = _ROOM_TO_DRAG * float((upper - lower).max())
        return lower - margin, upper + margin

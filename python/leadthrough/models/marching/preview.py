"""Quick answers of a Fast Marching skill while a goal and obstacles are dragged."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Generic

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.models.marching.live_map import LiveMap
from leadthrough.models.place import Place
from leadthrough.motion import MotionT_co
from leadthrough.shapes import Shape

if TYPE_CHECKING:
    from leadthrough.models.marching.skill import FastMarchingSkill

# Cells of a map that is kept, and of one that is made anew for every answer.
_KEPT_CELLS = 1_000_000
_COARSE_CELLS = 40_000
# Room around demonstrations, goal and obstacles, as a fraction of their extent: what a path may
# need, and in which things may be dragged before a map that is kept has to be made anew.
_ROOM_TO_PASS = 0.25
_ROOM_TO_DRAG = 0.5


class Preview(Generic[MotionT_co]):
    """A skill of one method that answers quickly and coarsely; made by `FastMarchingSkill.preview`.

    With the method "map" the map of the demonstrations is kept from one answer to the next, and
    made anew when the goal leaves it. The other methods plan in large cells.
    """

    def __init__(self, skill: FastMarchingSkill[MotionT_co]) -> None:
        self._skill = skill
        self._map: LiveMap | None = None
        self._coarse: FastMarchingSkill[MotionT_co] | None = None

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
        ends = skill.query(start=start, goal=goal).ends
        if skill.model.method == "map":
            found = self._map_around(ends, obstacles).route(ends[0], ends[1], obstacles)
            return skill.in_time(found, start=start, goal=goal, duration=duration, dt=dt)
        if self._coarse is None:
            lower, upper = self._workspace(ends, obstacles, _ROOM_TO_PASS)
            edge = float((np.prod(upper - lower) / _COARSE_CELLS) ** (1.0 / len(lower)))
            self._coarse = replace(skill, model=replace(skill.model, resolution=edge))
        return self._coarse.generate(
            start=start, goal=goal, duration=duration, dt=dt, obstacles=obstacles
        )

    def _map_around(self, ends: Float64Array, obstacles: Sequence[Shape]) -> LiveMap:
        if self._map is None or not self._map.grid.contains(ends).all():
            space = self._workspace(ends, obstacles, _ROOM_TO_DRAG)
            self._map = self._skill.live_map(space, cells=_KEPT_CELLS)
        return self._map

    def _workspace(
        self, ends: Float64Array, obstacles: Sequence[Shape], room: float
    ) -> tuple[Float64Array, Float64Array]:
        """Corners (d,) around demonstrations, ends (2, d) and the middles of obstacles."""
        middles = [shape.position[None, : ends.shape[1]] for shape in obstacles]
        points = np.concatenate([*self._skill.experience, *middles, ends])
        lower, upper = points.min(axis=0), points.max(axis=0)
        margin = room * float((upper - lower).max())
        return lower - margin, upper + margin

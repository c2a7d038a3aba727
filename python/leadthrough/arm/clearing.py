"""Joints along a path of the tip with which the whole arm keeps clear.

The path is cut into layers, and a search goes from layer to layer over all that the task leaves
free. What it finds is made smooth and roomy as a whole, put back onto the path sample by sample,
and checked between samples with the room that a controller's curve through them takes.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from leadthrough import _core
from leadthrough.arm.options import all_axes, free_axes
from leadthrough.arm.tracks import TipPath
from leadthrough.check import Float64Array
from leadthrough.errors import IkFailure

# A hit between samples that is deeper than this isn't missed, m.
_TOLERANCE = 1e-3
# Bodies nearer by this than their margin are too near by any measure, m.
_TOUCHING = 2e-6
# m: with this margin, no two parts of an arm count as too near.
_ANY_OVERLAP = -10.0
# What the compiled core has.
_MOST_SEARCHES = 3
# Bodies that are named where there is no room.
_NAMED = 3


@dataclass(frozen=True, eq=False)
class Surroundings:
    """What an arm is to keep clear of."""

    model: _core.CollisionModel  # the arm's own shapes
    obstacles: list[_core.Shape]  # as the core takes them
    margin: float  # distance to keep from obstacles in m
    self_margin: float  # distance to keep between parts of the arm in m
    searches: int = _MOST_SEARCHES

    def clear_along(self, q: Float64Array) -> bool:
        """Whether straight motions from row to row of q (n, joints) keep the margins."""
        # Most motions that come too near to an obstacle do so at a row: that is quick to see.
        surely = self.margin - _TOUCHING
        at_rows = _core.clear_batch(self.model, self.obstacles, q, surely, _ANY_OVERLAP)
        return all(at_rows) and all(
            _core.check_motion(scene, q, margin, _TOLERANCE, 1)[2] is None
            for scene, margin in self._scenes
        )

    def clear_at(self, q: Float64Array) -> bool:
        """Whether the arm keeps the margins at every row of q (n, joints); quick to say no."""
        margins = self.margin, self.self_margin
        return all(_core.clear_batch(self.model, self.obstacles, q, *margins))

    @cached_property
    def _scenes(self) -> tuple[tuple[_core.CollisionScene, float], ...]:
        return (
            (_core.against(self.model, self.obstacles), self.margin),
            (_core.itself(self.model), self.self_margin),
        )


def clear_path(
    chain: _core.Chain,
    path: TipPath,
    around: Surroundings | None,
    *,
    start: Float64Array | None,
    tolerance: _core.IkTolerance,
) -> Float64Array:
    """Configurations (n, joints) along the path that keep clear, between samples too."""
    on_path = replace(path, tube=path.tube[:0])
    try:
        return _clear_path(chain, on_path, around, start, tolerance)
    except IkFailure:
        if not len(path.tube):
            raise
    return _clear_path(chain, path, around, start, tolerance)


def _clear_path(
    chain: _core.Chain,
    path: TipPath,
    around: Surroundings | None,
    start: Float64Array | None,
    tolerance: _core.IkTolerance,
) -> Float64Array:
    model, obstacles, margin, self_margin = (
        (None, [], 0.0, 0.0)
        if around is None
        else (around.model, around.obstacles, around.margin, around.self_margin)
    )
    q, last, sample, pairs, touch = _core.clear_path(
        chain,
        model,
        obstacles,
        path.positions,
        path.orientations,
        all_axes(path.free) if len(path.tube) else free_axes(path.free),
        path.postures,
        start,
        margin,
        self_margin,
        tolerance,
        path.tube,
        _MOST_SEARCHES if around is None else around.searches,
    )
    if len(q):
        return q
    if touch is not None:
        sample, distance, *bodies = touch
        found = f"{bodies[0]} and {bodies[1]} stay {1e3 * distance:.1f} mm apart at best"
    elif pairs:
        found = f"no room between {_bodies(pairs)}"
    else:
        found = "the tip cannot follow the path from there without a jump"
    time = float(np.interp(sample, np.arange(len(path)), path.times))
    index, status = int(sample), "blocked" if touch or pairs else "jump"
    message = f"sample {index} at {time:.6g} s: {status}, {found}"
    nearest = path.postures[index] if last is None else last
    raise IkFailure(message, index=index, status=status, residual=(0.0, 0.0), q=nearest.copy())


def _bodies(pairs: list[tuple[str, str, int]]) -> str:
    """The pairs of bodies that stood in the way most often."""
    counts: Counter[tuple[str, str]] = Counter()
    for a, b, count in pairs:
        counts[a, b] += count
    return ", ".join(f"{a} and {b}" for (a, b), _ in counts.most_common(_NAMED))

"""Joints along a path of the tip with which the whole arm keeps clear.

The path is cut into layers, and a search goes from layer to layer over all that the task leaves
free. Its path is made smooth and roomy as a whole, put back onto the path sample by sample,
and checked between samples with the room that a controller's curve through them takes.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

import leadthrough._core as core
from leadthrough.arm.inverse_kinematics import all_axes, free_axes
from leadthrough.arm.tip_path import TipPath
from leadthrough.check import Float64Array
from leadthrough.errors import IkFailure
from leadthrough.shapes import Scene, SceneLike, as_scene, compiled
from leadthrough.shapes.scene import PLANNING_TOLERANCE

# A hit between samples that is deeper than this isn't missed, m. The other half of the planning
# tolerance is left for the time law.
_TOLERANCE = 0.5 * PLANNING_TOLERANCE
# Bodies nearer by this than their margin are too near by any measure, m.
_TOUCHING = 2e-6
# m: with this margin, no two parts of an arm count as too near.
_ANY_OVERLAP = -10.0
# As in the compiled core.
_MAX_ATTEMPTS = 3
# Bodies that are named where there is no room.
_NAMED = 3


@dataclass(frozen=True, eq=False)
class CollisionTest:
    """Whether an arm keeps the margins of a scene, at configurations and along motions."""

    model: core.CollisionModel  # the arm's own shapes
    scene: Scene  # with the margins to keep
    max_attempts: int = _MAX_ATTEMPTS

    @staticmethod
    def of(model: core.CollisionModel, scene: SceneLike) -> CollisionTest:
        """The test that planning uses: it keeps the planning tolerance beyond the margins."""
        return CollisionTest(model, as_scene(scene).for_planning())

    def clear_along(self, q: Float64Array) -> bool:
        """Whether straight motions from row to row of q (n, joints) keep the margins."""
        # Most motions that come too near to an obstacle do so at a row: that is quick to see.
        surely = self.scene.margin - _TOUCHING
        at_rows = core.clear_batch(self.model, self.shapes, q, surely, _ANY_OVERLAP)
        return all(at_rows) and all(
            core.check_motion(pairs, q, margin, _TOLERANCE, 1)[2] is None
            for pairs, margin in self._pairs
        )

    def clear_at(self, q: Float64Array) -> bool:
        """Whether the arm keeps the margins at every row of q (n, joints); quick to say no."""
        return all(self.clear_rows(q))

    def clear_rows(self, q: Float64Array) -> list[bool]:
        """Whether the arm keeps the margins, for each row of q (n, joints)."""
        margins = self.scene.margin, self.scene.self_collision_margin
        return core.clear_batch(self.model, self.shapes, q, *margins)

    @cached_property
    def shapes(self) -> list[core.Shape]:
        """The obstacles as the core takes them."""
        return compiled(self.scene.shapes)

    @cached_property
    def _pairs(self) -> tuple[tuple[core.CollisionScene, float], ...]:
        return (
            (core.against(self.model, self.shapes), self.scene.margin),
            (core.itself(self.model), self.scene.self_collision_margin),
        )


def clear_path(
    chain: core.Chain,
    path: TipPath,
    around: CollisionTest | None,
    *,
    start: Float64Array | None,
    tolerance: core.IkTolerance,
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
    chain: core.Chain,
    path: TipPath,
    around: CollisionTest | None,
    start: Float64Array | None,
    tolerance: core.IkTolerance,
) -> Float64Array:
    scene = Scene(margin=0.0) if around is None else around.scene
    q, last, sample, pairs, touch = core.clear_path(
        chain,
        None if around is None else around.model,
        compiled(scene.shapes),
        path.positions,
        path.orientations,
        all_axes(path.free) if len(path.tube) else free_axes(path.free),
        path.postures,
        start,
        scene.margin,
        scene.self_collision_margin,
        tolerance,
        path.tube,
        _MAX_ATTEMPTS if around is None else around.max_attempts,
    )
    if len(q):
        return q
    if touch is not None:
        sample, distance, *bodies = touch
        reason = f"{bodies[0]} and {bodies[1]} stay {1e3 * distance:.1f} mm apart at best"
    elif pairs:
        reason = f"no room between {_bodies(pairs)}"
    else:
        reason = "the tip cannot follow the path from there without a jump"
    time = float(np.interp(sample, np.arange(len(path)), path.times))
    index, status = int(sample), "blocked" if touch or pairs else "jump"
    message = f"sample {index} at {time:.6g} s: {status}, {reason}"
    nearest = path.postures[index] if last is None else last
    raise IkFailure(message, index=index, status=status, residual=(0.0, 0.0), q=nearest.copy())


def _bodies(pairs: list[tuple[str, str, int]]) -> str:
    """The pairs of bodies that were too near most often."""
    counts: Counter[tuple[str, str]] = Counter()
    for a, b, count in pairs:
        counts[a, b] += count
    return ", ".join(f"{a} and {b}" for (a, b), _ in counts.most_common(_NAMED))

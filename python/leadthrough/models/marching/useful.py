"""Which demonstrations tell a path between two places where to go.

Those that go somewhere, and whose stretch past start and goal brings the tool nearer to the goal
about as fast as the demonstration itself gets on. A wandering demonstration does neither, so the
wave in a map of it would make detours that nobody has shown. It may still pass by both places in
nearly a straight line; whether the wave then keeps to that stretch shows when it is planned.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array
from leadthrough.models.marching import trust
from leadthrough.models.marching.experience import Experience
from leadthrough.models.marching.query import Query
from leadthrough.preprocess.resample import arc_length

# A detour up to this ratio to the straight line does no harm.
NO_DETOUR = 1.1
# Progress towards the goal for each length of way, as a fraction of the demonstration's own.
_AS_FAST = 0.5


@dataclass(frozen=True)
class Useful:
    """Which demonstrations (k,) of a skill are useful for a query."""

    certain: NDArray[np.bool_]  # those that lead from start to goal
    passing: NDArray[np.bool_]  # wandering ones that pass by both, nearly in a straight line


def useful(known: Sequence[Experience], query: Query) -> Useful:
    """Which demonstrations the map for a query is made of."""
    faced = [each.facing(query.start, query.goal) for each in known]
    ways = [each.way for each in faced]
    near = trust.trusted(ways, query.start, query.goal)
    alike = trust.in_company(ways)
    if shows_nothing(known):
        near, alike = np.zeros_like(near), np.zeros_like(alike)
    least = np.where(alike, 0.0, trust.STRAIGHT)
    leading = [_leads(*each, query) for each in zip(faced, least, strict=True)]
    certain = near | np.array(leading)
    passing = np.array([_passes_by(each, query) for each in faced])
    return Useful(certain | (passing & alike), passing & ~certain & ~alike)


def shows_nothing(known: Sequence[Experience]) -> bool:
    """Whether all that is known is one random walk."""
    return len(known) == 1 and known[0].wanders


def _leads(one: Experience, straight: float, query: Query) -> bool:
    """Whether a stretch of a demonstration, at least so straight, leads from start to goal."""
    first, last, _, stretch = _stretch(one.way, query)
    own = float(np.linalg.norm(one.way[-1] - one.way[0])) / one.length
    return own >= straight and _progress(first, last, query) >= _AS_FAST * own * stretch > 0.0


def _passes_by(one: Experience, query: Query) -> bool:
    """Whether the way past the demonstration's stretch is nearly as short as the straight one."""
    distance = float(np.linalg.norm(query.goal - query.start))
    _, _, gap, stretch = _stretch(one.way, query)
    return gap + stretch <= NO_DETOUR * distance


def _stretch(way: Float64Array, query: Query) -> tuple[Float64Array, Float64Array, float, float]:
    """The points nearest to start and goal, the sum of their gaps, and the way between them."""
    gaps = [np.linalg.norm(way - end, axis=1) for end in query.ends]
    nearest = [int(np.argmin(gap)) for gap in gaps]
    covered = arc_length(way)
    apart = abs(float(covered[nearest[1]] - covered[nearest[0]]))
    return way[nearest[0]], way[nearest[1]], float(gaps[0].min() + gaps[1].min()), apart


def _progress(first: Float64Array, last: Float64Array, query: Query) -> float:
    """By how much it is nearer to the goal and farther from the start at the stretch's end."""
    to_goal, from_start = (
        np.linalg.norm(np.stack([first, last]) - end, axis=1) for end in (query.goal, query.start)
    )
    return float(0.5 * (to_goal[0] - to_goal[1] + from_start[1] - from_start[0]))

"""Which demonstrations tell a path between two places where to go.

Those that go somewhere, and whose stretch past start and goal brings the tool nearer to the goal
about as fast as the demonstration itself gets on. A wandering demonstration does neither, so the
wave in a map of it would make detours that nobody has shown.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.models.marching import mean_path
from leadthrough.models.marching.experience import Experience
from leadthrough.models.marching.query import Query
from leadthrough.preprocess.resample import arc_length

# A detour up to this ratio to the straight line does no harm.
_NO_DETOUR = 1.1
# Distance from the first to the last point of a demonstration that goes somewhere, over its length.
_STRAIGHT = 0.5
# Progress towards the goal for each length of way, as a fraction of the demonstration's own.
_AS_FAST = 0.5


def useful(known: Sequence[Experience], query: Query) -> tuple[Experience, ...]:
    """The demonstrations that the map for a query is made of, in their order.

    Args:
        known: demonstrations and learned paths, which may be none.
        query: start and goal.
    """
    if not known:
        return ()
    faced = [each.facing(query.start, query.goal) for each in known]
    ways = [each.way for each in faced]
    near = mean_path.trusted(ways, query.start, query.goal)
    alike = mean_path.in_company(ways)
    return tuple(
        each
        for each, is_near, has_company in zip(faced, near, alike, strict=True)
        if is_near or _leads(each, query, straight=_STRAIGHT if not has_company else 0.0)
    )


def _leads(one: Experience, query: Query, *, straight: float) -> bool:
    """Whether a stretch of a demonstration, at least so straight, leads from start to goal."""
    distance = float(np.linalg.norm(query.goal - query.start))
    first, last, gap, stretch = _stretch(one.way, query)
    if gap + stretch <= _NO_DETOUR * distance:
        return True
    own = float(np.linalg.norm(one.way[-1] - one.way[0])) / one.length
    return own >= straight and _progress(first, last, query) >= _AS_FAST * own * stretch > 0.0


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

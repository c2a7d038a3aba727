"""Small moves of start and goal keep the way of the usual motion.

The quickest path jumps where two ways take nearly the same time: from one shown way to another, or
between a demonstration and the short cut. A route that leaves the usual one by more than its ends
were moved is therefore replaced by the usual one, carried to the new ends.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.models.marching.experience import Experience
from leadthrough.models.marching.mean_path import MOST_DEVIATION, with_ends
from leadthrough.models.marching.query import Query
from leadthrough.models.marching.route import Route
from leadthrough.models.marching.scales import Scales
from leadthrough.preprocess.curve_distance import frechet_distance
from leadthrough.preprocess.resample import by_arc_length

# A query whose ends are nearer to a demonstration's than this fraction of its distance from the
# usual ends asks for that demonstration.
_ASKED_FOR = 0.5
_SAMPLES = 200


def kept(
    found: Route, usual: Route, known: Sequence[Experience], query: Query, scales: Scales
) -> Route:
    """The route found or, where it deviates too far from the nominal one, the latter carried."""
    moved = float(np.linalg.norm(query.ends - usual.path[[0, -1]], axis=1).max())
    bound = MOST_DEVIATION * moved + scales.radius
    if found.method != usual.method or _apart(found.path, usual.path) <= bound:
        return found
    way = with_ends(usual.path, query.start, query.goal)
    if scales.workspace is not None:
        way = np.clip(way, *scales.workspace)
    if _blocked(way, query, scales) or _asks_for_one(known, query, moved, scales):
        return replace(found, leaves_usual_way=True)
    return replace(usual, path=way)


def _apart(one: Float64Array, other: Float64Array) -> float:
    return frechet_distance(by_arc_length(one, _SAMPLES), by_arc_length(other, _SAMPLES))


def _blocked(way: Float64Array, query: Query, scales: Scales) -> bool:
    """Whether an obstacle would slow the wave down on a way (n, d)."""
    points = np.zeros((len(way), 3))
    points[:, : way.shape[1]] = way
    return any((each.distance(points) < scales.clearance).any() for each in query.obstacles)


def _asks_for_one(known: Sequence[Experience], query: Query, moved: float, scales: Scales) -> bool:
    """Whether start and goal are clearly a demonstration's, and not the usual ones."""
    faced = [each.facing(query.start, query.goal).path[[0, -1]] for each in known]
    gaps = [np.linalg.norm(ends - query.ends, axis=1).max() for ends in faced]
    return moved > scales.radius and min(gaps) <= _ASKED_FOR * moved

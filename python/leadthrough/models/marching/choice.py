"""Which of the three ways to plan a query is for."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from leadthrough.models.marching import trust
from leadthrough.models.marching.along_mean import along_mean
from leadthrough.models.marching.experience import Experience
from leadthrough.models.marching.facing import faced
from leadthrough.models.marching.keeping import kept
from leadthrough.models.marching.query import Query
from leadthrough.models.marching.route import Route, from_start, through_map
from leadthrough.models.marching.scales import MAP_RADIUS, TUBE_RADIUS, Scales
from leadthrough.models.marching.useful import NO_DETOUR, shows_nothing, useful


def planned(
    method: str,
    known: Sequence[Experience],
    query: Query,
    scales: Callable[[float], Scales],
    *,
    usual: Callable[[], Route] | None = None,
) -> Route:
    """The route that a method finds for a query."""
    found = _planned_anew(method, known, query, scales)
    # A mean path of all demonstrations is no farther from the usual one than its ends are moved.
    one_way = found.method == "mean_path" and len(found.used) == len(known)
    if usual is None or (one_way and not query.obstacles):
        return found
    return kept(found, usual(), known, query, scales(MAP_RADIUS))


def _planned_anew(
    method: str, known: Sequence[Experience], query: Query, scales: Callable[[float], Scales]
) -> Route:
    if not known or method == "map":
        return through_map(known, query, scales(MAP_RADIUS))
    facing = faced(known, query)
    # A prediction would lead a reach away from its start and back again.
    stands_still = bool((query.start == query.goal).all())
    trusted = not shows_nothing(known) and trust.is_trusted(
        [each.way for each in facing], query.start, query.goal
    )
    if (method == "auto" or stands_still) and not trusted:
        return _through_useful(known, query, scales(MAP_RADIUS))
    if method == "start":
        return from_start(known, query, scales(TUBE_RADIUS))
    return along_mean(facing, query, scales(TUBE_RADIUS))


def _through_useful(known: Sequence[Experience], query: Query, scales: Scales) -> Route:
    """The route in the map of useful demonstrations; wandering ones may not make it longer."""
    found = useful(known, query)
    plain = through_map(known, query, scales, useful=_chosen(known, found.certain))
    if not found.passing.any():
        return plain
    route = through_map(known, query, scales, useful=_chosen(known, found.certain | found.passing))
    return route if route.length <= NO_DETOUR * plain.length else plain


def _chosen(known: Sequence[Experience], wanted: NDArray[np.bool_]) -> list[Experience]:
    return [each for each, is_wanted in zip(known, wanted, strict=True) if is_wanted]

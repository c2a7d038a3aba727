"""Which of the three ways to plan a query is for."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array
from leadthrough.models.marching.experience import Experience
from leadthrough.models.marching.maps import MAP_RADIUS, TUBE_RADIUS, Scales
from leadthrough.models.marching.mean_path import MOST_DEVIATION, along_mean, ways, with_ends
from leadthrough.models.marching.route import Query, Route, from_start, through_map
from leadthrough.preprocess.curve_distance import frechet_distance
from leadthrough.preprocess.resample import arc_length, by_arc_length


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
    trusted = not shows_nothing(known) and is_trusted(
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


# A mean path is trusted where a demonstration's ends are nearer to start and goal than this
# fraction of the distance between these, or, for motions that return, of its own length. Farther
# off the demonstrations say little about the way, and bending them to it gives detours.
_NEAR_OF_DISTANCE = 0.5
_NEAR_OF_LENGTH = 0.1
_NEAR_OF_EXTENT = 0.5
# One of several that resembles none of the others has to come nearer, by this fraction, if it
# returns. If it is so many times as long as its extent, it strays, and has to begin and end there.
_VERY_NEAR = 0.3
_STRAYING = 3.0
_AT_ITS_ENDS = 0.03  # of its extent
# Demonstrations resemble each other where the root mean square distance between them, their ends
# laid on each other, is below this fraction of the length, or of three extents, of either; and, if
# one of them is curved, below this fraction of the distance of either from its own chord.
_COMPANY, _USUAL = 0.05, 3.0
_ALIKE = 0.5
STRAIGHT = 0.5  # least chord, over the length, of a demonstration that is not curved
_SAMPLES = 100


def is_trusted(paths: Sequence[Float64Array], start: Float64Array, goal: Float64Array) -> bool:
    """Whether a demonstration's ends lie near enough to start and goal to predict the way."""
    near, nearly = _nearness(paths, start, goal)
    return bool(near.any() or (nearly.any() and (nearly & in_company(paths)).any()))


def trusted(
    paths: Sequence[Float64Array], start: Float64Array, goal: Float64Array
) -> NDArray[np.bool_]:
    """Which demonstrations' ends lie near enough to start and goal, (k,), as by `is_trusted`."""
    near, nearly = _nearness(paths, start, goal)
    return near | (nearly & in_company(paths))


def in_company(paths: Sequence[Float64Array]) -> NDArray[np.bool_]:
    """Which demonstrations (k,) go the way of another, so that it is no accident, or are alone."""
    if len(paths) == 1:
        return np.ones(1, dtype=bool)
    curves = np.stack([by_arc_length(path, _SAMPLES) for path in paths])
    lengths = np.array([arc_length(curve)[-1] for curve in curves])
    extents = np.linalg.norm(np.ptp(curves, axis=1), axis=1)
    u = np.linspace(0.0, 1.0, _SAMPLES)[:, None]
    bent = curves - (1.0 - u) * curves[:, :1] - u * curves[:, -1:]
    apart = _rms(bent[:, None] - bent[None])
    chords = np.linalg.norm(curves[:, -1] - curves[:, 0], axis=1)
    straight = chords >= STRAIGHT * lengths
    alike = apart < _COMPANY * _of_either(np.minimum(lengths, _USUAL * extents))
    alike &= (straight[:, None] & straight[None]) | (apart < _ALIKE * _of_either(_rms(bent)))
    np.fill_diagonal(alike, val=False)
    return np.asarray(alike.any(axis=1))


def _rms(offsets: Float64Array) -> Float64Array:
    """Root mean squares (...) of the lengths of offsets (..., n, d)."""
    return np.asarray(np.sqrt((offsets**2).sum(axis=-1).mean(axis=-1)))


def _of_either(sizes: Float64Array) -> Float64Array:
    """The smaller one (k, k) of two of the sizes (k,)."""
    return np.minimum(sizes[:, None], sizes[None])


def _nearness(
    paths: Sequence[Float64Array], start: Float64Array, goal: Float64Array
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Which paths' ends are near to start and goal, and which are if the path is no accident."""
    distance = float(np.linalg.norm(goal - start))
    ends = np.stack([start, goal])
    gaps = np.array([np.linalg.norm(path[[0, -1]] - ends, axis=1).max() for path in paths])
    lengths = np.array([arc_length(path)[-1] for path in paths])
    extents = np.array([np.linalg.norm(np.ptp(path, axis=0)) for path in paths])
    close = np.minimum(_NEAR_OF_LENGTH * lengths, _NEAR_OF_EXTENT * extents)
    closer = np.maximum(_NEAR_OF_DISTANCE * distance, _VERY_NEAR * close)
    straying = (lengths > _STRAYING * extents) & (len(paths) > 1)
    near = gaps <= np.where(straying, _AT_ITS_ENDS * extents, closer)
    return near, gaps <= np.maximum(_NEAR_OF_DISTANCE * distance, close)


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
    near = trusted(ways, query.start, query.goal)
    alike = in_company(ways)
    if shows_nothing(known):
        near, alike = np.zeros_like(near), np.zeros_like(alike)
    least = np.where(alike, 0.0, STRAIGHT)
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


# Ends shown in one direction are nearer to their mean by this factor than reversed.
_ONE_WAY = 0.5


def faced(known: Sequence[Experience], query: Query) -> list[Experience]:
    """The demonstrations, facing the way from start to goal as a whole."""
    turned = [each.facing(query.start, query.goal) for each in known]
    if all(one is other for one, other in zip(turned, known, strict=True)):
        return turned
    starts, goals = (np.stack([each.path[index] for each in known]) for index in (0, -1))
    usual = starts.mean(axis=0), goals.mean(axis=0)
    if not _shown_one_way(starts, goals, *usual):
        return turned
    moved = max(
        float(np.linalg.norm(asked - shown)) for asked, shown in zip(query.ends, usual, strict=True)
    )
    change = _way(turned, query.start, query.goal) - _way(known, *usual)
    within = np.linalg.norm(change, axis=1).max() <= MOST_DEVIATION * moved
    return turned if within else list(known)


def _shown_one_way(
    starts: Float64Array, goals: Float64Array, start: Float64Array, goal: Float64Array
) -> bool:
    """Whether no demonstration is as near to the mean ends when it is reversed."""
    ahead, back = (
        np.linalg.norm(first - start, axis=1) + np.linalg.norm(last - goal, axis=1)
        for first, last in ((starts, goals), (goals, starts))
    )
    return bool((ahead <= _ONE_WAY * back).all())


def _way(shown: Sequence[Experience], start: Float64Array, goal: Float64Array) -> Float64Array:
    return next(ways(shown, start, goal)).path


# A query whose ends are nearer to a demonstration's than this fraction of its distance from the
# usual ends asks for that demonstration.
_ASKED_FOR = 0.5
_FRECHET_SAMPLES = 200


def kept(
    found: Route, usual: Route, known: Sequence[Experience], query: Query, scales: Scales
) -> Route:
    """The route found or, if it leaves the nominal route too far, the nominal one carried."""
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
    return frechet_distance(
        by_arc_length(one, _FRECHET_SAMPLES), by_arc_length(other, _FRECHET_SAMPLES)
    )


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

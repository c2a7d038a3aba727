"""Plans the route of a query: its method, its demonstrations, and its distance to the nominal one.

A demonstration predicts the path if its ends lie near start and goal; one whose ends do so only
nearly has to resemble another one. Otherwise the map holds the demonstrations relevant to the
query: those that lead towards the goal about as fast past start and goal as on the whole. A route
that leaves the nominal one by more than its ends were moved is replaced by that, adapted to them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array
from leadthrough.models.marching.experience import Experience
from leadthrough.models.marching.mean_path import along_mean, branches
from leadthrough.models.marching.route import Query, Route, from_start, through_map
from leadthrough.planning.maps import MAP_RADIUS, TUBE_RADIUS, Scales, min_distance
from leadthrough.preprocess import arc_length, by_arc_length, frechet_distance
from leadthrough.preprocess.moved_ends import MAX_GAIN, with_ends

# A mean path is predicted where a demonstration's ends are nearer to start and goal than this
# fraction of the distance between these, or, for motions that return, of its own length. Farther
# off the demonstrations say little about the path, and adapting them to it gives detours.
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
_RESEMBLANCE, _EXTENTS = 0.05, 3.0
_ALIKE = 0.5
_STRAIGHT = 0.5  # least chord, over the length, of a demonstration that is not curved
_SAMPLES = 100
# A detour up to this ratio to the straight line does no harm.
_MAX_DETOUR = 1.1
# Progress towards the goal per length of path, as a fraction of the demonstration's own.
_AS_FAST = 0.5
# Ends demonstrated in one direction are nearer to their mean by this factor than reversed.
_ONE_DIRECTION = 0.5
# A query whose ends are nearer to a demonstration's than this fraction of its distance from the
# nominal ends asks for that demonstration.
_ASKED_FOR = 0.5
_FRECHET_SAMPLES = 200


def planned(
    method: str,
    known: Sequence[Experience],
    query: Query,
    scales: Callable[[float], Scales],
    *,
    nominal: Callable[[], Route] | None = None,
) -> Route:
    """The route that a method plans for a query."""
    route = _planned_anew(method, known, query, scales)
    # A mean path of all demonstrations is no farther from the nominal one than its ends are moved.
    bounded = route.method == "mean_path" and len(route.used) == len(known)
    if nominal is None or (bounded and not query.obstacles):
        return route
    return _near_nominal(route, nominal(), known, query, scales(MAP_RADIUS))


def directed(known: Sequence[Experience], query: Query) -> list[Experience]:
    """The demonstrations in the direction in which each is traversed for a query."""
    towards = [each.towards(query.start, query.goal) for each in known]
    if all(one is other for one, other in zip(towards, known, strict=True)):
        return towards
    starts, goals = (np.stack([each.path[index] for each in known]) for index in (0, -1))
    nominal = starts.mean(axis=0), goals.mean(axis=0)
    if not _in_one_direction(starts, goals, *nominal):
        return towards
    moved = max(
        float(np.linalg.norm(asked - own)) for asked, own in zip(query.ends, nominal, strict=True)
    )
    change = _mean(towards, query.start, query.goal) - _mean(known, *nominal)
    # A small move of the ends must not turn a motion around that ends beside its start.
    within = np.linalg.norm(change, axis=1).max() <= MAX_GAIN * moved
    return towards if within else list(known)


def resemble_another(paths: Sequence[Float64Array]) -> NDArray[np.bool_]:
    """Whether each demonstration (k,) resembles another one, or is the only one."""
    if len(paths) == 1:
        return np.ones(1, dtype=bool)
    curves = np.stack([by_arc_length(path, _SAMPLES) for path in paths])
    lengths = np.array([arc_length(curve)[-1] for curve in curves])
    extents = np.linalg.norm(np.ptp(curves, axis=1), axis=1)
    u = np.linspace(0.0, 1.0, _SAMPLES)[:, None]
    bent = curves - (1.0 - u) * curves[:, :1] - u * curves[:, -1:]
    apart = _rms(bent[:, None] - bent[None])
    chords = np.linalg.norm(curves[:, -1] - curves[:, 0], axis=1)
    straight = chords >= _STRAIGHT * lengths
    alike = apart < _RESEMBLANCE * _of_either(np.minimum(lengths, _EXTENTS * extents))
    alike &= (straight[:, None] & straight[None]) | (apart < _ALIKE * _of_either(_rms(bent)))
    np.fill_diagonal(alike, val=False)
    return np.asarray(alike.any(axis=1))


def _planned_anew(
    method: str, known: Sequence[Experience], query: Query, scales: Callable[[float], Scales]
) -> Route:
    """The route of a method, regardless of the nominal one."""
    if not known or method == "map":
        return through_map(known, query, scales(MAP_RADIUS))
    demonstrations = directed(known, query)
    # A prediction would lead a reach away from its start and back again.
    stands_still = bool((query.start == query.goal).all())
    predicted = (
        not _is_random_walk(known)
        and _predicts([each.denoised for each in demonstrations], query).any()
    )
    if (method == "auto" or stands_still) and not predicted:
        return _through_relevant(known, query, scales(MAP_RADIUS))
    if method == "start":
        return from_start(known, query, scales(TUBE_RADIUS))
    return along_mean(demonstrations, query, scales(TUBE_RADIUS))


def _through_relevant(known: Sequence[Experience], query: Query, scales: Scales) -> Route:
    """The route in the map of relevant demonstrations; wandering ones may not make it longer."""
    certain, passing = _relevant_to(known, query)
    plain = through_map(known, query, scales, mapped=_chosen(known, certain))
    if not passing.any():
        return plain
    both = _chosen(known, certain | passing)
    route = through_map(known, query, scales, mapped=both)
    return route if route.length <= _MAX_DETOUR * plain.length else plain


def _chosen(known: Sequence[Experience], wanted: NDArray[np.bool_]) -> list[Experience]:
    return [each for each, is_wanted in zip(known, wanted, strict=True) if is_wanted]


def _is_random_walk(known: Sequence[Experience]) -> bool:
    """Whether there is a single demonstration and it is a random walk, which shows no path."""
    return len(known) == 1 and known[0].is_random_walk


def _predicts(paths: Sequence[Float64Array], query: Query) -> NDArray[np.bool_]:
    """Whether each demonstration's ends (k,) lie near enough to start and goal to predict."""
    distance = float(np.linalg.norm(query.goal - query.start))
    gaps = np.array([np.linalg.norm(path[[0, -1]] - query.ends, axis=1).max() for path in paths])
    lengths = np.array([arc_length(path)[-1] for path in paths])
    extents = np.array([np.linalg.norm(np.ptp(path, axis=0)) for path in paths])
    close = np.minimum(_NEAR_OF_LENGTH * lengths, _NEAR_OF_EXTENT * extents)
    closer = np.maximum(_NEAR_OF_DISTANCE * distance, _VERY_NEAR * close)
    straying = (lengths > _STRAYING * extents) & (len(paths) > 1)
    near = gaps <= np.where(straying, _AT_ITS_ENDS * extents, closer)
    nearly = (gaps <= np.maximum(_NEAR_OF_DISTANCE * distance, close)) & ~near
    return near | (nearly & resemble_another(paths)) if nearly.any() else near


def _rms(offsets: Float64Array) -> Float64Array:
    """Root mean squares (...) of the lengths of offsets (..., n, d)."""
    return np.asarray(np.sqrt((offsets**2).sum(axis=-1).mean(axis=-1)))


def _of_either(sizes: Float64Array) -> Float64Array:
    """The smaller one (k, k) of two of the sizes (k,)."""
    return np.minimum(sizes[:, None], sizes[None])


def _relevant_to(
    known: Sequence[Experience], query: Query
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Demonstrations (k,) that lead from start to goal, and wandering ones that pass by both."""
    demonstrations = [each.towards(query.start, query.goal) for each in known]
    paths = [each.denoised for each in demonstrations]
    near, alike = _predicts(paths, query), resemble_another(paths)
    if _is_random_walk(known):
        near, alike = np.zeros_like(near), np.zeros_like(alike)
    least = np.where(alike, 0.0, _STRAIGHT)
    leading = [_leads(*each, query) for each in zip(demonstrations, least, strict=True)]
    certain = near | np.array(leading)
    passing = np.array([_passes_by(each, query) for each in demonstrations])
    return certain | (passing & alike), passing & ~certain & ~alike


def _leads(one: Experience, straight: float, query: Query) -> bool:
    """Whether a stretch of a demonstration, at least so straight, leads from start to goal."""
    first, last, _, stretch = _stretch(one.denoised, query)
    own = float(np.linalg.norm(one.denoised[-1] - one.denoised[0])) / one.length
    return own >= straight and _progress(first, last, query) >= _AS_FAST * own * stretch > 0.0


def _passes_by(one: Experience, query: Query) -> bool:
    """Whether the path along the demonstration's stretch is nearly as short as the straight one."""
    distance = float(np.linalg.norm(query.goal - query.start))
    _, _, gap, stretch = _stretch(one.denoised, query)
    return gap + stretch <= _MAX_DETOUR * distance


def _stretch(path: Float64Array, query: Query) -> tuple[Float64Array, Float64Array, float, float]:
    """The points nearest to start and goal, the sum of their gaps, the length between them."""
    gaps = [np.linalg.norm(path - end, axis=1) for end in query.ends]
    nearest = [int(np.argmin(gap)) for gap in gaps]
    covered = arc_length(path)
    apart = abs(float(covered[nearest[1]] - covered[nearest[0]]))
    return path[nearest[0]], path[nearest[1]], float(gaps[0].min() + gaps[1].min()), apart


def _progress(first: Float64Array, last: Float64Array, query: Query) -> float:
    """Mean decrease of the distance to the goal and increase of that to the start."""
    to_goal, from_start = (
        np.linalg.norm(np.stack([first, last]) - end, axis=1) for end in (query.goal, query.start)
    )
    return float(0.5 * (to_goal[0] - to_goal[1] + from_start[1] - from_start[0]))


def _in_one_direction(
    starts: Float64Array, goals: Float64Array, start: Float64Array, goal: Float64Array
) -> bool:
    """Whether no demonstration is as near to the mean ends when it is reversed."""
    ahead, back = (
        np.linalg.norm(first - start, axis=1) + np.linalg.norm(last - goal, axis=1)
        for first, last in ((starts, goals), (goals, starts))
    )
    return bool((ahead <= _ONE_DIRECTION * back).all())


def _mean(known: Sequence[Experience], start: Float64Array, goal: Float64Array) -> Float64Array:
    return next(branches(known, start, goal)).path


def _near_nominal(
    route: Route, nominal: Route, known: Sequence[Experience], query: Query, scales: Scales
) -> Route:
    """The route or, if it leaves the nominal route too far, the nominal one adapted."""
    moved = float(np.linalg.norm(query.ends - nominal.path[[0, -1]], axis=1).max())
    bound = MAX_GAIN * moved + scales.radius
    curves = [by_arc_length(each.path, _FRECHET_SAMPLES) for each in (route, nominal)]
    if route.method != nominal.method or frechet_distance(*curves) <= bound:
        return route
    path = with_ends(nominal.path, query.start, query.goal)
    if scales.workspace is not None:
        path = np.clip(path, *scales.workspace)
    blocked = min_distance(path, query.obstacles) < scales.clearance
    if blocked or _asks_for_one(known, query, moved, scales):
        return replace(route, leaves_nominal_route=True)
    return replace(nominal, path=path)


def _asks_for_one(known: Sequence[Experience], query: Query, moved: float, scales: Scales) -> bool:
    """Whether start and goal are clearly a demonstration's, and not the nominal ones."""
    ends = [each.towards(query.start, query.goal).path[[0, -1]] for each in known]
    gaps = [np.linalg.norm(each - query.ends, axis=1).max() for each in ends]
    return moved > scales.radius and min(gaps) <= _ASKED_FOR * moved

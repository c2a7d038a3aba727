"""Plans the route of a query: its method, its demonstrations, and its distance to the nominal one.

A demonstration predicts the path if its ends lie near start and goal; one whose ends do so only
nearly has to resemble another one. Otherwise the map holds the demonstrations relevant to the
query: those that lead towards the goal about as fast past start and goal as on the whole. A route
that leaves the nominal one by more than its ends were moved is replaced by that, adapted to them.

A predicted path is the mean of demonstrations adapted to the new ends by shifting and rotating, of
the branch whose start is nearest, over the arc length. Around obstacles the wave plans in a tube as
wide as the detour may become; if they block a branch, another demonstrated one is preferred.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

import leadthrough._core as core
from leadthrough.check import Float64Array, NoPath
from leadthrough.models.curves import modes_of
from leadthrough.models.marching.experience import Experience
from leadthrough.models.marching.route import Query, Route, from_start, route_along, through_map
from leadthrough.planning import maps
from leadthrough.planning.detours import detoured
from leadthrough.planning.maps import Scales
from leadthrough.preprocess import arc_length, by_arc_length, frechet_distance
from leadthrough.preprocess.moved_ends import MAX_GAIN, Chords, bounded, with_ends

_SAMPLES = 1000
# Demonstrations farther apart than this fraction of their length are different branches.
_SAME_BRANCH = 0.1
# A path leaves the demonstrations by at most the move of its ends; below 1 to allow for rounding.
_ROOM = 0.999
# Details of a predicted path that are shorter than this many radii are tremor, not shape.
_KNOTS = 1.6


def along_mean(demonstrations: Sequence[Experience], query: Query, scales: Scales) -> Route:
    """The demonstrations' mean path, with the quickest detours around obstacles."""
    blocked = []
    for mean in branches(demonstrations, query.start, query.goal):
        if maps.min_distance(mean.path, query.obstacles) > 0.0:
            return _through(mean, demonstrations, query, scales)
        blocked.append(mean)
    routes, failures = [], []
    for mean in blocked:
        try:
            routes.append(_through(mean, demonstrations, query, scales))
        except NoPath as error:
            failures.append(error)
    if not routes:
        raise failures[0]
    return min(routes, key=lambda route: route.travel_time)


@dataclass(frozen=True, eq=False)
class MeanPath:
    path: Float64Array  # (n, d), the mean of demonstrations that are evenly spaced in arc length
    weights: Float64Array  # (k,) of the demonstrations; 0 for those of other branches
    region: tuple[Float64Array, Float64Array]


def branches(
    demonstrated: Sequence[Experience], start: Float64Array, goal: Float64Array
) -> Iterator[MeanPath]:
    """The mean paths of the demonstrated branches, that of the nearest start first."""
    curves = _curves_of(tuple(demonstrated))
    shifted = with_ends(curves.points, start, goal)
    adapted = curves.adapted(shifted, start, goal)
    moved = float(np.linalg.norm(np.stack([start, goal]) - curves.nominal_ends, axis=1).max())
    region = curves.region(start, goal, _ROOM * moved)
    for chosen in curves.branches_near(start):
        weights = curves.weights(start, chosen)
        path = np.einsum("j,jnd->nd", weights, adapted)
        if moved > 0.0:
            path = bounded(path, curves.nominal_mean(chosen))
            path = np.clip(path, *region)
        yield MeanPath(path, weights, region)


class _Curves:
    """Demonstrations, evenly spaced in arc length, with what is the same for every query."""

    def __init__(self, demonstrated: Sequence[Experience]) -> None:
        from scipy.sparse.csgraph import connected_components

        self.points = np.stack([by_arc_length(each.denoised, _SAMPLES) for each in demonstrated])
        self.starts = self.points[:, 0]
        self.nominal_ends = self.points[:, [0, -1]].mean(axis=0)
        # Laid on each other's ends, wherever these are.
        apart = core.rms_apart(with_ends(self.points, *self.nominal_ends))
        alike = apart < _SAME_BRANCH * np.mean([each.length for each in demonstrated])
        modes = modes_of(self.points)
        # The number of the group of each, connected by small steps, and of its part of one mode.
        _, self._group = connected_components(alike)
        _, self._branch = connected_components(alike & (modes[:, None] == modes))
        self._corners = self.points.min(axis=(0, 1)), self.points.max(axis=(0, 1))
        self._chords = Chords(self.points)
        self._nominal_means: dict[bytes, Float64Array] = {}

    def adapted(
        self, shifted: Float64Array, start: Float64Array, goal: Float64Array
    ) -> Float64Array:
        """The demonstrations (k, n, d), part shifted and part rotated to a new start and goal."""
        (adapted,) = self._chords.adapted(np.stack([start, goal])[None], shifted)
        return np.asarray(adapted)

    def region(
        self, start: Float64Array, goal: Float64Array, room: float
    ) -> tuple[Float64Array, Float64Array]:
        """Corners around the demonstrations, with room, and around start and goal."""
        ends = np.stack([start, goal])
        lower, upper = self._corners
        return np.minimum(lower - room, ends.min(axis=0)), np.maximum(
            upper + room, ends.max(axis=0)
        )

    def nominal_mean(self, chosen: NDArray[np.bool_]) -> Float64Array:
        """The mean (n, d) of those chosen (k,) between the nominal ends."""
        key = chosen.tobytes()
        if key not in self._nominal_means:
            start, goal = self.nominal_ends
            adapted = self.adapted(with_ends(self.points, start, goal), start, goal)
            weights = self.weights(start, chosen)
            mean = np.asarray(np.einsum("j,jnd->nd", weights, adapted))
            mean.setflags(write=False)
            self._nominal_means[key] = mean
        return self._nominal_means[key]

    def branches_near(self, start: Float64Array) -> Iterator[NDArray[np.bool_]]:
        """The demonstrations (k,) of each branch, that with the nearest start first."""
        nearest = np.argsort(np.linalg.norm(self.starts - start, axis=1), kind="stable")
        for branch in dict.fromkeys(self._branch[nearest].tolist()):
            yield self._branch == branch

    def weights(self, start: Float64Array, chosen: NDArray[np.bool_]) -> Float64Array:
        """Gaussian weights (k,) of those chosen in the distance of the starts; sum 1."""
        squared = ((self.starts - start) ** 2).sum(axis=1)
        # As wide as starts are spread, but for those of the other modes of its group.
        counted = self.starts[chosen | (self._group != self._group[chosen][0])]
        spread = float(counted.var(axis=0, ddof=1).sum()) if len(counted) > 1 else 0.0
        nearer = np.zeros(len(squared))
        if spread > 0.0:
            nearer = -(squared - squared[chosen].min()) / (2.0 * spread)
        weights = np.where(chosen, np.exp(np.where(chosen, nearer, 0.0)), 0.0)
        return np.asarray(weights / weights.sum())


# The demonstrations of a skill in one direction or the other, for the skills in use at a time.
_curves_of = lru_cache(maxsize=16)(_Curves)


def _through(
    mean: MeanPath, demonstrations: Sequence[Experience], query: Query, scales: Scales
) -> Route:
    """The route along one mean path, around obstacles."""
    nominal = mean.path
    if scales.workspace is not None:
        nominal = np.clip(
            nominal, *scales.workspace
        )  # start and goal decide whether that is an error
        nominal[[0, -1]] = query.ends
    knot_spacing = _KNOTS * scales.radius
    grid, scales = maps.grid_over([nominal], query.obstacles, scales)
    path = detoured(nominal, grid, query.obstacles, scales)
    if path is not nominal:
        knot_spacing = maps.CELLS_PER_KNOT * float(grid.spacing.max())
    chosen = mean.weights > 0.0
    used = tuple(each for each, wanted in zip(demonstrations, chosen, strict=True) if wanted)
    weights = np.ones(len(used))  # whose start is nearest says nothing about the pace
    return route_along(
        path,
        maps.tube_field(nominal, grid, query.obstacles, scales),
        knot_spacing=knot_spacing,
        used=used,
        weights=weights,
        method="mean_path",
        region=mean.region if path is nominal else None,  # a detour needs its room
    )


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
_COMPARED = 100
# A detour up to this ratio to the straight line does no harm.
_MAX_DETOUR = 1.1
# Progress towards the goal per length of path, as a fraction of the demonstration's own.
_AS_FAST = 0.5
# Ends demonstrated in one direction are nearer to their mean by this factor than reversed.
_ONE_DIRECTION = 0.5
# A query whose ends are nearer to a demonstration's than this fraction of its distance from the
# nominal ends asks for that demonstration.
_ASKED_FOR = 0.5
# A query whose ends are nearer by this factor to demonstrations of another way than to those of the
# nominal route asks for that way.
_NEARER = 0.4
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
    return _near_nominal(route, nominal(), known, query, scales(maps.MAP_RADIUS))


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
    curves = np.stack([by_arc_length(path, _COMPARED) for path in paths])
    lengths = np.array([arc_length(curve)[-1] for curve in curves])
    extents = np.linalg.norm(np.ptp(curves, axis=1), axis=1)
    u = np.linspace(0.0, 1.0, _COMPARED)[:, None]
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
        return through_map(known, query, scales(maps.MAP_RADIUS))
    demonstrations = directed(known, query)
    # A prediction would lead a reach away from its start and back again.
    stands_still = bool((query.start == query.goal).all())
    predicted = (
        not _is_random_walk(known)
        and _predicts([each.denoised for each in demonstrations], query).any()
    )
    if (method == "auto" or stands_still) and not predicted:
        return _through_relevant(known, query, scales(maps.MAP_RADIUS))
    if method == "start":
        return from_start(known, query, scales(maps.TUBE_RADIUS))
    return along_mean(demonstrations, query, scales(maps.TUBE_RADIUS))


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
    blocked = maps.min_distance(path, query.obstacles) < scales.clearance
    asked_for = moved > scales.radius and _gap(known, query) <= _ASKED_FOR * moved
    asked_for = asked_for or _gap(route.used, query) < _NEARER * _gap(nominal.used, query)
    if blocked or asked_for:
        return replace(route, leaves_nominal_route=True)
    return replace(nominal, path=path)


def _gap(some: Sequence[Experience], query: Query) -> float:
    """How far start and goal are from those of the nearest of some demonstrations."""
    ends = [each.towards(query.start, query.goal).path[[0, -1]] for each in some]
    return min((float(np.linalg.norm(e - query.ends, axis=1).max()) for e in ends), default=np.inf)

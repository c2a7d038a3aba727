"""Smooth sections of a path between the places where the motion rests."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

import leadthrough._core as core
from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.motion import JointTrajectory
from leadthrough.timing.request import POSITION_ROUNDING, Request
from leadthrough.trajectories import Curve, Spline
from leadthrough.trajectories.minimum_jerk import QUINTIC

Rows = NDArray[np.intp]


_SAME_PLACE = 1e-12  # rad or m
# Samples that stay within this, rad (m), for so many s are a pause: shorter ones are also steps of
# an encoder between which an arm moves on.
_STILL, _PAUSE = 5e-6, 0.1
_LONGER = 10.0  # times the usual time between samples that are farther apart
# Rows beyond each end of a part, by which a cubic between rows is the same as with all of them.
_BESIDE = 3


@dataclass(frozen=True, eq=False)
class Section:
    """A path with two continuous derivatives, from rest to rest."""

    spline: Spline  # the path
    rows: Rows  # way-points, samples or knots (m,) of the whole path, by their index
    parameters: Float64Array  # where they lie on the spline, (m,)
    dwell_time: float = 0.0  # s, how long the motion rests at the end

    def cut_at(self, parameters: Float64Array) -> list[Section]:
        """The section in parts, without its rest; rows near a part's ends stay, beyond them too."""
        parts, begin = list[Section](), self.spline.coefficients[0, 0]
        for part in _parts(self.spline, parameters):
            # From 0, as a short part's own parameters would be lost in the digits of the whole,
            # and from where the part before ends to the last digit.
            table = part.coefficients.copy()
            table[0, 0] = begin
            spline = Spline(part.knots - part.knots[0], table)
            first, last = np.searchsorted(self.parameters, part.knots[[0, -1]])
            near = slice(max(first - _BESIDE, 0), last + _BESIDE)
            own = self.parameters[near] - part.knots[0]
            rows = self.rows[near]
            parts.append(replace(self, spline=spline, rows=rows, parameters=own, dwell_time=0.0))
            begin = spline.evaluate(spline.domain[1])
        return parts


@dataclass(frozen=True, eq=False)
class Lines:
    """Straight lines, at whose ends the motion rests."""

    ends: Float64Array  # of the lines, (m + 1, joints)
    at: Float64Array  # lengths (m + 1,) of the path at the ends
    rows: Rows  # way-points (n,) on the lines, by their index in the whole path
    lengths: Float64Array  # of the path at these way-points, (n,)
    dwell_times: Float64Array  # s, how long the motion rests after each line, (m,)


@dataclass(frozen=True, eq=False)
class Sections:
    """A whole path in sections; none where nothing moves."""

    initial_dwell: float  # s, how long the motion rests at its start
    parts: list[Section | Lines]  # the sections, in their order, and lines


def between(
    stops: Collection[int],
    section: Callable[[int, int], Section | None],
    *,
    dwell_times: Mapping[int, float],
) -> Sections:
    """The sections from each stop to the next."""
    initial_dwell, parts = dwell_times.get(0, 0.0), list[Section]()
    for first, last in pairwise(sorted(stops)):
        part, dwell = section(first, last), dwell_times.get(last, 0.0)
        if part is not None:
            parts.append(replace(part, dwell_time=dwell))
        elif parts:
            parts[-1] = replace(parts[-1], dwell_time=parts[-1].dwell_time + dwell)
        else:
            initial_dwell += dwell
    return Sections(initial_dwell, list[Section | Lines](parts))


def _parts(spline: Spline, parameters: Float64Array) -> list[Spline]:
    """The spline between its start, each of the parameters and its end; each part moves."""
    start, end = spline.domain
    inner = parameters[(parameters > start) & (parameters < end)]
    q = spline.evaluate(np.array([start, *inner, end]))
    moved = np.abs(np.diff(q, axis=0)).max(axis=1) > _SAME_PLACE
    inner = inner[moved[:-1] & moved[1:]]
    return [_between(spline, *ends) for ends in pairwise([start, *inner.tolist(), end])]


def _between(spline: Spline, first: float, last: float) -> Spline:
    begin = int(np.searchsorted(spline.knots, first, side="right")) - 1
    end = int(np.searchsorted(spline.knots, last, side="left"))
    knots, pieces = spline.knots[begin : end + 1].copy(), spline.coefficients[begin:end].copy()
    pieces[0] = _moved(pieces[0], first - knots[0])
    knots[[0, -1]] = first, last
    return Spline(knots, pieces)


def _moved(piece: Float64Array, by: float) -> Float64Array:
    """Coefficients (terms, d) of a polynomial that begins later by so much."""
    powers = range(len(piece))
    table = [[math.comb(k, i) * by ** (k - i) if k >= i else 0.0 for k in powers] for i in powers]
    return np.array(table) @ piece


# Spans of a spline that is bounded by its control points: the fewest and the most, doubled until
# it lies within this fraction of the tolerance from the samples; dropped ones need the rest.
_MIN_SPANS, _MAX_SPANS, _SHARE = 128, 30_000, 0.8
_FADE = 0.1  # of such a spline, over which its distance from the limits grows
# Number of samples through which curves are fitted that are not splines, or not smooth enough.
_SAMPLES_OF_A_CURVE = 2000


@dataclass(frozen=True, eq=False)
class Path:
    rows: int  # how many way-points, samples or knots it has
    start: Float64Array  # configuration (joints,) at which it begins
    sections: Callable[[Request], Sections]

    @property
    def joints(self) -> int:
        return len(self.start)


def path_of(value: JointTrajectory | Curve | ArrayLike) -> Path:
    """The path that a trajectory, a curve or way-points describe."""
    if isinstance(value, JointTrajectory):
        cut = partial(_cut_samples, value.times, value.positions)
        return Path(len(value.times), value.positions[0], cut)
    if isinstance(value, Curve):
        cut = (
            partial(_cut_spline, value) if isinstance(value, Spline) else partial(_cut_curve, value)
        )
        return Path(len(value.knots), value.evaluate(value.domain[0]), cut)
    points = check.array(value, "path", shape=("n", "joints"))
    if 0 in points.shape:
        raise InvalidInput(f"path: expected way-points (n, joints), got shape {points.shape}")
    return Path(len(points), points[0], partial(_cut_way_points, points))


def _cut_samples(times: Float64Array, q: Float64Array, request: Request) -> Sections:
    def section(first: int, last: int) -> Section | None:
        part = slice(first, last + 1)
        if np.ptp(q[part], axis=0).max() == 0.0:
            return None
        kept, parameters, spline = _fitted(times[part], q[part], request)
        return Section(spline, first + kept, parameters)

    stops = {0, *request.dwell_times, len(q) - 1}
    if request.earliest_times is not None:
        q = q.copy()
        for first, last in _pauses(times, q, min(0.5 * request.path_tolerance, _STILL)):
            q[first : last + 1] = q[first if last < len(q) - 1 else last]
            stops |= {int(first), int(last)}
    return between(stops, section, dwell_times=request.dwell_times)


def _pauses(times: Float64Array, q: Float64Array, tolerance: float) -> Rows:
    """The first and the last row of each place at which the samples stay for a while."""
    first = core.rows_apart(np.ascontiguousarray(q), tolerance)
    last = np.append(first[1:] - 1, len(q) - 1)
    stay, usual = times[last] - times[first], np.median(np.diff(times[first], append=times[-1]))
    # A slow motion stays near each of its samples, but at none of them.
    still = (q[first] == q[last]).all(axis=1) | (stay > _LONGER * usual)
    return np.asarray(np.stack([first, last], axis=1)[still & (stay >= _PAUSE)])


def _cut_curve(path: Curve, request: Request) -> Sections:
    if request.dwell_times:
        raise InvalidInput("dwell_times: a curve without way-points has none; give a Spline")
    times = np.linspace(*path.domain, _SAMPLES_OF_A_CURVE)
    q = path.evaluate(times)

    def section(_first: int, _last: int) -> Section | None:
        if np.ptp(q, axis=0).max() == 0.0:
            return None
        kept, parameters, spline = _fitted(times, q, request)
        at_knots = np.interp(path.knots, times[kept], parameters)
        # Of knots between which the curve rests, the last one counts.
        apart = np.unique(at_knots)
        return Section(spline, np.searchsorted(at_knots, apart, side="right") - 1, apart)

    return between({0, len(path.knots) - 1}, section, dwell_times={})


def _fitted(
    times: Float64Array, q: Float64Array, request: Request
) -> tuple[Rows, Float64Array, Spline]:
    """The samples kept, by their index, their parameters and a spline near all samples."""
    tolerance = request.path_tolerance
    if request.smooth and (found := _smoothed(q, request)):
        return found
    timed = request.earliest_times is not None  # each sample counts, for its time
    # Dropped samples and the fit share the tolerance.
    kept, parameters = moving_samples(times, q, 0.5 * tolerance, timed=timed)
    spline = fit_within(parameters, q[kept], 0.5 * tolerance, corners=not timed)
    beyond = request.outside(_reached(spline))
    if beyond <= POSITION_ROUNDING or request.outside(q) > tolerance:
        return kept, parameters, spline
    kept, parameters = moving_samples(times, q, 0.2 * tolerance, timed=timed)
    near = fit_within(parameters, q[kept], 0.2 * tolerance, corners=not timed)
    return kept, parameters, _bounded(near, parameters, q[kept], request)


def _bounded(near: Spline, parameters: Float64Array, q: Float64Array, request: Request) -> Spline:
    """A spline near another one, inside the limits as its control points are (Schoenberg's)."""
    from scipy.interpolate import BSpline

    spans = _MIN_SPANS
    while True:
        knots = np.pad(np.linspace(*near.domain, spans + 1), _DEGREE, mode="edge")
        averages = np.lib.stride_tricks.sliding_window_view(knots[1:-1], _DEGREE).mean(axis=1)
        ends = np.minimum(averages - knots[0], knots[-1] - averages) / knots[-1]
        fade = np.minimum(ends / _FADE, 1.0)  # the ends stay where they are
        points = request.clipped(near.evaluate(averages), fade)
        curve, breaks = BSpline(knots, points, _DEGREE), knots[_DEGREE:-_DEGREE]
        terms = [curve(breaks[:-1], k) / math.factorial(k) for k in range(_DEGREE + 1)]
        spline = Spline(breaks, np.stack(terms, axis=1))
        missed = np.abs(spline.evaluate(parameters) - q).max()
        if missed <= _SHARE * request.path_tolerance or spans > _MAX_SPANS:
            return spline
        spans *= 2


def _smoothed(q: Float64Array, request: Request) -> tuple[Rows, Float64Array, Spline] | None:
    """The smoothest spline over arc length within the tolerance; None if samples are too few."""
    dropped = request.dropped
    kept = _kept(q, dropped)
    if len(kept) <= _DEGREE + 1:
        return None
    points = np.ascontiguousarray(q[kept])
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    lengths = np.concatenate([[0.0], np.cumsum(steps)])
    tolerance = request.path_tolerance - dropped
    bounds = request.lower + request.margins, request.upper - request.margins
    breaks, table = core.smooth_spline(lengths, points, tolerance, *bounds)
    return (kept, lengths, _quintics(lengths[breaks], table)) if len(breaks) else None


def _reached(spline: Spline) -> Float64Array:
    """Samples (n, joints) of a spline, moved to where a joint turns between them."""
    q = spline.evaluate(np.linspace(*spline.domain, _SAMPLES_OF_A_CURVE))
    slope, bend = 0.5 * (q[2:] - q[:-2]), q[2:] - 2.0 * q[1:-1] + q[:-2]
    turns = (np.abs(slope) <= np.abs(bend)) & (bend != 0.0)  # within a step: a parabola's vertex
    np.subtract(q[1:-1], 0.5 * slope**2 / np.where(turns, bend, 1.0), out=q[1:-1], where=turns)
    return q


def _cut_spline(path: Spline, request: Request) -> Sections:
    smoothness = path.smoothness()
    if (smoothness < 1).any():
        i = int(np.argmax(smoothness < 1)) + 1
        raise InvalidInput(f"path: expected a continuous path, got a jump at knot {i}")
    corners = np.flatnonzero(smoothness < 2) + 1

    def section(first: int, last: int) -> Section | None:
        part = Spline(path.knots[first : last + 1], path.coefficients[first:last])
        if not part.coefficients[:, 1:].any():
            return None
        if (smoothness[first : last - 1] < 3).any():
            times = np.linspace(*part.domain, _SAMPLES_OF_A_CURVE)
            q = part.evaluate(times)
            part = fit_within(times, q, request.path_tolerance, corners=True)
        return Section(part, np.arange(first, last + 1), path.knots[first : last + 1])

    stops = {0, *corners.tolist(), *request.dwell_times, len(path.knots) - 1}
    return between(stops, section, dwell_times=request.dwell_times)


def _cut_way_points(points: Float64Array, request: Request) -> Sections:
    # A way-point that nearly repeats the one before is dropped; its rest goes to that one.
    rows = apart(points)
    new_row = np.searchsorted(rows, np.arange(len(points)), side="right") - 1
    dwell_times: dict[int, float] = {}
    for row, dwell in request.dwell_times.items():
        dwell_times[int(new_row[row])] = dwell_times.get(int(new_row[row]), 0.0) + dwell
    kept = points[rows]
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(kept, axis=0), axis=1))])
    stops = stops_of(kept, blend=request.blend, held=list(dwell_times))
    if len(kept) > 1 and request.along_lines and are_lines(kept, stops):
        held = np.array([dwell_times.get(stop, 0.0) for stop in stops])
        lines = Lines(kept[stops], lengths[stops], rows, lengths, held[1:])
        return Sections(held[0], [lines])

    def section(first: int, last: int) -> Section:
        part = slice(first, last + 1)
        return Section(
            blended_path(kept[part], request.blend), rows[part], lengths[part] - lengths[first]
        )

    return between(stops, section, dwell_times=dwell_times)


# Directions that differ by less are the same: rounding of way-points on a straight line.
_SAME_DIRECTION = 1e-9
# Way-points that are nearer to each other in all coordinates, rad (m), are one: no encoder tells
# them apart, and the direction between them is rounding.
_COINCIDENT = 1e-9
# The rest of a line between two corners is a piece if its knots differ by more than this.
_ULPS = 8.0 * np.finfo(np.float64).eps


def apart(points: Float64Array) -> NDArray[np.intp]:
    """Indices of the way-points that do not nearly coincide with the one kept before."""
    kept = core.rows_apart(np.ascontiguousarray(points), _COINCIDENT)
    last = len(points) - 1
    if (points[kept[-1]] != points[last]).any():
        return np.append(kept[: max(len(kept) - 1, 1)], last)
    return kept


def stops_of(points: Float64Array, *, blend: float, held: Sequence[int]) -> list[int]:
    """Indices of the way-points at which the motion rests: the ends, those held, and corners."""
    stops = {0, *held, len(points) - 1}
    if blend == 0.0 and len(points) > 2:
        steps = np.diff(points, axis=0)
        directions = steps / np.linalg.norm(steps, axis=1)[:, None]
        turns = np.abs(np.diff(directions, axis=0)).max(axis=1)
        stops.update((np.flatnonzero(turns > _SAME_DIRECTION) + 1).tolist())
    return sorted(stops)


def are_lines(points: Float64Array, stops: Sequence[int]) -> bool:
    """Whether straight lines between stops pass all way-points (n, d) in order."""
    line = np.minimum(np.searchsorted(stops, np.arange(len(points)), side="right"), len(stops) - 1)
    begin = points[list(stops)][line - 1]
    along, from_stop = points[list(stops)][line] - begin, points - begin
    squared = np.einsum("ij,ij->i", along, along)
    if not squared.all():
        return False
    share = np.einsum("ij,ij->i", from_stop, along) / squared
    beside = np.abs(from_stop - share[:, None] * along).max()
    return bool(beside <= _COINCIDENT and (np.diff(line + share) > 0.0).all())


def blended_path(points: Float64Array, blend: float) -> Spline:
    """Straight lines between way-points, with corners cut."""
    steps = np.diff(points, axis=0)
    lengths = np.sqrt(np.einsum("ij,ij->i", steps, steps))
    directions = steps / lengths[:, None]
    inner = _cuts(directions, lengths, blend)
    cuts = np.concatenate([[0.0], inner, [0.0]])
    knots, kept = _knots(lengths, cuts)
    pieces = np.zeros((2 * len(lengths) - 1, 6, points.shape[1]))
    pieces[::2, 0] = points[:-1] + cuts[:-1, None] * directions
    pieces[::2, 1] = directions
    cut = inner > 0.0
    pieces[1::2][cut] = _corners(
        points[1:-1][cut], directions[:-1][cut], directions[1:][cut], inner[cut]
    )
    return Spline(np.array(knots), pieces[kept])


def _cuts(directions: Float64Array, lengths: Float64Array, blend: float) -> Float64Array:
    """How far before each corner (corners,) its quintic begins, and how far behind it ends."""
    change = np.abs(np.diff(directions, axis=0)).max(axis=1)
    turns = change > _SAME_DIRECTION
    most = 16.0 * blend / (3.0 * np.where(turns, change, 1.0))
    return np.where(turns, np.minimum(most, 0.5 * np.minimum(lengths[:-1], lengths[1:])), 0.0)


def _knots(lengths: Float64Array, cuts: Float64Array) -> tuple[list[float], list[int]]:
    """The knots of lines and corners in turn, and which of these 2 lines - 1 pieces there are."""
    knots, kept = [0.0], list[int]()
    cut_at = cuts.tolist()
    for i, (length, before, after) in enumerate(
        zip(lengths.tolist(), cut_at[:-1], cut_at[1:], strict=True)
    ):
        if knots[-1] + (length - after - before) > knots[-1] * (1.0 + _ULPS):
            kept.append(2 * i)
            knots.append(knots[-1] + length - after - before)
        if after > 0.0:
            kept.append(2 * i + 1)
            knots.append(knots[-1] + 2.0 * after)
    return knots, kept


def _corners(
    corners: Float64Array, before: Float64Array, after: Float64Array, cuts: Float64Array
) -> Float64Array:
    """Quintics (corners, 6, d) over 2 cut from corner - cut before to corner + cut after."""
    cut, width, turn = cuts[:, None], 2.0 * cuts[:, None], after - before
    table = np.zeros((len(corners), 6, corners.shape[1]))
    table[:, 0], table[:, 1] = corners - cut * before, before
    for power, (by_rise, _, by_speed) in enumerate(QUINTIC.tolist(), 3):
        # Powers of numbers, as those of arrays have other bits on other processors.
        scale = np.array([each**power for each in width[:, 0].tolist()])[:, None]
        table[:, power] = (by_rise * (cut * turn) + by_speed * width * turn) / scale
    return table


_DEGREE = 5


def moving_samples(
    times: Float64Array, q: Float64Array, tolerance: float, *, timed: bool
) -> tuple[NDArray[np.intp], Float64Array]:
    """The samples farther than the tolerance from the one before, and times without waiting."""
    indices = _kept(q, tolerance)
    if timed:  # a motion is smooth over its own times, also where it is slow
        return indices, times[indices] - times[0]
    steps = np.diff(times[indices])
    usual = float(np.median(np.diff(times)))
    return indices, np.concatenate([[0.0], np.cumsum(np.minimum(steps, usual))])


def _kept(q: Float64Array, tolerance: float) -> NDArray[np.intp]:
    """Indices of the last sample and of those farther than the tolerance from the one before."""
    indices = core.rows_apart(np.ascontiguousarray(q), tolerance)
    if indices[-1] == len(q) - 1:
        return indices
    return np.append(indices[: max(len(indices) - 1, 1)], len(q) - 1)


def fit_within(
    parameters: Float64Array, q: Float64Array, tolerance: float, *, corners: bool
) -> Spline:
    """A spline with two continuous derivatives or more, within the tolerance of every sample."""
    if len(parameters) <= _DEGREE + 1:
        return through(parameters, q)
    parameters, q = np.ascontiguousarray(parameters), np.ascontiguousarray(q)
    breaks, table = core.fit_spline(parameters, q, tolerance, corners)
    return _quintics(parameters[breaks], table) if len(breaks) else through(parameters, q)


def _quintics(knots: Float64Array, table: Float64Array) -> Spline:
    return Spline(knots, table.reshape(len(knots) - 1, _DEGREE + 1, -1))


def through(parameters: Float64Array, q: Float64Array) -> Spline:
    """The cubic spline through all samples; its third derivative is continuous near its ends."""
    parameters, q = np.ascontiguousarray(parameters), np.ascontiguousarray(q)
    table = core.cubic_through(parameters, q)
    return Spline(parameters, table.reshape(len(q) - 1, 4, q.shape[1]))

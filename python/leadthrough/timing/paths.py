"""What a motion is timed along: a path of any kind, checked once and cut into smooth sections."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.motion import JointTrajectory
from leadthrough.timing.fitting import fit_within, moving_samples
from leadthrough.timing.polyline import apart, are_lines, blended_path, stops_of
from leadthrough.timing.request import Request
from leadthrough.timing.sections import Lines, Rows, Section, Sections, between
from leadthrough.trajectories import Curve, Spline

# Number of samples through which curves are fitted that are not splines, or not smooth enough.
_SAMPLES_OF_A_CURVE = 2000


@dataclass(frozen=True, eq=False)
class Path:
    """A path of any kind."""

    rows: int  # how many way-points, samples or knots it has
    start: Float64Array  # configuration (joints,) at which it begins
    sections: Callable[[Request], Sections]

    @property
    def joints(self) -> int:
        """How many joints move along it."""
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

    return between({0, *request.holds, len(q) - 1}, section, holds=request.holds)


def _cut_curve(path: Curve, request: Request) -> Sections:
    if request.holds:
        raise InvalidInput("holds: a curve without way-points has none; give a Spline")
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

    return between({0, len(path.knots) - 1}, section, holds={})


def _fitted(
    times: Float64Array, q: Float64Array, request: Request
) -> tuple[Rows, Float64Array, Spline]:
    """The samples kept, by their index, their parameters and a spline near all samples."""
    tolerance = request.path_tolerance
    found = _within(times, q, tolerance)
    if not request.keeps_positions(q) or request.keeps_positions(_reached(found[2])):
        return found
    kept, parameters, near = _within(times, q, 0.1 * tolerance)
    even = np.linspace(*near.domain, max(_SAMPLES_OF_A_CURVE, 8 * len(q)))
    places = np.union1d(parameters, even)
    u = places / near.domain[1]
    ramp = np.minimum(1.0, 10.0 * np.minimum(u, 1.0 - u))[:, None]  # the ends stay where they are
    away = ramp * np.minimum(0.8 * tolerance, 0.5 * (request.upper - request.lower))
    inside = np.clip(near.evaluate(places), request.lower + away, request.upper - away)
    return kept, parameters, fit_within(places, inside, 0.1 * tolerance)


def _within(
    times: Float64Array, q: Float64Array, tolerance: float
) -> tuple[Rows, Float64Array, Spline]:
    # Dropped samples and the fit share the tolerance.
    kept, parameters = moving_samples(times, q, 0.5 * tolerance)
    return kept, parameters, fit_within(parameters, q[kept], 0.5 * tolerance)


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
            part = fit_within(times, part.evaluate(times), request.path_tolerance)
        return Section(part, np.arange(first, last + 1), path.knots[first : last + 1])

    stops = {0, *corners.tolist(), *request.holds, len(path.knots) - 1}
    return between(stops, section, holds=request.holds)


def _cut_way_points(points: Float64Array, request: Request) -> Sections:
    # A way-point that nearly repeats the one before is dropped; its hold goes to that one.
    rows = apart(points)
    new_row = np.searchsorted(rows, np.arange(len(points)), side="right") - 1
    holds: dict[int, float] = {}
    for row, hold in request.holds.items():
        holds[int(new_row[row])] = holds.get(int(new_row[row]), 0.0) + hold
    kept = points[rows]
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(kept, axis=0), axis=1))])
    stops = stops_of(kept, blend=request.blend, holds=list(holds))
    if len(kept) > 1 and request.along_lines and are_lines(kept, stops):
        held = np.array([holds.get(stop, 0.0) for stop in stops])
        lines = Lines(kept[stops], lengths[stops], rows, lengths, held[1:])
        return Sections(held[0], [lines])

    def section(first: int, last: int) -> Section:
        part = slice(first, last + 1)
        return Section(
            blended_path(kept[part], request.blend), rows[part], lengths[part] - lengths[first]
        )

    return between(stops, section, holds=holds)

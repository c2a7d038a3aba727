"""What a path is made of: smooth sections between the places where the motion rests."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.motion import JointTrajectory
from leadthrough.timing.fitting import fit_within, moving_samples
from leadthrough.timing.polyline import blended_path, stops_of
from leadthrough.trajectories import Curve, Spline

# Curves that are no splines are fitted through so many points.
_SAMPLES_OF_A_CURVE = 2000


Rows = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Section:
    """A path with two continuous derivatives, from rest to rest.

    rows: (m,) way-points, samples or knots of the whole path. parameters: (m,) where they lie on
    the spline. hold: s, how long the motion rests at the end.
    """

    spline: Spline
    rows: Rows
    parameters: Float64Array
    hold: float


def sections(
    path: Any, *, path_tolerance: float, blend: float, holds: Mapping[int, float]
) -> tuple[float, list[Section]]:
    """How long a path rests at its start, s, and its sections; none where nothing moves.

    See `retime` for what a path is.
    """
    if isinstance(path, JointTrajectory):
        return _of_samples(path.times, path.positions, path_tolerance, holds)
    if isinstance(path, Spline):
        return _of_spline(path, path_tolerance, holds)
    if isinstance(path, Curve):
        if holds:
            raise InvalidInput("holds: a curve without way-points has none; give a Spline")
        times = np.linspace(*path.domain, _SAMPLES_OF_A_CURVE)
        return _of_samples(times, path.evaluate(times), path_tolerance, {})
    return _of_way_points(path, blend, holds)


def _of_samples(
    times: Float64Array, q: Float64Array, tolerance: float, holds: Mapping[int, float]
) -> tuple[float, list[Section]]:
    initial_hold, found = holds.get(0, 0.0), list[Section]()
    stops = sorted({0, *holds, len(q) - 1})
    for first, last in pairwise(stops):
        part = slice(first, last + 1)
        # Dropped samples and the fit share the tolerance.
        kept, parameters = moving_samples(times[part], q[part], 0.5 * tolerance)
        if np.ptp(q[part], axis=0).max() > 0.0:
            spline = fit_within(parameters, q[part][kept], 0.5 * tolerance)
            found.append(Section(spline, first + kept, parameters, holds.get(last, 0.0)))
        elif found:
            found[-1] = replace(found[-1], hold=found[-1].hold + holds.get(last, 0.0))
        elif last > 0:
            initial_hold += holds.get(last, 0.0)
    return initial_hold, found


def _of_spline(
    path: Spline, tolerance: float, holds: Mapping[int, float]
) -> tuple[float, list[Section]]:
    smoothness = path.smoothness()
    if (smoothness < 1).any():
        i = int(np.argmax(smoothness < 1)) + 1
        raise InvalidInput(f"path: expected a continuous path, got a jump at knot {i}")
    corners = np.flatnonzero(smoothness < 2) + 1
    stops = sorted({0, *(int(i) for i in corners), *holds, len(path.knots) - 1})
    initial_hold, found = holds.get(0, 0.0), list[Section]()
    for first, last in pairwise(stops):
        spline, rows = _part(path, first, last), np.arange(first, last + 1)
        if np.abs(spline.coefficients[:, 1:]).max(initial=0.0) > 0.0:
            if (smoothness[first : last - 1] < 3).any():
                times = np.linspace(*spline.domain, _SAMPLES_OF_A_CURVE)
                spline = fit_within(times, spline.evaluate(times), tolerance)
            found.append(Section(spline, rows, path.knots[rows], holds.get(last, 0.0)))
        elif found:
            found[-1] = replace(found[-1], hold=found[-1].hold + holds.get(last, 0.0))
        else:
            initial_hold += holds.get(last, 0.0)
    return initial_hold, found


def _part(path: Spline, first: int, last: int) -> Spline:
    return Spline(path.knots[first : last + 1], path.coefficients[first:last])


def _of_way_points(
    path: Any, blend: float, holds: Mapping[int, float]
) -> tuple[float, list[Section]]:
    points = check.array(path, "path", shape=("n", "joints"))
    # A way-point that repeats the one before is no way at all; what it holds, that one does.
    apart = np.concatenate([[True], (np.diff(points, axis=0) != 0.0).any(axis=1)])
    new_row = np.cumsum(apart) - 1
    kept_holds: dict[int, float] = {}
    for row, hold in holds.items():
        kept_holds[int(new_row[row])] = kept_holds.get(int(new_row[row]), 0.0) + hold
    points, rows = points[apart], np.flatnonzero(apart)
    if len(points) < 2:
        return kept_holds.get(0, 0.0), []
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    stops = stops_of(points, blend=blend, holds=list(kept_holds))
    return kept_holds.get(0, 0.0), [
        Section(
            blended_path(points[first : last + 1], blend),
            rows[first : last + 1],
            lengths[first : last + 1] - lengths[first],
            kept_holds.get(last, 0.0),
        )
        for first, last in pairwise(stops)
    ]

"""The time law of a planned path: its duration and its progress, from rest to rest."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from leadthrough.check import Float64Array, InvalidInput
from leadthrough.models import curves
from leadthrough.models.coordinates import agreed
from leadthrough.models.marching.experience import Experience, nominal_duration
from leadthrough.models.marching.route import Route
from leadthrough.models.queries import even_times
from leadthrough.motion import Trajectory, agreed_events, moved_events
from leadthrough.preprocess.resample import arc_length, by_arc_length
from leadthrough.trajectories import minimum_jerk_time_scaling

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

# Fraction of the duration within which the speed rises from rest and falls to rest. Recordings are
# cut while the hand still moves: longer ramps would distort them.
_RAMP = 0.025
TIMINGS = ("demonstrations", "speed_map", "constant")


def timed(
    route: Route, *, timing: str, duration: float | None, dt: float
) -> tuple[Trajectory, Float64Array]:
    """The motion along a route, and the fraction of the route covered at each sample."""
    from scipy.interpolate import CubicSpline

    length = float(arc_length(route.path)[-1])
    if duration is None and not route.used:
        raise InvalidInput(
            "duration: expected a number of seconds, as there is no demonstration to take it from"
        )
    total = duration or nominal_duration(route.used, route.weights, length)
    times = even_times(total, dt)
    happening = agreed_events([each.events for each in route.used], route.weights)
    posture = agreed([each.posture for each in route.used], route.weights)
    if length == 0.0:
        points = np.repeat(route.path[:1], len(times), axis=0)
        covered = np.linspace(0.0, 1.0, len(times))
    else:
        even = by_arc_length(route.path, len(route.path))
        covered = np.clip(_spline(route, timing)(times / total), 0.0, 1.0)
        points = CubicSpline(np.linspace(0.0, 1.0, len(even)), even)(covered)
    joints = None if posture is None else posture.along(times, covered)
    return Trajectory(times, points, moved_events(happening, covered, times), joints), covered


def _spline(route: Route, timing: str) -> CubicSpline:
    if timing == "speed_map":
        return _from_rest_to_rest(progress_by_speed(route.path, route.speed))
    timed_by = () if timing == "constant" else route.used
    return _mean_spline(timed_by, tuple(route.weights.tolist()))


# The same for all queries of a skill that follow the same demonstrations.
@lru_cache(maxsize=16)
def _mean_spline(used: tuple[Experience, ...], weights: tuple[float, ...]) -> CubicSpline:
    progress = curves.uniform_progress()
    if used:
        progress = np.average([each.progress for each in used], axis=0, weights=weights)
    return _from_rest_to_rest(progress)


def _from_rest_to_rest(progress: Float64Array) -> CubicSpline:
    """Progress (1001,) as a curve over normalised time, its acceleration continuous."""
    from scipy.interpolate import CubicSpline

    eased = rest_to_rest(progress)
    return CubicSpline(np.linspace(0.0, 1.0, len(eased)), eased, bc_type="clamped")


def progress_by_speed(path: Float64Array, speed: Float64Array) -> Float64Array:
    """Progress (1001,) along a path at a speed that is given."""
    pace = 1.0 / speed
    steps = np.diff(arc_length(path)) * 0.5 * (pace[1:] + pace[:-1])
    clock = np.concatenate([[0.0], np.cumsum(steps)])
    if clock[-1] == 0.0:
        return curves.uniform_progress()
    rising = np.concatenate([[True], np.diff(clock) > 0.0])
    return curves.progress_of(clock[rising], path[rising])


def rest_to_rest(progress: Float64Array) -> Float64Array:
    """The progress (1001,), smoothed, starting and ending at rest."""
    u = np.linspace(0.0, 1.0, curves.PROGRESS_SAMPLES)
    x = np.clip(np.minimum(u, 1.0 - u) / _RAMP, 0.0, 1.0)
    speed = minimum_jerk_time_scaling(x, curves.speed_of(progress))
    total = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]))])
    return np.asarray(total / total[-1])

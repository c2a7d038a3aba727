"""How far a reproduced motion is from its demonstration.

Shapes are compared as curves resampled equally in arc length, so that timing plays no part in
them. Swept error area and velocity error: Khansari-Zadeh and Billard 2014, "Learning control
Lyapunov function to ensure stability of dynamical system-based robot reaching motions".
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from leadthrough import _core, check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.motion import Trajectory
from leadthrough.planning import Grid
from leadthrough.preprocess import resample

SAMPLES = 1000  # points a curve is resampled to


@dataclass(frozen=True)
class ReproductionErrors:
    """Errors in the motion's own unit u (LASA: mm).

    swept_error_area: u^2. velocity_rmse: u/s. dtw_distance: u, per sample.
    frechet_distance, end_error: u.
    """

    swept_error_area: float
    velocity_rmse: float
    dtw_distance: float
    frechet_distance: float
    end_error: float


def reproduction_errors(demonstration: Trajectory, reproduction: Trajectory) -> ReproductionErrors:
    """All errors of a planar reproduction, its shape compared at 1000 points equal in arc length.

    Raises InvalidInput.
    """
    _same_dimension(demonstration, reproduction)
    shown = resample.by_arc_length(demonstration.positions, SAMPLES)
    made = resample.by_arc_length(reproduction.positions, SAMPLES)
    return ReproductionErrors(
        swept_error_area=swept_error_area(shown, made),
        velocity_rmse=velocity_rmse(demonstration, reproduction),
        dtw_distance=dtw_distance(shown, made) / SAMPLES,
        frechet_distance=frechet_distance(shown, made),
        end_error=end_error(demonstration, reproduction),
    )


def swept_error_area(a: Any, b: Any) -> float:
    """Area between curves (n, 2), as the sum over the quadrilaterals (a_k, a_k+1, b_k+1, b_k).

    Each counts with its shoelace area: one that crosses itself with the difference of its halves.
    Raises InvalidInput.
    """
    first = check.array(a, "a", shape=("n", 2))
    second = check.array(b, "b", shape=first.shape)
    with np.errstate(over="ignore", invalid="ignore"):
        d, e = second[1:] - first[:-1], second[:-1] - first[1:]  # the diagonals
        return _finite(0.5 * np.abs(d[:, 0] * e[:, 1] - d[:, 1] * e[:, 0]).sum())


def velocity_rmse(demonstration: Trajectory, reproduction: Trajectory) -> float:
    """Root mean square difference of the velocities at the demonstration's times, unit/s.

    Both start together; a reproduction that ends earlier stays at its last point.
    Raises InvalidInput.
    """
    _same_dimension(demonstration, reproduction)
    times = demonstration.times - demonstration.times[0]
    if len(times) < 2:
        raise InvalidInput("demonstration: expected at least two samples, got one")
    own_times = reproduction.times - reproduction.times[0]
    made = np.column_stack([np.interp(times, own_times, x) for x in reproduction.positions.T])
    with np.errstate(over="ignore", invalid="ignore"):
        difference = np.gradient(demonstration.positions - made, times, axis=0)
        return _finite(np.sqrt((difference**2).sum(axis=1).mean()))


def dtw_distance(a: Any, b: Any) -> float:
    """Dynamic time warping distance of curves (n, d) and (m, d): the least sum over paired points.

    Symmetric steps of weight one (Sakoe and Chiba 1978). Raises InvalidInput.
    """
    return _finite(_core.dtw_distance(*_curves(a, b)))


def frechet_distance(a: Any, b: Any) -> float:
    """Discrete Frechet distance of curves (n, d) and (m, d) (Eiter and Mannila 1994).

    Raises InvalidInput.
    """
    return _finite(_core.frechet_distance(*_curves(a, b)))


def end_error(demonstration: Trajectory, reproduction: Trajectory) -> float:
    """Distance between the last points. Raises InvalidInput."""
    _same_dimension(demonstration, reproduction)
    with np.errstate(over="ignore"):
        return _finite(np.linalg.norm(demonstration.positions[-1] - reproduction.positions[-1]))


def turning(path: Any, *, step: float) -> float:
    """Total angle that a path (n, d) turns by, rad, seen in pieces of one length near `step`.

    0 for a straight line, more for every bend and every tremble longer than the pieces. step: in
    the path's unit, > 0. Raises InvalidInput.
    """
    points = check.array(path, "path", shape=("n", "d"))
    pieces = resample.arc_length(points)[-1] / check.number(step, "step", above=0.0)
    chords = np.diff(resample.by_arc_length(points, max(int(np.ceil(pieces)), 1) + 1), axis=0)
    lengths = np.linalg.norm(chords, axis=1)
    cosines = (chords[1:] * chords[:-1]).sum(axis=1) / (lengths[1:] * lengths[:-1])
    return _finite(np.arccos(np.clip(cosines, -1.0, 1.0)).sum())


def dimensionless_jerk(motion: Trajectory, *, samples: int = 101) -> float:
    """Integral of the squared jerk times duration^5 / length^2; 720 for a minimum-jerk line.

    The motion is seen at `samples` even times, so that the recording's rate plays no part.
    Source: Hogan and Sternad 2009, "Sensitivity of smoothness measures to movement duration,
    amplitude, and arrests". Raises InvalidInput.
    """
    count = check.integer(samples, "samples", at_least=8)
    even = np.linspace(motion.times[0], motion.times[-1], count)
    points = np.column_stack([np.interp(even, motion.times, x) for x in motion.positions.T])
    step = 1.0 / (count - 1)  # of the duration
    jerk = np.diff(points, n=3, axis=0) / step**3
    length = resample.arc_length(points)[-1]
    if length == 0.0:
        raise InvalidInput("motion: expected one that moves, got a single place")
    return _finite((jerk**2).sum() * step / length**2)


def speed_along(path: Any, grid: Grid, speed: Float64Array, outside: float) -> Float64Array:
    """The speed (n,) in the cells that points (n, d) of a path lie in.

    speed: an array of the grid's shape. outside: the speed off the grid. Raises InvalidInput.
    """
    points = check.array(path, "path", shape=("n", grid.dimensions))
    inside = grid.contains(points)
    found = np.full(len(points), check.number(outside, "outside"))
    found[inside] = speed[tuple(grid.cells_of(points[inside]).T)]
    return found


def _curves(a: Any, b: Any) -> tuple[Float64Array, Float64Array]:
    first = check.array(a, "a", shape=("n", "d"))
    second = check.array(b, "b", shape=("m", first.shape[1]))
    for curve, name in ((first, "a"), (second, "b")):
        if curve.size == 0:
            raise InvalidInput(f"{name}: expected at least one point, got shape {curve.shape}")
    return first, second


def _same_dimension(demonstration: Trajectory, reproduction: Trajectory) -> None:
    for motion, name in ((demonstration, "demonstration"), (reproduction, "reproduction")):
        if not isinstance(motion, Trajectory):
            raise InvalidInput(f"{name}: expected a Trajectory, got {type(motion).__name__}")
    wanted, got = demonstration.positions.shape[1], reproduction.positions.shape[1]
    if wanted != got:
        raise InvalidInput(f"reproduction: expected {wanted} coordinates, got {got}")


def _finite(value: Any) -> float:
    if not np.isfinite(value):
        raise InvalidInput("curves: expected coordinates whose squares are finite, got larger ones")
    return float(value)

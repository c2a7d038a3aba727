"""Errors of a reproduced motion against its demonstration.

Shapes are compared as curves resampled at equal steps of arc length, so that timing has no effect.
Swept error area and velocity error: Khansari-Zadeh and Billard 2014, "Learning control Lyapunov
function to ensure stability of dynamical system-based robot reaching motions".
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.motion import Trajectory
from leadthrough.planning import Grid
from leadthrough.preprocess import dtw_distance, frechet_distance, resample

SAMPLES = 1000  # points per resampled curve


@dataclass(frozen=True)
class ReproductionErrors:
    """Errors in the motion's own unit of length u (LASA: mm).

    Attributes:
        swept_error_area: area between the curves, u^2.
        velocity_rmse: root mean square velocity error, u/s.
        dtw_distance: dynamic time warping distance per sample, u.
        frechet_distance: discrete Frechet distance, u.
        end_error: distance between the last points, u.
    """

    swept_error_area: float
    velocity_rmse: float
    dtw_distance: float
    frechet_distance: float
    end_error: float


def reproduction_errors(demonstration: Trajectory, reproduction: Trajectory) -> ReproductionErrors:
    """All errors of a planar reproduction; shapes are compared at 1000 points.

    Args:
        demonstration: the motion wanted, with positions (n, 2).
        reproduction: the motion made, with positions (m, 2).

    Raises:
        InvalidInput: if one is not a planar Trajectory, the demonstration has a single sample, or
            an error is not finite.
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


def swept_error_area(a: ArrayLike, b: ArrayLike) -> float:
    """Area between two curves: the sum over the quadrilaterals (a_k, a_k+1, b_k+1, b_k).

    Each quadrilateral counts with its shoelace area, so one that crosses itself counts with the
    difference of its halves.

    Args:
        a: points (n, 2) of the first curve.
        b: points (n, 2) of the second curve.

    Raises:
        InvalidInput: if the shapes are not (n, 2) and equal, or the area is not finite.
    """
    first = check.array(a, "a", shape=("n", 2))
    second = check.array(b, "b", shape=first.shape)
    with np.errstate(over="ignore", invalid="ignore"):
        d, e = second[1:] - first[:-1], second[:-1] - first[1:]  # the diagonals
        return _finite(0.5 * np.abs(d[:, 0] * e[:, 1] - d[:, 1] * e[:, 0]).sum())


def velocity_rmse(demonstration: Trajectory, reproduction: Trajectory) -> float:
    """Root mean square difference of the velocities at the demonstration's times, unit/s.

    Both motions start at the same time; a reproduction that ends earlier stays at its last point.

    Args:
        demonstration: the motion wanted, with at least two samples.
        reproduction: the motion made.

    Raises:
        InvalidInput: if one is not a Trajectory, the dimensions differ, the demonstration has a
            single sample, or the error is not finite.
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


def end_error(demonstration: Trajectory, reproduction: Trajectory) -> float:
    """Distance between the last points of two motions.

    Args:
        demonstration: the motion wanted.
        reproduction: the motion made.

    Raises:
        InvalidInput: if one is not a Trajectory, the dimensions differ or the distance is not
            finite.
    """
    _same_dimension(demonstration, reproduction)
    with np.errstate(over="ignore"):
        return _finite(np.linalg.norm(demonstration.positions[-1] - reproduction.positions[-1]))


def turning(path: ArrayLike, *, step: float) -> float:
    """Total angle by which a path changes its direction, rad, between pieces of equal length.

    It is 0 for a straight line and grows with every bend and tremor longer than the pieces.

    Args:
        path: points (n, d).
        step: approximate length of the pieces, in the path's unit, > 0.

    Raises:
        InvalidInput: if the path is not a finite (n, d) array or step is not positive.
    """
    points = check.array(path, "path", shape=("n", "d"))
    pieces = resample.arc_length(points)[-1] / check.number(step, "step", above=0.0)
    chords = np.diff(resample.by_arc_length(points, max(int(np.ceil(pieces)), 1) + 1), axis=0)
    lengths = np.linalg.norm(chords, axis=1)
    cosines = (chords[1:] * chords[:-1]).sum(axis=1) / (lengths[1:] * lengths[:-1])
    return _finite(np.arccos(np.clip(cosines, -1.0, 1.0)).sum())


def dimensionless_jerk(motion: Trajectory, *, samples: int = 101) -> float:
    """Integral of the squared jerk times duration^5 / length^2; 720 for a minimum-jerk line.

    Args:
        motion: the motion to measure.
        samples: number of evenly spaced times at which the motion is evaluated, so that the
            sampling rate of the recording has no effect; at least 8.

    Raises:
        InvalidInput: if samples is below 8, the motion stays in one place or the result is not
            finite.

    Source: Hogan and Sternad 2009, "Sensitivity of smoothness measures to movement duration,
    amplitude, and arrests".
    """
    count = check.integer(samples, "samples", at_least=8)
    even = np.linspace(motion.times[0], motion.times[-1], count)
    points = np.column_stack([np.interp(even, motion.times, x) for x in motion.positions.T])
    step = 1.0 / (count - 1)  # of the duration
    jerk = np.diff(points, n=3, axis=0) / step**3
    length = resample.arc_length(points)[-1]
    if length == 0.0:
        raise InvalidInput("motion: expected a motion of some length, got one that stays in place")
    return _finite((jerk**2).sum() * step / length**2)


def speed_along(path: ArrayLike, grid: Grid, speed: Float64Array, outside: float) -> Float64Array:
    """The speed of the cell in which each point of a path lies.

    Args:
        path: points (n, d).
        grid: the grid of the speed map.
        speed: speeds, an array of the grid's shape.
        outside: the speed of points that are not on the grid.

    Returns:
        Speeds (n,).

    Raises:
        InvalidInput: if the path is not a finite (n, d) array of the grid's dimension.
    """
    points = check.array(path, "path", shape=("n", grid.dimensions))
    inside = grid.contains(points)
    found = np.full(len(points), check.number(outside, "outside"))
    found[inside] = speed[tuple(grid.cells_of(points[inside]).T)]
    return found


def _same_dimension(demonstration: Trajectory, reproduction: Trajectory) -> None:
    for motion, name in ((demonstration, "demonstration"), (reproduction, "reproduction")):
        if not isinstance(motion, Trajectory):
            raise InvalidInput(f"{name}: expected a Trajectory, got {type(motion).__name__}")
    wanted, got = demonstration.positions.shape[1], reproduction.positions.shape[1]
    if wanted != got:
        raise InvalidInput(f"reproduction: expected {wanted} coordinates, got {got}")


def _finite(value: float | np.floating) -> float:
    if not np.isfinite(value):
        raise InvalidInput("curves: expected coordinates whose squares are finite, got larger ones")
    return float(value)

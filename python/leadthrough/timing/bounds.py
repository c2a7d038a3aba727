"""Bounds on the motion along a path besides the joints' limits of velocity, acceleration and jerk.

Along a path of length l, with x = (dl/dt)^2 and u = d2l/dt2, every row of a table says
lower <= gain u + bend x <= upper; see Pham and Pham 2018, section III.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from leadthrough import _core, check
from leadthrough.check import Float64Array

Jacobian = Callable[[Float64Array], Float64Array]
InverseDynamics = Callable[[Float64Array, Float64Array, Float64Array], Float64Array]


@dataclass(frozen=True, eq=False)
class PathBounds:
    """Bounds at the n points of a path's grid."""

    fastest: Float64Array  # the largest x, (n,)
    gain: Float64Array  # factor of u in each row of the table, (n, rows)
    bend: Float64Array  # factor of x, (n, rows)
    lower: Float64Array  # lower bound of the row, (n, rows)
    upper: Float64Array  # upper bound of the row, (n, rows)


def unbounded(path: _core.TimedPath) -> PathBounds:
    """No bounds."""
    count = len(path.length)
    empty = np.empty((count, 0))
    return PathBounds(np.full(count, np.inf), empty, empty, empty, empty)


def slower_than(bounds: PathBounds, squared: Float64Array) -> PathBounds:
    """The bounds, with x at most `squared` (n,)."""
    return replace(bounds, fastest=np.minimum(bounds.fastest, squared))


def paced(
    path: _core.TimedPath, parameters: Float64Array, times: Float64Array
) -> tuple[Float64Array, Float64Array]:
    """Times (n,) at the grid's points, and x (n,) there, of a motion known at some parameters."""
    from scipy.interpolate import PchipInterpolator

    clock = PchipInterpolator(parameters, times)
    with np.errstate(divide="ignore"):
        return clock(path.parameter), np.asarray((1.0 / clock(path.parameter, 1) / path.slope) ** 2)


def tip_within(path: _core.TimedPath, jacobian: Jacobian, speed: float) -> Float64Array:
    """x (n,) at the grid's points at which the tip moves at `speed`, m/s."""
    with np.errstate(divide="ignore"):
        return np.asarray((speed / tip_speeds(jacobian, path.positions, path.first)) ** 2)


def with_efforts(
    bounds: PathBounds, path: _core.TimedPath, dynamics: InverseDynamics, effort: Float64Array
) -> PathBounds:
    """The bounds, with the joints' efforts kept inside their limits."""
    still = np.zeros_like(path.positions)
    rest = efforts(dynamics, path.positions, still, still)
    gain = efforts(dynamics, path.positions, still, path.first) - rest
    bend = efforts(dynamics, path.positions, path.first, path.second) - rest
    return PathBounds(bounds.fastest, gain, bend, -effort - rest, effort - rest)


def tip_speeds(jacobian: Jacobian, q: Float64Array, velocities: Float64Array) -> Float64Array:
    """Speeds (n,) of the tip, m/s, at configurations and velocities (n, joints)."""
    speeds = []
    for row, velocity in zip(q, velocities, strict=True):
        matrix = check.array(jacobian(row), "jacobian(q)", shape=("rows", len(row)))
        speeds.append(np.linalg.norm(matrix[:3] @ velocity))
    return np.array(speeds)


def efforts(
    dynamics: InverseDynamics, q: Float64Array, qd: Float64Array, qdd: Float64Array
) -> Float64Array:
    """Efforts (n, joints) of states (n, joints), N m (N)."""
    name = "inverse_dynamics(q, qd, qdd)"
    rows = zip(q, qd, qdd, strict=True)
    return np.array([check.array(dynamics(*row), name, shape=(q.shape[1],)) for row in rows])

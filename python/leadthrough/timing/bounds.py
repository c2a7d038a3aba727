"""Bounds on the motion along a path beyond those of the joints' rates.

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
    """fastest: (n,) the largest x at the grid's points. The rest: (n, rows)."""

    fastest: Float64Array
    gain: Float64Array
    bend: Float64Array
    lower: Float64Array
    upper: Float64Array


def unbounded(path: _core.TimedPath) -> PathBounds:
    """No bounds."""
    count = len(path.length)
    empty = np.empty((count, 0))
    return PathBounds(np.full(count, np.inf), empty, empty, empty, empty)


def slower_than(bounds: PathBounds, squared: Float64Array) -> PathBounds:
    """The bounds, with x at most `squared` (n,)."""
    return replace(bounds, fastest=np.minimum(bounds.fastest, squared))


def paced(path: _core.TimedPath, parameters: Float64Array, times: Float64Array) -> Float64Array:
    """x (n,) of a motion that is at the parameters (m,) at the times (m,)."""
    middles = 0.5 * (parameters[1:] + parameters[:-1])
    pace = np.interp(path.parameter, middles, np.diff(parameters) / np.diff(times))
    return np.asarray((pace / path.slope) ** 2)


def tip_within(path: _core.TimedPath, jacobian: Jacobian, speed: float) -> Float64Array:
    """x (n,) at which the tip moves at `speed`, m/s."""
    with np.errstate(divide="ignore"):
        return np.asarray((speed / tip_speeds(jacobian, path.positions, path.first)) ** 2)


def with_efforts(
    bounds: PathBounds, path: _core.TimedPath, dynamics: InverseDynamics, effort: Float64Array
) -> PathBounds:
    """The bounds, with the joints' efforts inside +-effort (joints,)."""
    still = np.zeros_like(path.positions)
    rest = efforts(dynamics, path.positions, still, still)
    gain = efforts(dynamics, path.positions, still, path.first) - rest
    bend = efforts(dynamics, path.positions, path.first, path.second) - rest
    return PathBounds(bounds.fastest, gain, bend, -effort - rest, effort - rest)


def tip_speeds(jacobian: Jacobian, q: Float64Array, velocities: Float64Array) -> Float64Array:
    """(n,) m/s at configurations and velocities (n, joints). Raises InvalidInput."""
    speeds = []
    for row, velocity in zip(q, velocities, strict=True):
        matrix = check.array(jacobian(row), "jacobian(q)", shape=("rows", len(row)))
        speeds.append(np.linalg.norm(matrix[:3] @ velocity))
    return np.array(speeds)


def efforts(
    dynamics: InverseDynamics, q: Float64Array, qd: Float64Array, qdd: Float64Array
) -> Float64Array:
    """(n, joints) N m (N) of states (n, joints). Raises InvalidInput."""
    name = "inverse_dynamics(q, qd, qdd)"
    rows = zip(q, qd, qdd, strict=True)
    return np.array([check.array(dynamics(*row), name, shape=(q.shape[1],)) for row in rows])

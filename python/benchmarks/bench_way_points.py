"""The time law of long paths: thousands of way-points, and the samples that `follow` returns.

Straight lines are compared with ruckig from rest to rest on each, which has the same limits and
knows the optimum, and tells the durations alone; the error is how much longer we take, less a
sample for each line. With corners cut and along samples, toppra takes a spline through the
same points, without limits of jerk; the error is by how much a limit is exceeded, infinite if a
way-point or sample is missed.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
import toppra
from frame import Benchmark
from ruckig import InputParameter, Ruckig, Synchronization, Trajectory
from scipy.spatial import cKDTree
from toppra import algorithm, constraint

import leadthrough as lt

RATE = 1000.0
BLEND = 1e-3  # rad
STEP = 0.002  # rad, of the way-points
TOLERANCE = 1e-5  # rad, of the path along samples
SAMPLES = 2001
EXCESS = 1e-6
LONGER = 1e-3


def benchmarks(*, quick: bool) -> Iterator[Benchmark]:
    """Two rows of way-points, and two of samples."""
    logging.getLogger("toppra").setLevel(logging.ERROR)
    limits, count = lt.Arm.load("panda").limits, 400 if quick else 4000
    way = _way_points(limits, count)
    yield Benchmark(
        f"time law of {count} way-points, at rest at each",
        ours=partial(lt.retime, way, limits, rate=RATE),
        peer=partial(_line_by_line, way, limits),
        peer_name="ruckig",
        error=partial(_longer, limits, count),
        tolerance=LONGER,
    )
    yield Benchmark(
        f"time law of {count} way-points, corners cut",
        ours=partial(lt.retime, way, limits, rate=RATE, blend=BLEND),
        peer=partial(_through, way, limits, 5 * count),
        peer_name="toppra",
        error=partial(_off, way, limits, BLEND),
        tolerance=EXCESS,
    )
    followed = _followed()
    yield Benchmark(
        f"time law of {SAMPLES} samples of seven joints, at 1 kHz",
        ours=partial(lt.retime, followed, limits, rate=RATE, path_tolerance=TOLERANCE),
        peer=partial(_through, followed.positions, limits, SAMPLES),
        peer_name="toppra",
        error=partial(_off, followed.positions, limits, TOLERANCE),
        tolerance=EXCESS,
    )
    recorded, some = _recorded(25_000 if quick else 600_000), 5000
    thin = recorded.positions[:: len(recorded) // some]
    yield Benchmark(
        f"time law of a recording of {len(recorded)} samples of seven joints",
        ours=partial(lt.retime, recorded, limits, rate=RATE, path_tolerance=TOLERANCE),
        peer=partial(_through, thin, limits, len(thin)),
        peer_name=f"toppra through {some} of them",
        error=partial(_off, thin, limits, TOLERANCE),
        tolerance=EXCESS,
    )


def _way_points(limits: Any, count: int) -> Any:
    """A random walk in the middle of the ranges, (count, 7)."""
    steps = np.random.default_rng(0).normal(size=(count, 7))
    return 0.5 * (limits.lower + limits.upper) + np.cumsum(STEP * steps, axis=0)


def _followed() -> lt.JointTrajectory:
    """The joints along a path of the Panda's tip, as `follow` returns them."""
    arm = lt.Arm.load("panda")
    position, orientation = arm.forward_kinematics([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7])
    u = np.linspace(0.0, 1.0, SAMPLES)
    turn = np.outer(np.sin(np.pi * u), [0.2, -0.1, 0.3])
    way = position + np.column_stack([0.1 * np.sin(5.0 * u), 0.2 * u, 0.1 * np.sin(3.0 * u)])
    turned = lt.rotations.compose(np.tile(orientation, (SAMPLES, 1)), lt.rotations.exp(turn))
    return arm.follow(lt.PoseTrajectory(8.0 * u, way, turned))


def _recorded(count: int) -> lt.JointTrajectory:
    """Joints that move all the time, at 1 kHz."""
    times = np.arange(count) / RATE
    phases = np.outer(times, np.linspace(0.3, 0.7, 7)) + np.arange(7)
    return lt.JointTrajectory(times, _followed().positions[0] + 0.2 * np.sin(phases))


def _line_by_line(way: Any, limits: Any) -> float:
    """The duration from rest to rest along each line, s."""
    solver, asked = Ruckig(way.shape[1]), InputParameter(way.shape[1])
    asked.synchronization = Synchronization.Phase
    asked.max_velocity, asked.max_acceleration = limits.velocity, limits.acceleration
    asked.max_jerk = limits.jerk
    total, found = 0.0, Trajectory(way.shape[1])
    for begin, end in pairwise(way):
        asked.current_position, asked.target_position = begin, end
        solver.calculate(asked, found)
        total += found.duration
    return total


def _through(way: Any, limits: Any, points: int) -> Any:
    """The positions of toppra's motion through way-points, at 1 kHz."""
    path = toppra.SplineInterpolator(np.linspace(0.0, 1.0, len(way)), way)
    bounds = [
        constraint.JointVelocityConstraint(np.outer(limits.velocity, [-1.0, 1.0])),
        constraint.JointAccelerationConstraint(np.outer(limits.acceleration, [-1.0, 1.0])),
    ]
    grid = np.linspace(0.0, 1.0, points)
    solver = algorithm.TOPPRA(bounds, path, gridpoints=grid, solver_wrapper="seidel")
    motion = solver.compute_trajectory(0.0, 0.0)
    return motion(np.arange(0.0, motion.duration, 1.0 / RATE))


def _longer(limits: Any, count: int, motion: Any, best: float) -> float:
    """By how much of itself the duration is longer than the best one and a sample for each line."""
    if _excess(motion.positions, limits) > EXCESS:
        return np.inf
    longer = float(motion.duration - count / RATE) / best - 1.0
    return max(longer, best / motion.duration - 1.0, 0.0)


def _off(points: Any, limits: Any, most: float, motion: Any, _peer: Any) -> float:
    """The excess of a limit; infinite if a point is farther from the motion than allowed."""
    step = np.abs(np.diff(motion.positions, axis=0)).max()
    missed, _ = cKDTree(motion.positions).query(points, p=np.inf)
    return np.inf if missed.max() > most + step else _excess(motion.positions, limits)


def _excess(q: Any, limits: Any) -> float:
    standing = np.vstack([q[[0] * 3], q, q[[-1] * 3]])
    used = [
        np.abs(np.diff(standing, order, axis=0)).max(axis=0) * RATE**order / limit
        for order, limit in enumerate((limits.velocity, limits.acceleration, limits.jerk), 1)
    ]
    return max(float(np.max(used)) - 1.0, 0.0)

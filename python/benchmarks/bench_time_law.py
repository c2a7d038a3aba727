"""The time law against toppra: duration beside the optimum, processor time, limits kept.

Splines through twelve random way-points of seven joints, with the Panda's limits. The optimum is
toppra's in its interpolation scheme on 3,000 points, which knows no jerk; the times are compared
with toppra's on 1,000. The error column shows the median of our duration over the optimum, less
one, or by how much differences of samples at 1 kHz exceed a limit, where that is more.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import toppra
from frame import Benchmark
from scipy.interpolate import CubicSpline
from toppra import algorithm, constraint

import leadthrough as lt
from leadthrough.trajectories import Spline

RATE = 1000.0
WAY_POINTS = 12
POINTS = 1000
OPTIMUM_POINTS = 3000
SPREAD = 1.0  # rad about zero
# Share of the Panda's jerk limits, and the largest median of the duration over the optimum.
JERKS = {1.0: 1.004, 0.1: 1.012, 0.02: 1.045}
EXCESS = 1e-6


def benchmarks(*, quick: bool) -> Iterator[Benchmark]:
    """One row a jerk limit."""
    logging.getLogger("toppra").setLevel(logging.ERROR)
    limits = lt.Arm.load("panda").limits
    paths = [way_points(seed) for seed in range(10 if quick else 100)]
    optima = np.array([peer(way, limits, OPTIMUM_POINTS) for way in paths])
    for share, most in JERKS.items():
        yield Benchmark(
            f"time law of {len(paths)} splines, {share:g} of the jerk limits",
            ours=partial(_all, paths, limits, share),
            peer=lambda: [peer(way, limits, POINTS) for way in paths],
            peer_name="toppra",
            error=partial(_error, limits, share, optima),
            tolerance=most - 1.0,
        )


def way_points(seed: int) -> Any:
    """Random way-points (points, 7)."""
    return np.random.default_rng(seed).uniform(-SPREAD, SPREAD, (WAY_POINTS, 7))


def peer(way: Any, limits: Any, points: int) -> float:
    """The duration that toppra finds, s."""
    path = toppra.SplineInterpolator(np.linspace(0.0, 1.0, len(way)), way)
    scheme = constraint.DiscretizationType.Interpolation
    velocity = constraint.JointVelocityConstraint(np.outer(limits.velocity, [-1.0, 1.0]))
    acceleration = constraint.JointAccelerationConstraint(
        np.outer(limits.acceleration, [-1.0, 1.0]), discretization_scheme=scheme
    )
    grid = np.linspace(0.0, 1.0, points + 1)
    solver = algorithm.TOPPRA(
        [velocity, acceleration], path, gridpoints=grid, solver_wrapper="seidel"
    )
    _, speeds, _ = solver.compute_parameterization(0.0, 0.0)
    return float(np.sum(2.0 * np.diff(grid) / (speeds[1:] + speeds[:-1])))


def ours(way: Any, limits: Any, share: float) -> Any:
    """Our motion, sampled."""
    spline = CubicSpline(np.linspace(0.0, 1.0, len(way)), way)
    path = Spline(spline.x, spline.c[::-1].transpose(1, 0, 2))
    far = np.full(way.shape[1], np.inf)
    rates = replace(limits, lower=-far, upper=far, jerk=share * limits.jerk)
    return lt.retime(path, rates, rate=RATE)


def _all(paths: Any, limits: Any, share: float) -> list[Any]:
    return [ours(way, limits, share) for way in paths]


def _error(limits: Any, share: float, optima: Any, motions: Any, _peer: Any) -> float:
    durations = np.array([motion.duration for motion in motions])
    excess = max(_excess(motion.positions, limits, share) for motion in motions)
    return float(np.median(durations / optima)) - 1.0 if excess <= EXCESS else excess


def _excess(q: Any, limits: Any, share: float) -> float:
    standing = np.vstack([q[[0] * 3], q, q[[-1] * 3]])
    kinds = (limits.velocity, limits.acceleration, limits.jerk * share)
    used = [
        np.abs(np.diff(standing, order, axis=0)).max(axis=0) * RATE**order / limit
        for order, limit in enumerate(kinds, 1)
    ]
    return float(np.max(used)) - 1.0

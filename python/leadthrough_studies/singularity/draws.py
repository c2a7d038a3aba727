"""Thousands of straight paths of a Panda, for the rows of Tables I and II of Yang et al.

The paper does not state its paths, its settings, its tip and the unit in which it counts rotations
in the condition number, so all are drawn. Configurations are uniform inside the joints' limits; a
path of the tip starts where the condition number is in the band of the paper's thresholds, and goes
straight by 0.1 to 0.4 m, with the tool held. Kept are the paths whose row without the method is the
paper's within `TOLERANCE`; the method runs along each with all settings of a grid. The paper's rows
with the method are then places in the distribution of the rows that come out.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import Any

import numpy as np

from leadthrough.arm import Arm
from leadthrough.check import Float64Array
from leadthrough.motion import JointTrajectory, PoseTrajectory
from leadthrough.trajectories import minimum_jerk_time_scaling
from leadthrough_studies import intervals
from leadthrough_studies.damped_least_squares import DampedLeastSquares, follow_path
from leadthrough_studies.study import Row

# Table: percentages of samples below 8 and below 10, without and with the method.
TABLES = {"I": ((0.0, 100.0), (20.0, 83.0)), "II": ((0.0, 72.0), (28.0, 83.0))}
THRESHOLDS = (8.0, 10.0)
TIPS = ("panda_hand_tcp", "panda_hand")
TOLERANCE = 5.0  # percentage points of a row without the method
NEAR = 8.0  # percentage points of a row with it
_DAMPINGS, _FROM, _GAINS = (0.05, 0.1, 0.3), (3.0, 8.0, 10.0), (0.0, 0.5, 2.0)
GRID = tuple(product(_DAMPINGS, _FROM, _GAINS))
_CANDIDATES = 4000  # configurations at once
_LENGTHS = (0.1, 0.4)  # m
_DURATION, _SAMPLES = 4.0, 81
_LOST = 1e-3  # m; a plain path that is farther off met a limit


def rows_of_tables(*, seed: int, unit: float, tip: str, paths: int) -> list[Row]:
    """A row for every path kept, and one with the numbers of configurations and paths drawn.

    Args:
        seed: of all random numbers.
        unit: weight of rotations in the condition number and in the method, m per rad.
        tip: link whose path is straight.
        paths: number of paths drawn.
    """
    arm, rng = Arm.load("panda", tip=tip), np.random.default_rng(seed)
    labels = {"study": "draws", "seed": seed, "unit": unit, "tip": tip}
    starts, shares = _starts(arm, unit, paths, rng)
    kept: list[Row] = []
    followed = 0
    for way, joints in _plain(arm, starts, rng, unit):
        followed += 1
        plain = _below(arm, joints, unit)
        for table, (wanted, _) in TABLES.items():
            if np.abs(np.subtract(plain, wanted)).max() <= TOLERANCE:
                found = [_with_method(arm, way, joints, unit, each) for each in GRID]
                kept.append({**labels, "table": table, "plain": plain, "found": found})
    drawn = {"study": "drawn", "seed": seed, "unit": unit, "tip": tip, "paths": followed}
    return [drawn | dict(zip(("below_8", "below_10"), shares, strict=True)), *kept]


def relation(*, seed: int, paths: int) -> list[Row]:
    """A row for every path without the method: condition numbers and loads."""
    arm, rng = Arm.load("panda"), np.random.default_rng(seed)
    starts = rng.uniform(arm.limits.lower, arm.limits.upper, (paths, len(arm.joint_names)))
    return [
        {"study": "relation", "seed": seed, **loads(arm, joints)}
        for _, joints in _plain(arm, starts, rng, 1.0)
    ]


def loads(arm: Arm, joints: JointTrajectory) -> Row:
    """Largest condition numbers of a joint motion, and what they might go with."""
    velocities = np.gradient(joints.positions, joints.times, axis=0)
    accelerations = np.gradient(velocities, joints.times, axis=0)
    torques = arm.inverse_dynamics(joints.positions, velocities, accelerations)
    rates = np.gradient(torques, joints.times, axis=0)
    effort = np.abs(torques).max(axis=0) / arm.limits.effort
    return {
        "condition": float(arm.condition_number(joints.positions, rotation_weight=1.0).max()),
        "condition_weighted": float(arm.condition_number(joints.positions).max()),
        "peak_velocity": float(np.abs(velocities).max()),
        "peak_share_of_velocity_limit": float((np.abs(velocities) / arm.limits.velocity).max()),
        "peak_share_of_effort_limit": float(effort.max()),
        "torque_roughness": float(np.sqrt((rates**2).sum(axis=1).mean())),
    }


def _starts(
    arm: Arm, unit: float, count: int, rng: np.random.Generator
) -> tuple[Float64Array, list[float]]:
    """Configurations in the band, and the percentages of all that are below each threshold."""
    found: list[Float64Array] = []
    below = np.zeros(len(THRESHOLDS))
    drawn = 0
    while sum(map(len, found)) < count and drawn < 100 * _CANDIDATES:
        shape = (_CANDIDATES, len(arm.joint_names))
        q = rng.uniform(arm.limits.lower, arm.limits.upper, shape)
        condition = arm.condition_number(q, rotation_weight=unit)
        below += [(condition < bound).sum() for bound in THRESHOLDS]
        drawn += _CANDIDATES
        found.append(q[(condition >= THRESHOLDS[0]) & (condition < THRESHOLDS[1])])
    return np.concatenate(found)[:count], (100.0 * below / drawn).tolist()


def _plain(
    arm: Arm, starts: Float64Array, rng: np.random.Generator, unit: float
) -> Iterator[tuple[PoseTrajectory, JointTrajectory]]:
    """Paths from each start that the pseudo-inverse follows, with their joints."""
    settings = DampedLeastSquares(damping=0.0, nullspace_gain=0.0, rotation_weight=unit)
    times = np.linspace(0.0, _DURATION, _SAMPLES)
    along = minimum_jerk_time_scaling(times / _DURATION)[:, None]
    for q in starts:
        position, orientation = arm.forward_kinematics(q)
        direction = rng.standard_normal(3)
        way = rng.uniform(*_LENGTHS) * direction / np.linalg.norm(direction)
        line = PoseTrajectory(times, position + along * way, np.tile(orientation, (_SAMPLES, 1)))
        path = follow_path(arm, line, q0=q, settings=settings)
        if path.position_error.max() < _LOST:
            yield line, path.joints


def _with_method(
    arm: Arm,
    way: PoseTrajectory,
    plain: JointTrajectory,
    unit: float,
    setting: tuple[float, float, float],
) -> list[float]:
    """Percentages below the thresholds with a setting of the method."""
    damping, threshold, gain = setting
    settings = DampedLeastSquares(
        damping=damping, condition_threshold=threshold, nullspace_gain=gain, rotation_weight=unit
    )
    path = follow_path(arm, way, q0=plain.positions[0], settings=settings)
    return _below(arm, path.joints, unit)


def _below(arm: Arm, joints: JointTrajectory, unit: float) -> list[float]:
    """Percentages of samples below the thresholds."""
    condition = arm.condition_number(joints.positions, rotation_weight=unit)
    return [100.0 * float((condition < bound).mean()) for bound in THRESHOLDS]


def table(rows: list[Row]) -> list[dict[str, Any]]:
    """A line for each table and unit: percentiles of the rows, and the paper's among them."""
    units = sorted({row["unit"] for row in rows if row["study"] == "drawn"}, reverse=True)
    return [_line(rows, table, unit) for table in TABLES for unit in units]


def _line(rows: list[Row], table: str, unit: float) -> dict[str, Any]:
    drawn = [row for row in rows if row["study"] == "drawn" and row["unit"] == unit]
    kept = [
        row
        for row in rows
        if row["study"] == "draws" and row["unit"] == unit and row["table"] == table
    ]
    count = sum(row["paths"] for row in drawn)
    line: dict[str, Any] = {
        "table": table,
        "unit_m_per_rad": unit,
        "postures_below_8_percent": float(np.mean([row["below_8"] for row in drawn])),
        "postures_below_10_percent": float(np.mean([row["below_10"] for row in drawn])),
        "paths": count,
        "kept": len(kept),
    }
    wanted = TABLES[table][1]
    found = np.array([row["found"] for row in kept]).reshape(len(kept), len(GRID), 2)
    for i, bound in enumerate((8, 10)):
        values = found[:, :, i].ravel()
        for name, at in (("low", 5), ("median", 50), ("high", 95)):
            line[f"below_{bound}_{name}"] = float(np.percentile(values, at)) if kept else None
        line[f"below_{bound}_paper"] = wanted[i]
        line[f"reach_paper_{bound}_percent"] = (
            100.0 * float((values >= wanted[i]).mean()) if kept else None
        )
    near = (np.abs(found - wanted).max(axis=2) <= NEAR) if kept else np.zeros((0, len(GRID)))
    line["near_percent"] = 100.0 * float(near.mean()) if kept else None
    some = int(near.any(axis=1).sum())
    low, high = intervals.share(some, len(kept))
    return line | {"paths_near": some, "paths_near_low": low, "paths_near_high": high}

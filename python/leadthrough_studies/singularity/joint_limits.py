"""Joint limits by the null space alone: the first contribution of Yang et al., tested on a Panda.

The secondary task of equation 6 pulls towards the middles of the joints' ranges; the paper says
that the method adheres to joint limits by it. `damped_least_squares` also clamps each step to the
limits, which the paper's equations do not; here the limits are ten times as wide about the same
middles, so that only the task keeps the joints inside.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from leadthrough.arm import Arm
from leadthrough.check import Float64Array
from leadthrough_studies import intervals
from leadthrough_studies.damped_least_squares import DampedLeastSquares, damped_inverse_kinematics
from leadthrough_studies.study import Row

_WIDER = 10.0
_CLOSE = 1e-4  # m and rad: a pose so near is reached
_STEPS = 2000


@dataclass(frozen=True)
class Case:
    """A way of solving a pose.

    Attributes:
        gain: of the secondary task, 1/s.
        oriented: whether the orientation is asked for; without it four joints are free.
        clamped: whether each step is clamped to the limits.
        centred: whether it starts in the middle of the ranges, instead of anywhere inside them.
    """

    gain: float
    oriented: bool = True
    clamped: bool = False
    centred: bool = False


CASES = {
    "poses, no task": Case(0.0),
    "poses, task": Case(0.5),
    "poses, task, centred": Case(0.5, centred=True),
    "positions, no task": Case(0.0, oriented=False),
    "positions, task": Case(0.5, oriented=False),
    "positions, no task, centred": Case(0.0, oriented=False, centred=True),
    "positions, task, centred": Case(0.5, oriented=False, centred=True),
    "poses, no task, clamp": Case(0.0, clamped=True),
    "poses, task, clamp": Case(0.5, clamped=True),
}


def ends(*, seed: int, poses: int) -> list[Row]:
    """A row for every case: poses reached, and those of them with all joints inside the limits."""
    arm, rng = Arm.load("panda"), np.random.default_rng(seed)
    lower, upper = arm.limits.lower, arm.limits.upper
    goals, starts = rng.uniform(lower, upper, (2, poses, len(lower)))
    free = Arm.load("panda", limits=_widened(arm))
    rows: list[Row] = []
    for name, case in CASES.items():
        q0 = 0.5 * (lower + upper) + (not case.centred) * (starts - 0.5 * (lower + upper))
        q, reached = _solved(arm if case.clamped else free, goals, q0, case)
        inside = ((q >= lower - 1e-9) & (q <= upper + 1e-9)).all(axis=1)
        rows.append({"case": name, "reached": reached.sum(), "inside": (reached & inside).sum()})
    solved = arm.inverse_kinematics_batch(*arm.forward_kinematics(goals), q0=starts).success.sum()
    rows.append({"case": "inverse_kinematics_batch", "reached": solved, "inside": solved})
    return [
        {"study": "joint limits", "seed": seed, "case": row["case"], "poses": poses}
        | {name: int(row[name]) for name in ("reached", "inside")}
        for row in rows
    ]


def _widened(arm: Arm) -> Any:
    """Limits about the same middles."""
    limits = arm.limits
    middle, half = 0.5 * (limits.upper + limits.lower), 0.5 * (limits.upper - limits.lower)
    return replace(limits, lower=middle - _WIDER * half, upper=middle + _WIDER * half)


def _solved(
    arm: Arm, goals: Float64Array, starts: Float64Array, case: Case
) -> tuple[Float64Array, Any]:
    """Configurations at the end, and whether each pose is reached."""
    positions, orientations = arm.forward_kinematics(goals)
    found = damped_inverse_kinematics(
        arm,
        positions,
        orientations if case.oriented else None,
        q0=starts,
        settings=DampedLeastSquares(nullspace_gain=case.gain),
        position_tolerance=_CLOSE,
        orientation_tolerance=_CLOSE,
        max_iterations=_STEPS,
    )
    return found.q, found.success


def table(rows: list[Row]) -> list[Row]:
    """A line for each case: percentages with 95 % intervals of all poses drawn."""
    lines = []
    for name in dict.fromkeys(row["case"] for row in rows):
        own = [row for row in rows if row["case"] == name]
        poses, reached, inside = (
            sum(row[key] for row in own) for key in ("poses", "reached", "inside")
        )
        line: Row = {"case": name, "poses": poses, "reached_percent": 100.0 * reached / poses}
        # Of those reached: a pose that is not reached says nothing about limits.
        line["inside_percent"] = 100.0 * inside / max(reached, 1)
        low, high = intervals.share(inside, reached)
        lines.append(line | {"inside_low": low, "inside_high": high})
    return lines

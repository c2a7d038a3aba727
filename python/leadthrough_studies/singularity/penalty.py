"""Alpha of equation 5 of Yang et al.: a larger one is said to slow the joints and convergence."""

from __future__ import annotations

from typing import Any

import numpy as np

from leadthrough.arm import Arm
from leadthrough.check import Float64Array
from leadthrough_studies import intervals
from leadthrough_studies.damped_least_squares import DampedLeastSquares, damped_inverse_kinematics
from leadthrough_studies.study import Row

ALPHAS = (0.0, 1e-3, 1e-2, 1e-1)
_AWAY = 0.3  # rad, by which each joint starts from a configuration that solves the pose
_CLOSE, _STEPS = 1e-4, 2000


def steps(*, seed: int, poses: int) -> list[Row]:
    """A row for every alpha: the first step of the fastest joint, and steps until each pose.

    The joints start near a solution, so that every alpha ends at the same one; poses that some
    alpha does not reach are left out.
    """
    arm, rng = Arm.load("panda"), np.random.default_rng(seed)
    lower, upper = arm.limits.lower + _AWAY, arm.limits.upper - _AWAY
    goals = rng.uniform(lower, upper, (poses, len(lower)))
    starts = goals + rng.uniform(-_AWAY, _AWAY, goals.shape)
    first = [np.abs(_solved(arm, goals, starts, alpha, 1).q - starts) for alpha in ALPHAS]
    whole = [_solved(arm, goals, starts, alpha, _STEPS) for alpha in ALPHAS]
    reached = np.all([each.success for each in whole], axis=0)
    return [
        {
            "study": "alpha",
            "seed": seed,
            "alpha": alpha,
            "first_step_rad": moved[reached].max(axis=1).tolist(),
            "steps": each.iterations[reached].tolist(),
        }
        for alpha, moved, each in zip(ALPHAS, first, whole, strict=True)
    ]


def table(rows: list[Row]) -> list[Row]:
    """A line for each alpha: medians over the poses with 95 % intervals."""
    lines = []
    for alpha in dict.fromkeys(row["alpha"] for row in rows):
        line: Row = {"alpha": alpha}
        for measure in ("first_step_rad", "steps"):
            values = [v for row in rows if row["alpha"] == alpha for v in row[measure]]
            found = intervals.median(values)
            line |= {"poses": len(values)}
            line |= {f"{measure}_{name}": value for name, value in found.items()}
        lines.append(line)
    return lines


def _solved(arm: Arm, goals: Float64Array, starts: Float64Array, alpha: float, most: int) -> Any:
    return damped_inverse_kinematics(
        arm,
        *arm.forward_kinematics(goals),
        q0=starts,
        settings=DampedLeastSquares(alpha=alpha),
        position_tolerance=_CLOSE,
        orientation_tolerance=_CLOSE,
        max_iterations=most,
    )

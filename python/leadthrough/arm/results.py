"""What inverse kinematics returns: always a configuration, with a verdict on it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array

# In the order of the core's codes.
STATUSES = ("converged", "unreachable", "limits", "budget")

# What the core returns: the fields of IkResult with codes for the status and, one bit a joint, for
# the joints that bar the way; and those of IkBatch.
Answer = tuple[Float64Array, int, float, float, int, int]
Columns = tuple[
    Float64Array,
    NDArray[np.int32],
    Float64Array,
    Float64Array,
    NDArray[np.int32],
    NDArray[np.bool_],
]


@dataclass(frozen=True, eq=False, slots=True)
class IkResult:
    """One solution, or the closest configuration found.

    q: (joints,) rad (m for prismatic joints), inside the limits. status: "converged";
    "unreachable", the target lies beyond the arm's length, or every attempt came to rest away from
    it; "limits", the same, but with joints pressed against limits that bar the way; "budget", the
    iterations or the CPU time were used up. position_error: m. orientation_error: rad; both over
    the axes that were asked for, 0 where there were none. limiting_joints: with "limits", those
    that bar the way.
    """

    q: Float64Array
    success: bool
    status: str
    position_error: float
    orientation_error: float
    iterations: int
    limiting_joints: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False, slots=True)
class IkBatch:
    """Solutions of many targets, one row each; the fields are those of IkResult.

    limiting_joints: (m, joints), true where a joint bars the way.
    """

    q: Float64Array
    success: NDArray[np.bool_]
    status: NDArray[np.str_]
    position_error: Float64Array
    orientation_error: Float64Array
    iterations: NDArray[np.int32]
    limiting_joints: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.q)

"""What inverse kinematics returns: always a configuration, with a verdict on it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array

# In the order of the core's codes.
STATUSES = ("converged", "unreachable", "stalled", "budget")


@dataclass(frozen=True, eq=False, slots=True)
class IkResult:
    """One solution, or the closest configuration found.

    q: (joints,) rad (m for prismatic joints), inside the limits. status: "converged";
    "unreachable", beyond the arm's length; "stalled", no attempt came to the target; "budget",
    the iterations were used up. position_error: m. orientation_error: rad, 0 where no orientation
    was asked for.
    """

    q: Float64Array
    success: bool
    status: str
    position_error: float
    orientation_error: float
    iterations: int


@dataclass(frozen=True, eq=False, slots=True)
class IkBatch:
    """Solutions of many targets, one row each; the fields are those of IkResult."""

    q: Float64Array
    success: NDArray[np.bool_]
    status: NDArray[np.str_]
    position_error: Float64Array
    orientation_error: Float64Array
    iterations: NDArray[np.int32]

    def __len__(self) -> int:
        return len(self.q)

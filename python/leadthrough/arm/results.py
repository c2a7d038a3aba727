"""What inverse kinematics returns: always a configuration, with a verdict on it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array
from leadthrough.repr import ShortRepr

IkStatus = Literal["converged", "unreachable", "limits", "budget"]
# In the order of the core's codes.
STATUSES: tuple[IkStatus, ...] = get_args(IkStatus)

# What the core returns: the fields of IkResult with codes for the status and, one bit per joint,
# for the joints that bar the way; and those of IkBatch.
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
class IkResult(ShortRepr):
    """One solution, or the closest configuration found.

    Attributes:
        q: configuration (joints,) in rad (m for prismatic joints), inside the limits.
        success: whether the status is "converged".
        status: "converged"; "unreachable", the target lies beyond the arm's length, or every
            attempt came to rest away from it; "limits", the same, but with joints pressed against
            limits that bar the way; "budget", the iterations or the CPU time were used up.
        position_error: distance from the target in m, without the axes left free.
        orientation_error: angle from the target in rad, without the axes left free; 0 if the whole
            orientation is free.
        iterations: how many were used, over all restarts.
        limiting_joints: with "limits", the joints that bar the way.
    """

    q: Float64Array
    success: bool
    status: IkStatus
    position_error: float
    orientation_error: float
    iterations: int
    limiting_joints: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False, slots=True)
class IkBatch(ShortRepr):
    """Solutions of many targets, one row per target; the fields mean what those of IkResult mean.

    Attributes:
        q: (m, joints).
        success: (m,).
        status: (m,).
        position_error: (m,) in m.
        orientation_error: (m,) in rad.
        iterations: (m,).
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


def one_result(joint_names: tuple[str, ...], answer: Answer) -> IkResult:
    """The core's answer to one target."""
    q, status, position_error, orientation_error, iterations, bits = answer
    barring: tuple[str, ...] = ()
    if bits:
        barring = tuple(name for i, name in enumerate(joint_names) if bits >> i & 1)
    return IkResult(
        q, status == 0, STATUSES[status], position_error, orientation_error, iterations, barring
    )


def batch_of_results(columns: Columns) -> IkBatch:
    """The core's answer to many targets."""
    q, codes, position_errors, orientation_errors, iterations, limiting = columns
    statuses = np.array(STATUSES)[codes]
    return IkBatch(
        q, codes == 0, statuses, position_errors, orientation_errors, iterations, limiting
    )


def first_of(joint_names: tuple[str, ...], batch: IkBatch) -> IkResult:
    """The first row of a batch as a result of its own."""
    barring = zip(joint_names, batch.limiting_joints[0], strict=True)
    return IkResult(
        batch.q[0],
        bool(batch.success[0]),
        STATUSES[STATUSES.index(batch.status[0])],
        float(batch.position_error[0]),
        float(batch.orientation_error[0]),
        int(batch.iterations[0]),
        tuple(name for name, bars in barring if bars),
    )

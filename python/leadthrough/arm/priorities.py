"""Strict priorities of tasks of one's own, given by their Jacobians."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import _core, check
from leadthrough.arm import magnitudes
from leadthrough.arm.task_stack import MOST_TASKS, SCHEMES, Scheme
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput

_LARGEST = 16  # rows and joints: the core's workspaces


def resolve(
    jacobians: Sequence[ArrayLike],
    wanted: Sequence[ArrayLike],
    *,
    lower: ArrayLike | None = None,
    upper: ArrayLike | None = None,
    scheme: Scheme = "siciliano-slotine",
) -> Float64Array:
    """The motion (joints,) that meets tasks in the order of their priority.

    Args:
        jacobians: of each task (rows, joints), the highest priority first; at most 12 tasks, 16
            rows and 16 joints.
        wanted: the motion that each task asks for, (rows,).
        lower: bounds (joints,) of the motion; none by default.
        upper: bounds (joints,) of the motion; none by default.
        scheme: as in `TaskStack`.

    Raises:
        InvalidInput: if the shapes don't fit each other, or a lower bound is above the upper one.
    """
    rows = _checked(jacobians)
    joints = rows[0].shape[1]
    if len(wanted) != len(rows):
        raise InvalidInput(
            f"wanted: expected {len(rows)} vectors, as many as jacobians, got {len(wanted)}"
        )
    goals = [
        magnitudes.values(goal, "wanted", shape=(len(jacobian),))
        for goal, jacobian in zip(wanted, rows, strict=True)
    ]
    low, high = _bound(lower, "lower", -np.inf, joints), _bound(upper, "upper", np.inf, joints)
    if (low > high).any():
        i = int(np.argmax(low > high))
        raise InvalidInput(
            f"lower: expected at most upper for joint {i}, got {low[i]} and {high[i]}"
        )
    reverse = check.choice(scheme, "scheme", SCHEMES) == "reverse"
    return _core.resolve_stack(rows, goals, low, high, reverse)


def _checked(jacobians: Sequence[ArrayLike]) -> list[Float64Array]:
    rows = [magnitudes.values(j, "jacobians", shape=("rows", "joints")) for j in jacobians]
    if not 0 < len(rows) <= MOST_TASKS:
        raise InvalidInput(f"jacobians: expected 1 to {MOST_TASKS} matrices, got {len(rows)}")
    joints = rows[0].shape[1]
    for jacobian in rows:
        if not 0 < max(jacobian.shape) <= _LARGEST or jacobian.shape[1] != joints:
            raise InvalidInput(
                f"jacobians: expected up to {_LARGEST} rows of {joints} joints (at most "
                f"{_LARGEST}), got {jacobian.shape}"
            )
    return rows


def _bound(value: ArrayLike | None, name: str, default: float, joints: int) -> Float64Array:
    if value is None:
        return np.full(joints, default)
    return magnitudes.values(value, name, shape=(joints,))

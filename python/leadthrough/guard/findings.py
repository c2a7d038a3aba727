"""What a chunk exceeds: the first joint and time of each limit."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array
from leadthrough.guard.admission import Kind, Reason
from leadthrough.guard.rules import HISTORY, Rules

_ROUNDING = 1e-9  # rad or m
_EXCESS = 1e-6
_JUMP = 3.0  # times its neighbours a step is longer that is a jump
_RATES: tuple[Kind, ...] = ("velocity", "acceleration", "jerk")


def not_finite(rows: Float64Array, names: tuple[str, ...], times: Float64Array) -> Reason | None:
    """The first number that is none."""
    at = _first(~np.isfinite(rows))
    return None if at is None else Reason("not finite", float(times[at[0]]), names[at[1]])


def exceeded(
    rules: Rules, history: Float64Array, rows: Float64Array, times: Float64Array
) -> tuple[Reason, ...]:
    """The first excess of each kind that rows have."""
    limits, period = rules.joints, rules.period
    names = limits.joint_names
    found: list[Reason] = []
    outside = (rows < limits.lower - _ROUNDING) | (rows > limits.upper + _ROUNDING)
    if (at := _first(outside)) is not None:
        found.append(Reason("position", float(times[at[0]]), names[at[1]], ratio=float(rows[at])))
    stream = np.concatenate([history, rows])
    jumped = slice(0)  # rows whose higher orders reach over a jump
    for order, kind in enumerate(_RATES, 1):
        used = np.abs(np.diff(stream, order, axis=0)[HISTORY - order :])
        ratio = used / (getattr(limits, kind) * period**order)
        over = ratio > 1.0 + _EXCESS
        over[jumped] = False
        if (at := _first(over)) is None:
            continue
        told: Kind = "jump" if kind == "velocity" and _is_jump(used, at) else kind
        if told == "jump":
            jumped = slice(at[0], at[0] + HISTORY)
        time, name = float(times[at[0]]), names[at[1]]
        found.append(Reason(told, time, name, ratio=float(ratio[at])))
    return tuple(found)


def _is_jump(steps: Float64Array, at: tuple[int, int]) -> bool:
    row, joint = at
    beside = [steps[i, joint] for i in (row - 1, row + 1) if 0 <= i < len(steps)]
    return bool(steps[row, joint] > _JUMP * max(beside, default=0.0))


def _first(wrong: NDArray[np.bool_]) -> tuple[int, int] | None:
    """The first row with something wrong in it, and the column."""
    rows = wrong.any(axis=1)
    if not rows.any():
        return None
    row = int(np.argmax(rows))
    return row, int(np.argmax(wrong[row]))

"""Joint positions from messages that may each name some of the joints, in any order."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.io.headers import Columns
from leadthrough.io.table import ArrayTable


def table(times: Float64Array, states: Sequence[Any], wanted: Columns | None) -> ArrayTable:
    """The joints wanted, or all if every message has the same ones, in the first one's order.

    times: (n,) s. states: n messages with `name`, `position` and `velocity`. Joints that come in
    different messages are read at the first one's times, between the others' samples.
    Raises InvalidInput.
    """
    groups = {frozenset(state.name): tuple(state.name) for state in states if state.name}
    if wanted is None and len(groups) != 1:
        listed = " | ".join(", ".join(group) for group in groups.values()) or "none"
        raise InvalidInput(
            f"columns: messages name different joints, {listed}; "
            "name the ones to read in columns['joints']"
        )
    joints = wanted or next(iter(groups.values()))
    _check_known(joints, groups)
    together = [i for i, state in enumerate(states) if set(joints) <= set(state.name)]
    if not together:
        return _merged(times, states, joints)
    positions = _matrix([states[i] for i in together], joints, "position")
    columns = {"time": times[together]} | dict(zip(joints, positions.T, strict=True))
    if all(len(states[i].velocity) == len(states[i].name) for i in together):
        velocities = _matrix([states[i] for i in together], joints, "velocity")
        if np.isfinite(velocities).all():
            columns |= {f"{name}_velocity": velocities[:, i] for i, name in enumerate(joints)}
    return ArrayTable(columns, roles={"time": ("time",), "joints": joints}, angles="radians")


def _check_known(joints: Columns, groups: dict[frozenset[str], Columns]) -> None:
    known = {name: None for group in groups.values() for name in group}
    missing = [joint for joint in joints if joint not in known]
    if missing:
        listed = ", ".join(known)
        raise InvalidInput(f"columns['joints']: no joint {missing[0]!r}; there are {listed}")


def _matrix(states: Sequence[Any], joints: Columns, field: str) -> Float64Array:
    rows = []
    for state in states:
        values = getattr(state, field)
        if len(values) != len(state.name):
            raise InvalidInput(f"expected a {field} for each of {state.name}, got {len(values)}")
        rows.append([values[state.name.index(joint)] for joint in joints])
    return np.array(rows, dtype=np.float64)


def _merged(times: Float64Array, states: Sequence[Any], joints: Columns) -> ArrayTable:
    series = []
    for joint in joints:
        rows = [i for i, state in enumerate(states) if joint in state.name]
        at, values = times[rows], _matrix([states[i] for i in rows], (joint,), "position")[:, 0]
        order = np.argsort(at, kind="stable")
        series.append((at[order], values[order]))
    first, last = max(at[0] for at, _ in series), min(at[-1] for at, _ in series)
    clock = series[0][0]
    clock = clock[(clock >= first) & (clock <= last)]
    if len(clock) == 0:
        raise InvalidInput(f"expected joints that move at the same time, got {', '.join(joints)}")
    columns = {joint: np.interp(clock, *own) for joint, own in zip(joints, series, strict=True)}
    return ArrayTable(
        {"time": clock, **columns}, roles={"time": ("time",), "joints": joints}, angles="radians"
    )

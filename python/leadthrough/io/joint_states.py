"""Joint positions from messages that may each name some of the joints, in any order."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.io.headers import Columns
from leadthrough.io.joint_columns import joint_columns
from leadthrough.io.table import ArrayTable


class JointState(Protocol):
    """A sensor_msgs/JointState."""

    name: Sequence[str]
    position: Sequence[float]
    velocity: Sequence[float]


def table(times: Float64Array, states: Sequence[JointState], wanted: Columns | None) -> ArrayTable:
    """The positions of joints, and their velocities where every message has them."""
    groups = {frozenset(state.name): tuple(state.name) for state in states if state.name}
    if wanted is None and len(groups) != 1:
        listed = " | ".join(", ".join(group) for group in groups.values()) or "none"
        raise InvalidInput(
            f"columns: the messages have different joints, {listed}; "
            "name the ones to read in columns['joints']"
        )
    joints = wanted or next(iter(groups.values()))
    _check_known(joints, groups)
    together = [i for i, state in enumerate(states) if set(joints) <= set(state.name)]
    if not together:
        return _merged(times, states, joints)
    whole = [states[i] for i in together]
    values = {"positions": _matrix(whole, joints, "position")}
    if all(len(state.velocity) == len(state.name) for state in whole):
        velocities = _matrix(whole, joints, "velocity")
        if np.isfinite(velocities).all():
            values["velocities"] = velocities
    return _table(times[together], joints, joint_columns(joints, values))


def _table(times: Float64Array, joints: Columns, columns: Mapping[str, Float64Array]) -> ArrayTable:
    roles = {"time": ("time",), "joints": joints}
    return ArrayTable({"time": times, **columns}, roles=roles, angles="radians")


def _check_known(joints: Columns, groups: dict[frozenset[str], Columns]) -> None:
    known = {name: None for group in groups.values() for name in group}
    missing = [joint for joint in joints if joint not in known]
    if missing:
        listed = ", ".join(known)
        raise InvalidInput(f"columns['joints']: no joint {missing[0]!r}; there are {listed}")


def _matrix(states: Sequence[JointState], joints: Columns, field: str) -> Float64Array:
    rows = []
    for state in states:
        values = getattr(state, field)
        if len(values) != len(state.name):
            raise InvalidInput(
                f"{field}: expected {len(state.name)} numbers, one for each of "
                f"{', '.join(state.name)}, got {len(values)}"
            )
        rows.append([values[state.name.index(joint)] for joint in joints])
    return np.array(rows, dtype=np.float64)


def _merged(times: Float64Array, states: Sequence[JointState], joints: Columns) -> ArrayTable:
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
        raise InvalidInput(
            f"columns['joints']: {', '.join(joints)} were not recorded at the same time; "
            "read them one by one"
        )
    columns = {joint: np.interp(clock, *own) for joint, own in zip(joints, series, strict=True)}
    return _table(clock, joints, columns)

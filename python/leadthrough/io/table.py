"""A recording as named columns, and the motion that chosen columns of it make."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.io import headers
from leadthrough.io.headers import Columns
from leadthrough.motion import JointTrajectory, Motion, PoseTrajectory, Trajectory

_ROLES = ("time", "positions", "orientations", "joints")


class Table(Protocol):
    """What a reader returns: columns that become numbers when they are asked for."""

    @property
    def names(self) -> Sequence[str]: ...

    def numbers(self, name: str) -> Float64Array:
        """The column (n,), or several columns at once (n, k). Raises InvalidInput."""
        ...


@dataclass(frozen=True, eq=False)
class ArrayTable:
    """Columns that are arrays already, one row a sample."""

    arrays: Mapping[str, Any]

    @property
    def names(self) -> Sequence[str]:
        return tuple(self.arrays)

    def numbers(self, name: str) -> Float64Array:
        value = self.arrays[name]
        flat = isinstance(value, np.ndarray) and value.ndim == 1
        return check.array(value, name, shape=("n",) if flat else ("n", "k"))


def named_columns(columns: Any) -> dict[str, Columns]:
    """The user's `columns`, checked, as a tuple of names for each part it names."""
    if columns is None:
        return {}
    if not isinstance(columns, Mapping):
        raise InvalidInput(f"columns: expected a mapping, got {type(columns).__name__}")
    for role in columns:
        check.choice(role, "columns", _ROLES)
    named = {role: _names(columns[role], f"columns[{role!r}]") for role in columns}
    if "joints" in named and ("positions" in named or "orientations" in named):
        raise InvalidInput("columns: expected poses or joints, got both")
    if len(named.get("time", ("t",))) != 1:
        raise InvalidInput(f"columns['time']: expected one name, got {len(named['time'])}")
    return named


def motion(table: Table, named: Mapping[str, Columns], rate: float | None) -> Motion:
    """The motion in the columns `named`; what is left out and needed is found by its name.

    Raises InvalidInput.
    """
    chosen = _complete(table.names, named)
    for role, names in chosen.items():
        for name in names:
            if name not in table.names:
                raise InvalidInput(
                    f"columns[{role!r}]: no column {name!r}; there are {_listed(table.names)}"
                )
    data = {role: _stacked(table, names) for role, names in chosen.items() if role != "time"}
    times = _times(table, chosen.get("time"), rate, len(next(iter(data.values()))))
    if "joints" in data:
        joint_names = chosen["joints"] if len(chosen["joints"]) == data["joints"].shape[1] else ()
        return JointTrajectory(times, data["joints"], joint_names=joint_names)
    if "orientations" in data:
        return PoseTrajectory(times, data["positions"], data["orientations"])
    return Trajectory(times, data["positions"])


def _names(value: Any, name: str) -> Columns:
    names = (value,) if isinstance(value, str) else value
    if not isinstance(names, Sequence) or not all(isinstance(item, str) for item in names):
        raise InvalidInput(f"{name}: expected column names, got {value!r}")
    if not names or len(set(names)) != len(names):
        raise InvalidInput(f"{name}: expected different names, at least one, got {value!r}")
    return tuple(names)


def _complete(names: Sequence[str], named: Mapping[str, Columns]) -> dict[str, Columns]:
    found = headers.candidates(names)
    chosen = dict(named)
    if not chosen.keys() & {"positions", "orientations", "joints"}:
        if found["positions"] and found["joints"]:
            raise InvalidInput(
                "columns: both poses and joints are there; name the ones to read, positions "
                f"({_choices(found['positions'])}) or joints ({_choices(found['joints'])})"
            )
        if not found["positions"] and not found["joints"]:
            raise InvalidInput(
                "columns: found neither positions nor joints by their names; "
                f"name them, there are {_listed(names)}"
            )
        wanted = ["joints"] if found["joints"] else ["positions", "orientations"]
        chosen |= {role: _only(found[role], role) for role in wanted if found[role]}
    elif "orientations" in chosen and "positions" not in chosen:
        chosen["positions"] = _only(found["positions"], "positions")
    if "time" not in chosen and found["time"]:
        chosen["time"] = _only(found["time"], "time")
    return chosen


def _only(found: Sequence[Columns], role: str) -> Columns:
    if len(found) == 1:
        return found[0]
    what = f"several fit, {_choices(found)}" if found else "found none by their names"
    raise InvalidInput(f"columns: {role}: {what}; name the right ones in columns[{role!r}]")


def _stacked(table: Table, names: Columns) -> Float64Array:
    parts = [table.numbers(name) for name in names]
    for name, part in zip(names, parts, strict=True):
        if len(part) != len(parts[0]):
            raise InvalidInput(
                f"{name}: expected as many samples as {names[0]}, {len(parts[0])}, got {len(part)}"
            )
    return np.column_stack(parts)


def _times(table: Table, time: Columns | None, rate: float | None, count: int) -> Float64Array:
    if time is None:
        if rate is None:
            raise InvalidInput("rate: needed where there is no time column; give it in Hz")
        return np.arange(count) / rate
    if rate is not None:
        raise InvalidInput(f"rate: there is a time column, {time[0]!r}; leave rate out")
    times = table.numbers(time[0])
    if times.shape != (count,):
        raise InvalidInput(
            f"{time[0]}: expected one time for each of {count} samples, got shape {times.shape}"
        )
    return times


def _choices(found: Sequence[Columns]) -> str:
    return " | ".join(", ".join(names) for names in found)


def _listed(names: Sequence[str], most: int = 40) -> str:
    return ", ".join(names[:most]) + (", ..." if len(names) > most else "")

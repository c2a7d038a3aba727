"""What a user says about a file, checked; all of it may be left out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from leadthrough import check
from leadthrough.errors import InvalidInput
from leadthrough.io.headers import Columns

ROLES = ("time", "positions", "orientations", "joints")
ORDERS = ("wxyz", "xyzw")
ANGLES = ("radians", "degrees")


@dataclass(frozen=True, eq=False)
class Request:
    """The arguments of `leadthrough.io.read_recordings`, which documents them."""

    columns: Mapping[str, Columns] = field(default_factory=dict)
    rate: float | None = None
    angles: str | None = None
    quaternions: str | None = None
    topic: str | None = None
    frames: tuple[str, str] | None = None


def checked(
    *, columns: Any, rate: Any, angles: Any, quaternions: Any, topic: Any, frames: Any
) -> Request:
    """The request that the arguments make. Raises InvalidInput."""
    if topic is not None and not isinstance(topic, str):
        raise InvalidInput(f"topic: expected a name, got {topic!r}")
    return Request(
        _columns(columns),
        None if rate is None else check.number(rate, "rate", above=0.0),
        None if angles is None else check.choice(angles, "angles", ANGLES),
        None if quaternions is None else check.choice(quaternions, "quaternions", ORDERS),
        topic,
        _frames(frames),
    )


def _columns(columns: Any) -> dict[str, Columns]:
    if columns is None:
        return {}
    if not isinstance(columns, Mapping):
        raise InvalidInput(f"columns: expected a mapping, got {type(columns).__name__}")
    for role in columns:
        check.choice(role, "columns", ROLES)
    named = {role: _names(columns[role], f"columns[{role!r}]") for role in columns}
    if "joints" in named and ("positions" in named or "orientations" in named):
        raise InvalidInput("columns: expected poses or joints, got both")
    if len(named.get("time", ("t",))) != 1:
        raise InvalidInput(f"columns['time']: expected one name, got {len(named['time'])}")
    return named


def _names(value: Any, name: str) -> Columns:
    names = (value,) if isinstance(value, str) else value
    if not isinstance(names, Sequence) or not all(isinstance(item, str) for item in names):
        raise InvalidInput(f"{name}: expected column names, got {value!r}")
    if not names or len(set(names)) != len(names):
        raise InvalidInput(f"{name}: expected different names, at least one, got {value!r}")
    return tuple(names)


def _frames(value: Any) -> tuple[str, str] | None:
    if value is None:
        return None
    if not isinstance(value, Sequence) or isinstance(value, str) or len(value) != 2:
        raise InvalidInput(f"frames: expected the names of a frame and of its child, got {value!r}")
    parent, child = value
    if not isinstance(parent, str) or not isinstance(child, str):
        raise InvalidInput(f"frames: expected two names, got {value!r}")
    return parent, child

"""A recording as named columns, as every reader returns it, and the request for one."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import get_args

import numpy as np

from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.io.headers import AngleUnit, Columns, QuaternionOrder
from leadthrough.motion import Events

# An arm's joints: their lower and upper limits, rad, and "m" behind those of prismatic ones, m.
Ranges = Mapping[str, tuple[float, float] | tuple[float, float, str]]
ROLES = ("time", "positions", "orientations", "joints")
ORDERS: tuple[QuaternionOrder, ...] = get_args(QuaternionOrder)
ANGLES: tuple[AngleUnit, ...] = get_args(AngleUnit)
_LETTERS = re.compile(r"[a-z]{0,2}")  # too short to tell a joint by


@dataclass(frozen=True, eq=False, kw_only=True)
class Table(ABC):
    """Columns that become numbers when they are asked for."""

    roles: Mapping[str, Columns] = field(default_factory=dict)
    label: str | None = None  # the recording's own name, where the format gives it one
    rate: float | None = None  # Hz, where the format states it and there is no time column
    quaternions: QuaternionOrder | None = None
    angles: AngleUnit | None = None  # unit of the joints, where the format fixes it
    extents: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    events: Events = ()  # on the table's clock

    @property
    @abstractmethod
    def names(self) -> Sequence[str]:
        """The names of the columns."""

    @abstractmethod
    def numbers(self, name: str) -> Float64Array:
        """A column (n,), or (n, k) where it holds k numbers per sample."""

    @abstractmethod
    def place(self, row: int) -> str:
        """Position of a sample in the file, for messages."""


@dataclass(frozen=True, eq=False)
class ArrayTable(Table):
    """Columns that are arrays already."""

    arrays: Mapping[str, object]

    @property
    def names(self) -> Sequence[str]:
        return tuple(self.arrays)

    def numbers(self, name: str) -> Float64Array:
        value = self.arrays[name]
        flat = isinstance(value, np.ndarray) and value.ndim == 1
        return check.with_gaps(value, name, shape=("n",) if flat else ("n", "k"))

    def place(self, row: int) -> str:
        return f"sample {row}"


@dataclass(frozen=True, eq=False)
class Request:
    """The arguments of `leadthrough.io.read_recordings`, which documents them."""

    columns: Mapping[str, Columns] = field(default_factory=dict)
    rate: float | None = None
    angles: AngleUnit | None = None
    quaternions: QuaternionOrder | None = None
    topic: str | None = None
    frames: tuple[str, str] | None = None
    joints: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    prismatic: Sequence[str] = ()  # those of the joints that are in m
    part: tuple[int, int] | None = None


def joints_told(columns: Sequence[str], joints: Sequence[str]) -> list[int | None]:
    """For each column the joint that its name alone tells, as `Elbow` does elbow_joint."""
    own, arm = ([re.sub(r"[\W_]", "", n.lower()) for n in each] for each in (columns, joints))
    near = [[i for i, name in enumerate(arm) if each in name or name in each] for each in own]
    found = [
        each[0] if len(each) == 1 and not _LETTERS.fullmatch(name) else None
        for each, name in zip(near, own, strict=True)
    ]
    return [i if found.count(i) == 1 else None for i in found]


def as_request(
    columns: object = None,
    rate: object = None,
    angles: object = None,
    quaternions: object = None,
    topic: object = None,
    *,
    frames: object = None,
    joints: object = None,
) -> Request:
    """The request that the arguments of `leadthrough.io.read_recordings` make."""
    if topic is not None and not isinstance(topic, str):
        raise InvalidInput(f"topic: expected a topic's name, got {topic!r}")
    return Request(
        _columns(columns),
        None if rate is None else check.number(rate, "rate", above=0.0),
        None if angles is None else check.choice(angles, "angles", ANGLES),
        None if quaternions is None else check.choice(quaternions, "quaternions", ORDERS),
        topic,
        _frames(frames),
        *_joints(joints),
    )


def _columns(columns: object) -> dict[str, Columns]:
    if columns is None:
        return {}
    if not isinstance(columns, Mapping):
        raise InvalidInput(f"columns: expected a mapping, got {type(columns).__name__}")
    for role in columns:
        check.choice(role, "columns", ROLES)
    named = {role: _names(columns[role], f"columns[{role!r}]") for role in columns}
    if "joints" in named and ("positions" in named or "orientations" in named):
        raise InvalidInput("columns: expected either poses or joints, got both")
    if len(named.get("time", ("t",))) > 2:
        raise InvalidInput(f"columns['time']: expected one or two names, got {len(named['time'])}")
    return named


def _names(value: object, name: str) -> Columns:
    names = (value,) if isinstance(value, str) else value
    if not isinstance(names, Sequence) or not all(isinstance(item, str) for item in names):
        raise InvalidInput(f"{name}: expected names of columns, got {value!r}")
    if not names or len(set(names)) != len(names):
        raise InvalidInput(f"{name}: expected at least one name, each only once, got {value!r}")
    return tuple(names)


def _joints(value: object) -> tuple[dict[str, tuple[float, float]], Sequence[str]]:
    """The limits of joints, and the names of those that are in m."""
    if value is None:
        return {}, ()
    if not isinstance(value, Mapping) or not all(isinstance(name, str) for name in value):
        raise InvalidInput(f"joints: expected a mapping of names to limits, got {value!r}")
    ranges: dict[str, tuple[float, float]] = {}
    metres = [n for n, each in value.items() if isinstance(each, tuple) and each[2:] == ("m",)]
    for name, limits in value.items():
        pair = np.asarray(limits[:2] if name in metres else limits, dtype=float)
        if pair.shape != (2,) or not pair[0] <= pair[1]:
            raise InvalidInput(
                f"joints[{name!r}]: expected (lower, upper) with lower <= upper, got {limits}"
            )
        ranges[name] = (float(pair[0]), float(pair[1]))
    return ranges, metres


def _frames(value: object) -> tuple[str, str] | None:
    match value:
        case None:
            return None
        case [str(parent), str(child)]:
            return parent, child
    raise InvalidInput(f"frames: expected the names of a frame and its child frame, got {value!r}")

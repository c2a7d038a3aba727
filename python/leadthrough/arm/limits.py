"""Joint limits: what a URDF states, completed by a TOML file.

    robot = "ur3"
    [sources]     # one text a quantity: who states it, or "assumed: ..." and why
    velocity = "the maker's data sheet"
    [joints]
    shoulder_pan_joint = { velocity = 3.14, acceleration = 10.0, jerk = 100.0 }

A joint's lower, upper, velocity and effort override the URDF's, and what joints that mimic it leave
of its range as well; a URDF has no acceleration or jerk.
"""

from __future__ import annotations

import json
import tomllib
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput

_BOUNDS = ("lower", "upper")
_RATES = ("velocity", "effort", "acceleration", "jerk")


@dataclass(frozen=True, eq=False)
class JointLimits:
    """Limits of an arm's joints, one value a joint; infinite where there is none.

    lower, upper: rad (m for prismatic joints). velocity, acceleration, jerk: rad/s, rad/s^2,
    rad/s^3 (m). effort: N m (N). acceleration and jerk are None where they are not known.
    Raises InvalidInput.
    """

    joint_names: tuple[str, ...]
    lower: Float64Array
    upper: Float64Array
    velocity: Float64Array
    acceleration: Float64Array | None = None
    jerk: Float64Array | None = None
    effort: Float64Array | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "joint_names", tuple(self.joint_names))
        for name in _BOUNDS + _RATES:
            if getattr(self, name) is not None:
                object.__setattr__(self, name, _values(self, name))
        crossed = self.lower > self.upper
        if crossed.any():
            i = int(np.argmax(crossed))
            raise InvalidInput(
                f"lower: expected at most upper for {self.joint_names[i]!r}, "
                f"got {self.lower[i]} and {self.upper[i]}"
            )

    def without(self, names: Collection[str]) -> JointLimits:
        """The limits of the other joints."""
        kept = [i for i, name in enumerate(self.joint_names) if name not in names]
        columns = {name: getattr(self, name) for name in _BOUNDS + _RATES}
        rest: dict[str, Any] = {
            name: None if column is None else column[kept] for name, column in columns.items()
        }
        return JointLimits(tuple(self.joint_names[i] for i in kept), **rest)

    def template(self) -> str:
        """A limits file for `Arm.from_urdf`, to be completed where it has a question mark."""
        lines = [
            "# rad/s, rad/s^2, rad/s^3 (m); bounds and effort override the URDF's.",
            "[joints]",
        ]
        for i, name in enumerate(self.joint_names):
            values = {key: getattr(self, key) for key in ("velocity", "acceleration", "jerk")}
            row = ", ".join(
                f"{key} = {'?' if column is None else _toml_number(column[i])}"
                for key, column in values.items()
            )
            lines.append(f"{json.dumps(name, ensure_ascii=False)} = {{ {row} }}")
        return "\n".join(lines) + "\n"


def read_limits(path: Any, urdf: JointLimits, *, other_joints: Collection[str] = ()) -> JointLimits:
    """`urdf` overridden and completed by the TOML file at `path`.

    other_joints: joints of the robot outside the arm, that the file may speak of as well.
    Raises InvalidInput.
    """
    document = _load(path)
    joints = _table(document, "joints", path)
    known = set(urdf.joint_names) | set(other_joints)
    unknown = sorted(set(joints) - known)
    if unknown:
        names = ", ".join(urdf.joint_names)
        raise InvalidInput(f"{path}: unknown joint {unknown[0]!r}; the arm's joints are {names}")
    rows = {name: _row(joints, name, path) for name in joints if name in urdf.joint_names}
    changes: dict[str, Any] = {key: _column(urdf, key, rows, path) for key in _BOUNDS + _RATES}
    try:
        return replace(urdf, **changes)
    except InvalidInput as error:
        raise InvalidInput(f"{path}: {error}") from None


def _toml_number(value: float) -> str:
    return repr(float(value)) if np.isfinite(value) else "?"


def _values(limits: JointLimits, name: str) -> Float64Array:
    count = len(limits.joint_names)
    try:
        values = np.array(getattr(limits, name), dtype=np.float64)
    except (TypeError, ValueError):
        raise InvalidInput(f"{name}: expected {count} numbers") from None
    if values.shape != (count,):
        raise InvalidInput(f"{name}: expected shape ({count},), got {values.shape}")
    wrong = np.isnan(values) | ((values < 0) & (name in _RATES))
    if wrong.any():
        i = int(np.argmax(wrong))
        wanted = "a number that is not negative" if name in _RATES else "a number"
        raise InvalidInput(
            f"{name}: expected {wanted} for {limits.joint_names[i]!r}, got {values[i]}"
        )
    values.setflags(write=False)
    return values


def _load(path: Any) -> dict[str, Any]:
    try:
        document = tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, TypeError) as error:
        raise InvalidInput(f"limits: cannot read {path!r}: {error}") from None
    except tomllib.TOMLDecodeError as error:
        raise InvalidInput(f"{path}: not a TOML document: {error}") from None
    unknown = sorted(set(document) - {"robot", "sources", "joints"})
    if unknown:
        raise InvalidInput(f"{path}: expected robot, [sources] and [joints], got {unknown[0]!r}")
    return document


def _table(document: Mapping[str, Any], name: str, path: Any) -> dict[str, Any]:
    table = document.get(name, {})
    if not isinstance(table, dict) or not table:
        raise InvalidInput(f"{path}: expected a table [{name}]")
    return table


def _row(joints: Mapping[str, Any], name: str, path: Any) -> dict[str, float]:
    row = _table(joints, name, path)
    unknown = sorted(set(row) - set(_BOUNDS + _RATES))
    if unknown:
        keys = ", ".join(_BOUNDS + _RATES)
        raise InvalidInput(f"{path}: {name}: expected {keys}, got {unknown[0]!r}")
    return {
        key: check.number(value, f"{path}: {name}: {key}", at_least=0.0 if key in _RATES else None)
        for key, value in row.items()
    }


def _column(
    urdf: JointLimits, key: str, rows: Mapping[str, Mapping[str, float]], path: Any
) -> Float64Array | None:
    given = {name: row[key] for name, row in rows.items() if key in row}
    stated = getattr(urdf, key)
    if not given or stated is None:
        missing = [name for name in urdf.joint_names if name not in given]
        if given and missing:
            raise InvalidInput(f"{path}: {missing[0]}: expected {key}, as for the other joints")
        return np.array([given[name] for name in urdf.joint_names]) if given else stated
    return np.array(
        [given.get(name, value) for name, value in zip(urdf.joint_names, stated, strict=True)]
    )

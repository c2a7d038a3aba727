"""Joint limits of a URDF, completed by a TOML file.

    robot = "ur3"
    [sources]     # for each quantity who states it, or "assumed: ..." and why
    velocity = "the manufacturer's data sheet"
    [joints]
    shoulder_pan_joint = { velocity = 3.14, acceleration = 10.0, jerk = 100.0 }

A joint's lower, upper, velocity and effort override the URDF's, and also the narrower range that
joints that mimic it may leave it. A URDF has no acceleration or jerk.
"""

from __future__ import annotations

import json
import tomllib
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput, LimitsInfeasible, ShortRepr

_MAX_FILE = 2**20  # bytes
COLUMNS = ("lower", "upper", "velocity", "acceleration", "jerk", "effort")
_BOUNDS = ("lower", "upper")
_RATES = ("velocity", "effort", "acceleration", "jerk")
_SPEEDS = ("velocity", "acceleration", "jerk")


@dataclass(frozen=True, eq=False, init=False)
class JointLimits(ShortRepr):
    """Limits of an arm's joints, one value per joint; infinite if unlimited.

    Attributes:
        joint_names: names of the joints.
        lower: (joints,) in rad (m for prismatic joints).
        upper: (joints,) in rad (m).
        velocity: (joints,) in rad/s (m/s), >= 0.
        acceleration: (joints,) in rad/s^2 (m/s^2), >= 0; None if not known.
        jerk: (joints,) in rad/s^3 (m/s^3), >= 0; None if not known.
        effort: (joints,) in N m (N), >= 0; None if not known.
    """

    joint_names: tuple[str, ...]
    lower: Float64Array
    upper: Float64Array
    velocity: Float64Array
    acceleration: Float64Array | None
    jerk: Float64Array | None
    effort: Float64Array | None

    def __init__(  # noqa: PLR0917  # the fields, in their order
        self,
        joint_names: Iterable[str],
        lower: ArrayLike,
        upper: ArrayLike,
        velocity: ArrayLike,
        acceleration: ArrayLike | None = None,
        jerk: ArrayLike | None = None,
        effort: ArrayLike | None = None,
    ) -> None:
        names = tuple(joint_names)
        columns = lower, upper, velocity, acceleration, jerk, effort
        vars(self).update(joint_names=names)
        for key, column in zip(COLUMNS, columns, strict=True):
            vars(self)[key] = None if column is None else _values(names, column, key)
        crossed = self.lower > self.upper
        if crossed.any():
            i = int(np.argmax(crossed))
            raise check.refused(
                "lower", f"at most upper for {names[i]!r}", f"{self.lower[i]} and {self.upper[i]}"
            )

    def without(self, names: Collection[str]) -> JointLimits:
        """The limits of the other joints.

        Args:
            names: of the joints to leave out.
        """
        rest = [i for i, name in enumerate(self.joint_names) if name not in names]
        columns = {name: getattr(self, name) for name in COLUMNS}
        values: dict[str, Any] = {
            name: None if column is None else column[rest] for name, column in columns.items()
        }
        return JointLimits(tuple(self.joint_names[i] for i in rest), **values)

    def template(self) -> str:
        """The text of a limits file for `Arm.from_urdf`, with ? for each value to fill in."""
        lines = [
            "# rad/s, rad/s^2, rad/s^3 (m); bounds, velocity and effort override the URDF's.",
            "[joints]",
        ]
        for i, name in enumerate(self.joint_names):
            # The URDF states a velocity that is known.
            unstated = () if np.isfinite(self.velocity[i]) else ("velocity",)
            keys = (*unstated, "acceleration", "jerk")
            known = [
                np.nan if getattr(self, key) is None else getattr(self, key)[i] for key in keys
            ]
            texts = [repr(float(value)) if np.isfinite(value) else "?" for value in known]
            row = ", ".join(f"{key} = {text}" for key, text in zip(keys, texts, strict=True))
            lines.append(f"{json.dumps(name, ensure_ascii=False)} = {{ {row} }}")
        return "\n".join(lines) + "\n"


def known_acceleration(limits: JointLimits) -> Float64Array:
    """The acceleration limits (joints,), infinite where they are not known."""
    if limits.acceleration is None:
        return np.full(len(limits.joint_names), np.inf)
    return limits.acceleration


def known_rates(limits: JointLimits) -> tuple[Float64Array, Float64Array, Float64Array]:
    """Limits of velocity, acceleration and jerk (joints,), where all are known to be there."""
    assert limits.acceleration is not None
    assert limits.jerk is not None
    return limits.velocity, limits.acceleration, limits.jerk


def zeros(limits: JointLimits) -> dict[str, list[str]]:
    """The joints that cannot move, or move nothing, by limits of zero, and these limits' names."""
    columns = {key: getattr(limits, key) for key in _RATES} | {"range": limits.upper - limits.lower}
    known = {key: column for key, column in columns.items() if column is not None}
    at_zero = {
        name: [key for key, column in known.items() if column[i] == 0.0]
        for i, name in enumerate(limits.joint_names)
    }
    return {name: keys for name, keys in at_zero.items() if keys}


def refuse_zeros(limits: JointLimits, moves: NDArray[np.bool_]) -> None:
    """Refuses a path on which joints move whose velocity, acceleration or jerk must be zero."""
    rates = {name: [key for key in keys if key in _SPEEDS] for name, keys in zeros(limits).items()}
    stuck = [name for name, moved in zip(limits.joint_names, moves, strict=True) if moved]
    found = {name: rates[name] for name in stuck if rates.get(name)}
    if found:
        listed = ", ".join(f"{name} ({', '.join(keys)})" for name, keys in found.items())
        raise LimitsInfeasible(
            f"limits of 0 of joints that move along the path: {listed}; put the maker's values "
            "into the limits file",
            joint=next(iter(found)),
        )


def margins(lower: Float64Array, upper: Float64Array, q: Float64Array) -> Float64Array:
    """The least distance (n,) of a joint to a limit as a fraction of its range; 0.5 at most."""
    bounded = np.isfinite(lower) & np.isfinite(upper) & (lower < upper)
    lower, upper, q = lower[bounded], upper[bounded], q[:, bounded]
    fractions = np.minimum(q - lower, upper - q) / (upper - lower)
    return np.asarray(fractions.min(axis=1, initial=0.5))


def read_limits(
    path: str | PathLike[str], urdf: JointLimits, *, other_joints: Collection[str] = ()
) -> JointLimits:
    """The URDF's limits, overridden and completed by a TOML file.

    Args:
        path: of the TOML file; `JointLimits.template` shows its form.
        urdf: the limits that the URDF states.
        other_joints: names of joints outside the arm that the file may list as well.

    Raises:
        InvalidInput: if the file cannot be read, names an unknown joint or quantity, or states an
            acceleration or jerk for some of the arm's joints only.
    """
    document = _load(path)
    joints = _table(document, "joints", path)
    check.instance(urdf, "urdf", JointLimits)
    known = set(urdf.joint_names) | set(other_joints)
    unknown = sorted(set(joints) - known)
    if unknown:
        names = ", ".join(urdf.joint_names)
        raise InvalidInput(f"{path}: unknown joint {unknown[0]!r}; the arm's joints are {names}")
    rows = {name: _row(joints, name, path) for name in joints if name in urdf.joint_names}
    changes: dict[str, Any] = {key: _column(urdf, key, rows, path) for key in _BOUNDS + _RATES}
    with check.prefixed(path):
        return replace(urdf, **changes)


def _values(names: tuple[str, ...], column: ArrayLike, key: str) -> Float64Array:
    """A read-only copy (joints,) of one limit; infinite where there is none."""
    count = len(names)
    values = check.with_gaps(column, key, shape=(count,)).copy()
    wrong = np.isnan(values) | ((values < 0) & (key in _RATES))
    if wrong.any():
        i = int(np.argmax(wrong))
        wanted = "a number >= 0" if key in _RATES else "a number"
        raise InvalidInput(f"{key}: expected {wanted} for {names[i]!r}, got {values[i]}")
    return check.freeze(values)


def _load(path: str | PathLike[str]) -> dict[str, Any]:
    try:
        with Path(path).open("rb") as file:
            content = str(file.read(_MAX_FILE + 1), "utf-8")
    except (OSError, ValueError, TypeError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InvalidInput(f"limits: cannot read {path} ({reason})") from None
    if len(content) > _MAX_FILE:
        raise InvalidInput(f"limits: expected at most {_MAX_FILE:,} bytes, {path} has more")
    try:
        document = tomllib.loads(content)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise InvalidInput(f"{path}: not a TOML document: {error}") from None
    unknown = sorted(set(document) - {"robot", "sources", "joints"})
    if unknown:
        raise InvalidInput(
            f"{path}: expected robot, [sources] and [joints] only, got {unknown[0]!r}"
        )
    return document


def _table(document: Mapping[str, Any], name: str, path: str | PathLike[str]) -> dict[str, Any]:
    table = document.get(name, {})
    if not isinstance(table, dict) or not table:
        raise InvalidInput(f"{path}: expected a table [{name}], got {table!r}")
    return table


def _row(joints: Mapping[str, Any], name: str, path: str | PathLike[str]) -> dict[str, float]:
    row = _table(joints, name, path)
    unknown = sorted(set(row) - set(_BOUNDS + _RATES))
    if unknown:
        keys = ", ".join(_BOUNDS + _RATES)
        raise InvalidInput(f"{path}: {name}: expected one of {keys}, got {unknown[0]!r}")
    return {
        key: check.number(value, f"{path}: {name}: {key}", at_least=0.0 if key in _RATES else None)
        for key, value in row.items()
    }


def _column(
    urdf: JointLimits, key: str, rows: Mapping[str, Mapping[str, float]], path: str | PathLike[str]
) -> Float64Array | None:
    given = {name: row[key] for name, row in rows.items() if key in row}
    stated = getattr(urdf, key)
    if not given or stated is None:
        missing = [name for name in urdf.joint_names if name not in given]
        if given and missing:
            raise InvalidInput(
                f"{path}: {missing[0]}: expected {key}, as for the other joints, got none"
            )
        return np.array([given[name] for name in urdf.joint_names]) if given else stated
    return np.array(
        [given.get(name, value) for name, value in zip(urdf.joint_names, stated, strict=True)]
    )


def checked_values(values: Mapping[str, float]) -> Mapping[str, float]:
    """A read-only copy of values by the joints' names."""
    if not isinstance(values, Mapping):
        raise check.refused("locked_joints", "a mapping from joints' names to values", repr(values))
    for name in values:
        if not isinstance(name, str):
            raise InvalidInput(f"locked_joints: expected a joint's name, got {name!r}")
    return MappingProxyType(
        {name: check.number(value, f"locked_joints: {name}") for name, value in values.items()}
    )


def require_inside(values: Mapping[str, float], limits: JointLimits) -> None:
    bounds = zip(limits.joint_names, limits.lower, limits.upper, strict=True)
    for name, lower, upper in bounds:
        if name in values and not lower <= values[name] <= upper:
            raise InvalidInput(
                f"locked_joints: {name}: expected a value inside its limits {lower:.6g} to "
                f"{upper:.6g}, got {values[name]:.6g}"
            )
    if set(limits.joint_names) <= set(values):
        raise InvalidInput("locked_joints: expected at least one joint of the arm not to be locked")


def require_unlocked(values: Collection[str], locked: Mapping[str, float]) -> None:
    """Check that none of the joints is locked already."""
    for name in values:
        if name in locked:
            raise InvalidInput(
                f"locked_joints: {name}: expected a joint that is not locked, but it is locked at "
                f"{locked[name]}"
            )

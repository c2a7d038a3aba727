"""Recordings as they stand in files, and how columns become one."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.events import Events
from leadthrough.io import headers
from leadthrough.io.headers import Columns
from leadthrough.io.request import Request
from leadthrough.io.table import Table
from leadthrough.motion import Demonstration, JointTrajectory, Motion, PoseTrajectory, Trajectory

# No arm stays more than two turns from zero for half of a recording; degrees do.
_FARTHEST_ANGLE = 4.0 * math.pi
_DEGREE = math.pi / 180.0


@dataclass(frozen=True, eq=False)
class Recording:
    """One recorded motion, faults and all: `leadthrough.preprocess.clean` makes the best of it.

    times: (n,) s, in the order of the file. positions: (n, d) m, or joints in rad. Any of them
    may be NaN or infinite. orientations: (n, 4) w, x, y, z, of any length and sign, or None.
    joint_names: None where the positions are not joints, empty where joints have no names.
    velocities, accelerations: (n, joints) or None. events: on the same clock. name: the file's.
    """

    times: Float64Array
    positions: Float64Array
    orientations: Float64Array | None = None
    joint_names: tuple[str, ...] | None = None
    velocities: Float64Array | None = None
    accelerations: Float64Array | None = None
    events: Events = ()
    name: str = ""

    def __post_init__(self) -> None:
        count = len(check.with_gaps(self.times, "times", shape=("n",)))
        width: int | str = "d"
        for field in ("times", "positions", "orientations", "velocities", "accelerations"):
            value = getattr(self, field)
            if value is None and field not in ("times", "positions"):
                continue
            shape = {"times": (count,), "orientations": (count, 4)}.get(field, (count, width))
            array = check.with_gaps(value, field, shape=shape).copy()
            array.setflags(write=False)
            object.__setattr__(self, field, array)
            width = array.shape[1] if field == "positions" else width

    @property
    def kind(self) -> str:
        """What moves: "joints", "poses" or "points"."""
        if self.joint_names is not None:
            return "joints"
        return "points" if self.orientations is None else "poses"

    def motion(self) -> Motion:
        """The motion, if nothing is wrong with it. Raises InvalidInput."""
        if self.joint_names is not None:
            return JointTrajectory(
                self.times,
                self.positions,
                self.velocities,
                self.accelerations,
                self.joint_names,
                self.events,
            )
        if self.orientations is not None:
            return PoseTrajectory(self.times, self.positions, self.orientations, self.events)
        return Trajectory(self.times, self.positions, self.events)


def recording_of(demonstration: Demonstration) -> Recording:
    """The recording that a demonstration would be read from."""
    motion = demonstration.motion
    if isinstance(motion, JointTrajectory):
        return Recording(
            motion.times,
            motion.positions,
            joint_names=motion.joint_names,
            velocities=motion.velocities,
            accelerations=motion.accelerations,
            events=motion.events,
            name=demonstration.name,
        )
    turned = motion.orientations if isinstance(motion, PoseTrajectory) else None
    return Recording(
        motion.times, motion.positions, turned, events=motion.events, name=demonstration.name
    )


def recording(table: Table, request: Request, *, name: str = "") -> Recording:
    """The recording in the columns asked for; what is left out and needed is found by its name.

    Raises InvalidInput.
    """
    chosen = _chosen(table, request.columns)
    for role, names in chosen.items():
        for column in names:
            if column not in table.names:
                raise InvalidInput(
                    f"columns[{role!r}]: no column {column!r}; there are {_listed(table.names)}"
                )
    data = {
        role: _stacked(table, names, role, request.angles or table.angles)
        for role, names in chosen.items()
        if role != "time"
    }
    times = _times(table, chosen.get("time"), request.rate, len(next(iter(data.values()))))
    if "joints" in data:
        _check_angles(chosen["joints"], data["joints"], request.angles or table.angles)
        return Recording(
            times,
            data["joints"],
            joint_names=_joint_names(chosen["joints"], data["joints"]),
            velocities=data.get("velocities"),
            accelerations=data.get("accelerations"),
            events=table.events,
            name=name,
        )
    turned = data.get("orientations")
    if turned is not None:
        if turned.shape[1] != 4:
            raise InvalidInput(f"orientations: expected shape (n, 4), got {turned.shape}")
        order = _order(table, chosen["orientations"], request)
        turned = turned[:, [order.index(axis) for axis in "wxyz"]]
    return Recording(times, data["positions"], turned, events=table.events, name=name)


def check_complete(table: Table, request: Request) -> None:
    """Raises InvalidInput for the first cell that holds no finite number, and says where."""
    for names in _chosen(table, request.columns).values():
        for name in names:
            values = table.numbers(name)
            wrong = np.argwhere(~np.isfinite(values))
            if len(wrong):
                raise InvalidInput(
                    f"{table.place(int(wrong[0, 0]))}, column {name!r}: expected a finite number, "
                    f"got {values[tuple(wrong[0])]}; `leadthrough clean` (io.read_recordings and "
                    "preprocess.clean) leaves such samples out"
                )


def _chosen(table: Table, named: Mapping[str, Columns]) -> dict[str, Columns]:
    names = table.names
    found = headers.candidates(names) | {role: [own] for role, own in table.roles.items()}
    chosen = dict(named)
    if not chosen.keys() & {"positions", "orientations", "joints"}:
        chosen |= _only_motion(names, found)
    elif "orientations" in chosen and "positions" not in chosen:
        chosen["positions"] = _only(found["positions"], "positions")
    if "time" not in chosen and found["time"]:
        chosen["time"] = _only(found["time"], "time")
    joints = chosen.get("joints", ())
    if all(headers.unit(name, "joints")[1] is None for name in joints):
        chosen |= headers.derivatives(names, joints) if joints else {}
    return chosen


def _only_motion(names: Sequence[str], found: Mapping[str, list[Columns]]) -> dict[str, Columns]:
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
    return {role: _only(found[role], role) for role in wanted if found[role]}


def _only(found: Sequence[Columns], role: str) -> Columns:
    if len(found) == 1:
        return found[0]
    what = f"several fit, {_choices(found)}" if found else "found none by their names"
    raise InvalidInput(f"columns: {role}: {what}; name the right ones in columns[{role!r}]")


def _stacked(table: Table, names: Columns, role: str, angles: str | None) -> Float64Array:
    parts = [table.numbers(name) * _factor(name, role, angles) for name in names]
    for name, part in zip(names, parts, strict=True):
        if len(part) != len(parts[0]):
            raise InvalidInput(
                f"{name}: expected as many samples as {names[0]}, {len(parts[0])}, got {len(part)}"
            )
    return np.column_stack(parts)


def _factor(name: str, role: str, angles: str | None) -> float:
    stated = headers.unit(name, role)[1]
    if stated is not None:
        return stated
    is_angle = role in ("joints", "velocities", "accelerations")
    return _DEGREE if is_angle and angles == "degrees" else 1.0


def _times(table: Table, time: Columns | None, asked: float | None, count: int) -> Float64Array:
    if time is None:
        rate = asked or table.rate
        if rate is None:
            raise InvalidInput("rate: needed where there is no time column; give it in Hz")
        return np.arange(count) / rate
    if asked is not None:
        raise InvalidInput(f"rate: there is a time column, {time[0]!r}; leave rate out")
    times = table.numbers(time[0]) * (headers.unit(time[0], "time")[1] or 1.0)
    if times.shape != (count,):
        raise InvalidInput(
            f"{time[0]}: expected one time for each of {count} samples, got shape {times.shape}"
        )
    return times


def _joint_names(columns: Columns, positions: Float64Array) -> tuple[str, ...]:
    if len(columns) != positions.shape[1] or headers.is_whole(columns[0]):
        return ()
    return tuple(headers.unit(name, "joints")[0] for name in columns)


def _check_angles(columns: Columns, positions: Float64Array, angles: str | None) -> None:
    stated = [headers.unit(name, "joints")[1] is not None for name in columns]
    if angles is not None or all(stated) or len(positions) == 0:
        return
    # NaN compares as nothing: a joint counts where half of its samples are far away.
    far = np.count_nonzero(np.abs(positions) > _FARTHEST_ANGLE, axis=0) > 0.5 * len(positions)
    if far.any():
        seen = float(np.nanmax(np.abs(positions[:, far])))
        raise InvalidInput(
            f"angles: joints reach {seen:.6g}, more than two turns in radians; say "
            "angles='degrees' or angles='radians'"
        )


def _order(table: Table, columns: Columns, request: Request) -> str:
    order = headers.quaternion_order(columns) or request.quaternions
    if order is None and len(columns) == 1:
        order = table.quaternions
    if order is None:
        raise InvalidInput(
            f"quaternions: nothing says the order of {', '.join(columns)}; say "
            "quaternions='wxyz' or quaternions='xyzw'"
        )
    return order


def _choices(found: Sequence[Columns]) -> str:
    return " | ".join(", ".join(names) for names in found)


def _listed(names: Sequence[str], most: int = 40) -> str:
    return ", ".join(names[:most]) + (", ..." if len(names) > most else "")

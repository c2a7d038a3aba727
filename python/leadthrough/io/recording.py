"""Recordings as they stand in files, faults included, of the columns of tables of any format.

The unit of joints is stated by the user, the format or a column's name, or is the only one that
fits. LeRobot's data sets name their joints and not the unit, which is degrees or percent of the
joint's range: from -100 at its lower limit to 100 at its upper one, or from 0 to 100 for a gripper.
Only degrees go beyond 100; only percent stop at it.

Columns named `<joint>_recorded` are the arm's joints, rad (m), while the tip moved as recorded; an
arm that follows the motion keeps close to them.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from leadthrough import check, sanity
from leadthrough.check import Float64Array, InvalidInput, ShortRepr
from leadthrough.io import guesses, headers
from leadthrough.io.headers import AngleUnit, Columns
from leadthrough.io.joint_trajectory import checked_joint_names
from leadthrough.io.table import Request, Table, joints_told
from leadthrough.motion import (
    Demonstration,
    Event,
    Events,
    JointTrajectory,
    Motion,
    PoseTrajectory,
    Trajectory,
    joints_with,
)


@dataclass(frozen=True, eq=False, init=False)
class Recording(ShortRepr):
    """One recorded motion with its faults, which `leadthrough.preprocess.clean` removes.

    Times, positions, orientations and derivatives may hold NaN and infinity.

    Attributes:
        times: (n,) s, in the order of the file.
        positions: (n, d) m, or joint positions in rad (m for prismatic joints).
        orientations: (n, 4) w, x, y, z, of any length and sign, or None.
        joint_names: None where the positions are not joints, empty where the joints have no names.
        velocities: (n, joints) rad/s, or None.
        accelerations: (n, joints) rad/s^2, or None.
        joints: of the arm whose tip moved so, n samples in the same order, or None.
        events: on the same clock.
        name: of the recording; for messages and demonstrations.
    """

    times: Float64Array
    positions: Float64Array
    orientations: Float64Array | None
    joint_names: tuple[str, ...] | None
    velocities: Float64Array | None
    accelerations: Float64Array | None
    joints: JointTrajectory | None
    events: Events
    name: str

    def __init__(
        self,
        times: ArrayLike,
        positions: ArrayLike,
        orientations: ArrayLike | None = None,
        *,
        joint_names: Sequence[str] | None = None,
        velocities: ArrayLike | None = None,
        accelerations: ArrayLike | None = None,
        joints: JointTrajectory | None = None,
        events: Sequence[Event] = (),
        name: str = "",
    ) -> None:
        clock = _frozen(times, "times", ("n",))
        rows = _frozen(positions, "positions", (len(clock), "d"))
        given = (
            ("orientations", orientations, (len(clock), 4)),
            ("velocities", velocities, rows.shape),
            ("accelerations", accelerations, rows.shape),
        )
        vars(self).update(
            {
                field: None if value is None else _frozen(value, field, shape)
                for field, value, shape in given
            },
            times=clock,
            positions=rows,
            joint_names=None if joint_names is None else tuple(joint_names),
            joints=joints,
            events=tuple(events),
            name=name,
        )

    @property
    def kind(self) -> Literal["joints", "poses", "points"]:
        """Kind of the positions."""
        if self.joint_names is not None:
            return "joints"
        return "points" if self.orientations is None else "poses"

    def motion(self) -> Motion:
        """The recording as a motion, as it is; joints that leap by whole turns are continuous.

        Raises:
            InvalidInput: if anything is wrong with it; `leadthrough.preprocess.clean` repairs it.
        """
        if self.joint_names is not None:
            rows = sanity.continuous(self.positions, self.joint_names)
            rates = self.velocities, self.accelerations
            return JointTrajectory(self.times, rows, *rates, self.joint_names, self.events)
        if self.orientations is not None:
            rest = (self.orientations, self.events, self.joints)
            return PoseTrajectory(self.times, self.positions, *rest)
        return Trajectory(self.times, self.positions, self.events, self.joints)


def recording_of(demonstration: Demonstration) -> Recording:
    """The recording with a demonstration's motion and name."""
    motion = demonstration.motion
    optional = ("orientations", "joint_names", "velocities", "accelerations", "joints")
    return Recording(
        motion.times,
        motion.positions,
        **{name: getattr(motion, name, None) for name in optional},
        events=motion.events,
        name=demonstration.name,
    )


def _frozen(value: ArrayLike, name: str, shape: Sequence[int | str]) -> Float64Array:
    return check.freeze(check.with_gaps(value, name, shape=shape).copy())


# No arm stays more than two turns from zero for half of a recording; degrees do.
_MAX_ANGLE = 4.0 * math.pi
# Joints come this much beyond their limits by the slack of a calibration, rad; percent by rounding.
_SLACK = 0.1
_MAX_PERCENT, _END = 100.01, 1e-4
CLEANED = "; `leadthrough clean` leaves it out, in Python io.read_recordings and preprocess.clean"
_SPACE = 3  # coordinates of a position
# Steps of a recording that make sure of its largest, and the leap that is none of a motion's.
_RECORDED, _LEAP = 20, 3.0
_HELD = 4  # times as many equal rows as usual are a sensor's that waits
_MILLISECOND = 1e6  # ns: a clock that never gets so far beyond its seconds counts other parts
_SUFFIX = "_recorded"


def recording(table: Table, request: Request = Request(), *, name: str = "") -> Recording:  # noqa: B008 (frozen)
    """The recording in a table, from the columns asked for or else found by their names."""
    chosen = _chosen(table, request)
    _check_there(table, chosen)
    angles = unit_of(table, chosen.get("joints", ()), request)
    data = {
        role: _stacked(table, names, role, angles, request)
        for role, names in chosen.items()
        if role != "time"
    }
    times = _times(table, chosen.get("time"), request.rate, len(next(iter(data.values()))))
    if "joints" in data:
        refuse_far(chosen["joints"], data["joints"], angles)
        names = _joint_names(chosen["joints"], data["joints"], request)
        if angles == "degrees":
            _back_to_metres(data, chosen["joints"], names, request)
        return Recording(
            times,
            data["joints"],
            joint_names=names,
            velocities=data.get("velocities"),
            accelerations=data.get("accelerations"),
            events=table.events,
            name=name,
        )
    orientations = data.get("orientations")
    if orientations is not None:
        orientations = _quaternions(table, chosen["orientations"], orientations, request)
    elif rotated := headers.unread_orientations(
        table.names, beside=chosen["positions"] if request.columns else None
    ):
        sanity.warn(
            f"columns: {', '.join(rotated)} are left out; orientations are read as quaternions, "
            "such as qw, qx, qy, qz"
        )
    if orientations is None:
        sanity.pose(data["positions"], "save positions (n, 3) and orientations (n, 4) apart")
    if data["positions"].shape[1] > _SPACE and not request.columns:
        named = guesses.words("joints", chosen["positions"])
        sanity.warn(
            f"columns: {data['positions'].shape[1]} numbers are read as a point; joints by {named}"
        )
    return Recording(
        times,
        data["positions"],
        orientations,
        joints=demonstrated_joints(table, times),
        events=table.events,
        name=name,
    )


def lost(positions: Float64Array) -> NDArray[np.bool_]:
    """Rows (n,) of a motion (n, d) that a sensor without its target writes: zeros, or the last."""
    zero = np.asarray((positions == 0.0).all(axis=1))
    steps = np.abs(np.diff(positions, axis=0))
    largest = steps.max(axis=1, initial=0.0)[~(zero[1:] | zero[:-1])]
    if len(largest) < _RECORDED or positions.shape[1] < _SPACE:  # a gripper opens at once
        return np.zeros_like(zero)
    far = zero.any() and np.abs(positions[~zero]).max(axis=1).min() > _LEAP * largest.max()
    return zero & bool(far) | _held(steps)


def _held(steps: Float64Array) -> NDArray[np.bool_]:
    """Rows (n,) equal to the one before until a leap; from the steps (n - 1, d) between rows."""
    held = np.zeros(len(steps) + 1, dtype=np.bool_)
    moves = np.flatnonzero(steps.any(axis=1))
    if len(moves) < _RECORDED:
        return held
    waits = np.diff(moves, prepend=-1)
    if steps.shape[1] == _SPACE:
        steps = steps.max(axis=1, keepdims=True)
    long = waits > _HELD * np.median(waits)
    usual = steps[moves[~long]].max(axis=0)
    leaps = (steps[moves[long]] > _LEAP * usual).sum(axis=1) >= min(_SPACE, steps.shape[1])
    for move, wait in zip(moves[long][leaps], waits[long][leaps], strict=True):
        held[move - wait + 2 : move + 1] = True
    return held


def check_complete(table: Table, request: Request) -> None:
    """Refuses a table with a missing number, and says where it is."""
    for names in _chosen(table, request).values():
        for name in names:
            values = table.numbers(name)
            wrong = np.argwhere(~np.isfinite(values))
            if len(wrong):
                raise InvalidInput(
                    f"{table.place(int(wrong[0, 0]))}, column {name!r}: expected a finite number, "
                    f"got {values[tuple(wrong[0])]}{CLEANED}"
                )


def _check_there(table: Table, chosen: Mapping[str, Columns]) -> None:
    for role, names in chosen.items():
        for column in names:
            if column not in table.names:
                raise InvalidInput(
                    f"columns[{role!r}]: no column {column!r}; there are {_listed(table.names)}"
                    f"{guesses.nearest(table, role, names)}"
                )


def _chosen(table: Table, request: Request) -> dict[str, Columns]:
    names = table.names
    named = {role: _matching(asked, names) for role, asked in request.columns.items()}
    found = headers.candidates(names) | {role: [own] for role, own in table.roles.items()}
    joints = {*table.roles.get("joints", ())}  # of a gantry they may be x, y and z
    found["positions"] = [each for each in found["positions"] if not joints >= {*each}]
    chosen = dict(named)
    if not chosen.keys() & {"positions", "orientations", "joints"}:
        chosen |= _of_the_arm(names, request.joints) or _only_motion(table, found, request)
    elif "orientations" in chosen and "positions" not in chosen:
        chosen["positions"] = _only(found["positions"], "positions")
    # A rate stands in for a clock of text, such as 12:30:01.
    used = {*chain(*chosen.values())}
    times = [c for c in found["time"] if not used & {*c}]
    if request.rate:
        times = [each for each in times if guesses.numbers_of(table, each[0]) is not None]
    if "time" not in chosen and times:
        chosen["time"] = _only(times, "time")
    own = chosen.get("joints", ())
    if all(headers.unit(name, "joints")[1] is None for name in own):
        chosen |= headers.derivatives(names, own) if own else {}
    return chosen


def _of_the_arm(names: Sequence[str], joints: Iterable[str]) -> dict[str, Columns]:
    """The columns named as the arm's joints, in the arm's order, if all are there."""
    known, groups = tuple(joints), headers.by_joint(names)
    found = [tuple(by[joint] for joint in known) for by in groups if by.keys() >= {*known}]
    return {"joints": _only(found, "joints")} if known and found else {}


def _matching(asked: Columns, names: Sequence[str]) -> Columns:
    """The columns asked for; of a pattern such as joint_* those that fit, without derivatives."""
    chosen: list[str] = []
    for name in asked:
        if name in names or not set("*?") & set(name):
            chosen.append(name)
            continue
        pattern = re.escape(name).replace(r"\*", ".*").replace(r"\?", ".")
        fitting = [each for each in names if re.fullmatch(pattern, each)]
        chosen += [each for each in fitting if not _is_derived(each, fitting)] or [name]
    return tuple(dict.fromkeys(chosen))


def _is_derived(name: str, names: Sequence[str]) -> bool:
    """Whether a column is the velocity, acceleration or recording of another."""
    suffixes = [suffix for suffix in (*headers.JOINT_SUFFIXES.values(), _SUFFIX) if suffix]
    return any(name.endswith(end) and name.removesuffix(end) in names for end in suffixes)


def _only_motion(
    table: Table, found: Mapping[str, list[Columns]], request: Request
) -> dict[str, Columns]:
    if found["positions"] and found["joints"]:
        raise InvalidInput(
            "columns: the file has both poses and joints; name the ones to read, positions "
            f"({_choices(found['positions'])}) or joints ({_choices(found['joints'])})"
            f"{guesses.proposal(table, request)}"
        )
    if not found["positions"] and not found["joints"]:
        raise InvalidInput(
            "columns: no names of positions or joints found; name the columns to read, there are "
            f"{_listed(table.names)}{guesses.proposal(table, request)}"
        )
    if both := _of_two_arms(found["joints"]):
        return {"joints": both}
    wanted = ["joints"] if found["joints"] else ["positions", "orientations"]
    chosen = {role: _only(found[role], role) for role in wanted if found[role]}
    _check_body(chosen)
    return chosen


def _check_body(chosen: Mapping[str, Columns]) -> None:
    """Refuses a position and an orientation of two bodies by their columns' names."""
    bodies = [headers.owner(columns) for columns in chosen.values()]
    if len({*bodies}) < 2:
        return
    named = " ".join(guesses.words(role, columns) for role, columns in chosen.items())
    if all(bodies):
        raise InvalidInput(
            f"columns: the position is of {bodies[0]}, the orientation of {bodies[1]}; name the "
            f"columns to read, such as {named}"
        )
    sanity.warn(f"columns: taken for one pose: {named}; name those to read if it is none")


def _of_two_arms(found: Sequence[Columns]) -> Columns:
    """The joints of the left arm, then those of the right one; none of any other arms."""
    arms = {side: [c for c in found if c[0].lower().startswith(side)] for side in headers.SIDES}
    if len(found) != len(arms) or any(len(each) != 1 for each in arms.values()):
        return ()
    return tuple(name for (columns,) in arms.values() for name in columns)


def _only(found: Sequence[Columns], role: str) -> Columns:
    if len(found) == 1:
        return found[0]
    what = f"several fit, {_choices(found)}" if found else "none found by their names"
    such = f", such as {guesses.words(role, found[0])}" if found else ""
    raise InvalidInput(f"columns: {role}: {what}; name the right ones in columns[{role!r}]{such}")


def _stacked(
    table: Table, names: Columns, role: str, angles: AngleUnit | None, request: Request
) -> Float64Array:
    parts = [_in_si(table, name, role, angles, request) for name in names]
    for name, part in zip(names, parts, strict=True):
        if len(part) != len(parts[0]):
            raise check.refused(name, f"as many samples as {names[0]}, {len(parts[0])}", len(part))
    # One array of all may be vast; it is copied once, into the recording.
    return parts[0] if len(parts) == 1 and parts[0].ndim == 2 else np.column_stack(parts)


def _in_si(
    table: Table, name: str, role: str, angles: AngleUnit | None, request: Request
) -> Float64Array:
    numbers = table.numbers(name)
    if role in ("joints", "velocities", "accelerations"):
        unit = None if angles == "percent" and role != "joints" else angles
        return in_radians(name, numbers, unit, request)
    factor = headers.unit(name, role)[1] or 1.0
    return numbers if factor == 1.0 else numbers * factor


def _times(table: Table, time: Columns | None, asked: float | None, count: int) -> Float64Array:
    if time is None:
        rate = asked or table.rate
        if rate is None:
            rising = guesses.rising(table)
            named = f", or its column, as by {guesses.words('time', rising[:1])}" if rising else ""
            raise InvalidInput(
                "rate: the file has no time column; give the rate in Hz, such as rate=100" + named
            )
        return np.arange(count) / rate
    if asked is not None:
        raise InvalidInput(f"rate: the file has a time column, {time[0]!r}; leave rate out")
    stamps = table.numbers(time[0])
    unit = headers.unit(time[0], "time")[1] or headers.unit_since_1970(
        stamps[np.isfinite(stamps)][:1].sum()
    )
    times = stamps * unit
    if time[1:]:
        beyond = table.numbers(time[1]) % 1e9  # some hold the seconds too
        if 0.0 < (most := beyond.max(initial=0.0)) < _MILLISECOND:
            raise check.refused(time[1], "nanoseconds beyond the seconds", f"{most:g} at most")
        times = np.floor(times) + 1e-9 * beyond
    if times.shape != (count,):
        raise check.refused(time[0], f"one time for each of {count} samples", f"{times.shape}")
    return times


def _joint_names(columns: Columns, positions: Float64Array, request: Request) -> tuple[str, ...]:
    if len(columns) != positions.shape[1] or headers.is_whole(columns[0]):
        return ()
    own = tuple(headers.joint(name) for name in columns)
    if request.joints and set(own) <= set(request.joints):
        return own
    if request.columns.get("joints") and (stated := _joints_stated(own, tuple(request.joints))):
        return stated
    return tuple(headers.unit(name, "joints")[0] for name in columns)


def _joints_stated(columns: Columns, joints: Columns) -> Columns:
    """The joints that names tell, of each another one; or all in their order."""
    told = joints_told(columns, joints)
    known = [i for i in told if i is not None]
    if sorted(known) == [*range(len(columns))]:
        return tuple(joints[i] for i in known)
    if len(columns) != len(joints) or set(columns) & set(joints):
        return ()
    for place, i in enumerate(told):
        if i not in (None, place):
            raise InvalidInput(
                f"columns['joints']: {columns[place]} stands for {joints[place]}; name the columns "
                f"in the order {', '.join(joints)}"
            )
    return joints


def _back_to_metres(
    data: Mapping[str, Float64Array], columns: Columns, names: Sequence[str], request: Request
) -> None:
    """Undoes the conversion from degrees of prismatic joints whose columns state no unit."""
    of = names or tuple(request.joints)  # joints without names are the arm's, in its order
    for i, joint in enumerate(of[: data["joints"].shape[1]]):
        column = columns[i if names else 0]
        if joint in request.prismatic and headers.unit(column, "joints")[1] is None:
            for rows in data.values():
                rows[:, i] /= headers.DEGREE


def _order(table: Table, columns: Columns, request: Request) -> str:
    order: str | None = headers.quaternion_order(columns) or request.quaternions
    if order is None and len(columns) == 1:
        order = table.quaternions
    if order is None:
        raise InvalidInput(
            f"quaternions: the order of the numbers in {', '.join(columns)} is not stated; set "
            "quaternions='wxyz' or quaternions='xyzw'"
        )
    return order


def _quaternions(
    table: Table, columns: Columns, numbers: Float64Array, request: Request
) -> Float64Array:
    """The quaternions (n, 4) in w, x, y, z order."""
    if numbers.shape[1] != 4:
        raise InvalidInput(f"orientations: expected shape (n, 4), got {numbers.shape}")
    order = _order(table, columns, request)
    return numbers[:, [order.index(axis) for axis in "wxyz"]]


def _choices(found: Sequence[Columns]) -> str:
    return " | ".join(", ".join(names) for names in found)


def _listed(names: Sequence[str], most: int = 40) -> str:
    return (", ".join(names[:most]) or "none") + (", ..." if len(names) > most else "")


def unit_of(table: Table, columns: Columns, request: Request) -> AngleUnit | None:
    """The unit of a table's joints; None for radians, or where each column states its own."""
    stated = request.angles or table.angles
    if stated == "percent" and not {headers.joint(name) for name in columns} <= set(request.joints):
        raise InvalidInput(
            "angles: percent refer to the limits of an arm's joints, which are not known; name the "
            "arm (--robot); in Python, set joints"
        )
    if stated is not None or all(headers.unit(name, "joints")[1] is not None for name in columns):
        return stated
    extents = {name: table.extents[name] for name in columns if name in table.extents}
    arm = {name: extent for name, extent in extents.items() if not is_gripper(name)}
    if any(np.abs(extent).max() > _MAX_ANGLE for extent in arm.values()):
        return _only_fitting(arm, request)
    return None


def in_radians(
    name: str, numbers: Float64Array, unit: AngleUnit | None, request: Request
) -> Float64Array:
    """A joint's numbers in rad; where the column's name states a unit, that one counts."""
    stated = headers.unit(name, "joints")[1]
    if stated is not None:
        return numbers * stated
    if unit == "percent":
        lower, upper = request.joints[joint := headers.joint(name)]
        if not math.isfinite(upper - lower):
            raise InvalidInput(f"angles: percent are of a joint's range, and {joint} has no limits")
        least = 0.0 if is_gripper(name) else -100.0
        return np.asarray(lower + (numbers - least) / (100.0 - least) * (upper - lower))
    return numbers * (headers.DEGREE if unit == "degrees" else 1.0)


def is_gripper(name: str) -> bool:
    """Whether a column is that of a gripper."""
    return "gripper" in name.lower()


def refuse_far(columns: Columns, positions: Float64Array, unit: AngleUnit | None) -> None:
    """Refuses joints that stay more than two turns from zero, while no unit is stated."""
    stated = [headers.unit(name, "joints")[1] is not None for name in columns]
    if unit is not None or all(stated) or len(positions) == 0:
        return
    # NaN is greater than nothing: a joint counts where half of its samples are far away.
    far = np.count_nonzero(np.abs(positions) > _MAX_ANGLE, axis=0) > 0.5 * len(positions)
    if far.any():
        seen = float(np.nanmax(np.abs(positions[:, far])))
        raise InvalidInput(
            f"angles: joints reach {seen:.6g}, more than two turns in radians; set "
            "angles='degrees' or angles='radians'"
        )


def _only_fitting(extents: Mapping[str, tuple[float, float]], request: Request) -> AngleUnit:
    """Degrees or percent, whichever the extents of joints can be, if not both."""
    largest = max(float(np.abs(extent).max()) for extent in extents.values())
    if largest > _MAX_PERCENT:
        return "degrees"
    if abs(largest - 100.0) < _END:
        return "percent"
    for name, extent in extents.items():
        lower, upper = request.joints.get(headers.joint(name), (-math.inf, math.inf))
        least, most = headers.DEGREE * np.asarray(extent)
        if least < lower - _SLACK or most > upper + _SLACK:
            return "percent"
    raise InvalidInput(
        f"angles: the data set does not say whether its joints, which reach {largest:.6g}, are in "
        "degrees or in percent of their range, and both fit; set angles='degrees' or "
        "angles='percent'"
    )


def demonstrated_columns(motion: Motion) -> dict[str, Float64Array]:
    """A column (n,) for each of the joints; none where there are none, or none with names."""
    joints = joints_with(motion)
    if joints is None or not joints.joint_names:
        return {}
    names = checked_joint_names(joints)
    return {f"{name}{_SUFFIX}": joints.positions[:, i] for i, name in enumerate(names)}


def demonstrated_joints(table: Table, times: Float64Array) -> JointTrajectory | None:
    """The joints in a table, None where there are none or not at every time."""
    names = [name for name in table.names if name.endswith(_SUFFIX) and name != _SUFFIX]
    if not names:
        return None
    try:
        rows = np.column_stack([table.numbers(name) for name in names])
        joints = tuple(name.removesuffix(_SUFFIX) for name in names)
        return JointTrajectory(times, rows, joint_names=joints)
    except (InvalidInput, ValueError):  # faulty, as times of a recording may be too
        return None

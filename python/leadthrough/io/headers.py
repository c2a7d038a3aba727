"""Contents of a recording's columns, identified by their names in either case.

- Time: `time`, `times`, `t`, `timestamp`, `stamp`, also behind `%` or `_` (`__time`); or whole
  seconds and the nanoseconds beyond them (`secs` and `nsecs`, `stamp.sec` and `stamp.nanosec`).
- Positions: `x`, `y` and, where there is one, `z`, alone or after `p`, `pos`, `position` or
  `translation` (`px`, `pos_x`, `position.x`, `current_pos_x`), or `left` or `right` (`left_x`).
- Orientations: `w`, `x`, `y`, `z`, alone or after `q`, `quat`, `quaternion`, `orientation`,
  `rotation`, `rot`, `ori` or `o` (`qw`, `orientation_w`, `current_orientation_w`).
- Joints: `joint`, `j`, `q` or `q_d` with a number (`joint_1`, `panda_joint1`, `q0`, `q[0]`), or
  `joint` with a letter and a number (`joint_a1`), in the order of the numbers, which start at 0 or
  1 without a gap; names that end in `_joint` (`shoulder_pan_joint`), in the order of the file; or,
  where more names have a velocity and there are no positions, all that do (`lift`,
  `lift_velocity`); or Yaskawa's `S`, `L`, `U`, `R`, `B`, `T`
  and `E`.
  Their derivatives are `<joint>_velocity` or `d<joint>`, and `<joint>_acceleration` or `dd<joint>`.
  Numbered joints of two arms, whose names begin with `left` and `right`, are one recording.
- Arrays that hold all components at once: `positions`, `position`, `pos`; `orientations`,
  `orientation`, `quaternions`, `quaternion`, `quat`, which may state their order (`quat_xyzw`);
  `joints`, `joint_positions`, with `velocities` and `accelerations`.

A name may end in its unit (`time_ns`, `joint_1_deg`, `x [mm]`, `t (ms)`); without one the unit is
that of SI, but for times since 1970, whose number of digits tells s, ms, us and ns apart.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from typing import Literal

Columns = tuple[str, ...]
AngleUnit = Literal["radians", "degrees", "percent"]
QuaternionOrder = Literal["wxyz", "xyzw"]

# Names of two arms' columns begin so: left_x, right_joint_1.
SIDES = ("left", "right")
# Suffixes of a joint's columns.
JOINT_SUFFIXES = {"positions": "", "velocities": "_velocity", "accelerations": "_acceleration"}

_TIME = {"time", "times", "t", "timestamp", "stamp"}
_NANO = re.compile(r"n(ano)?(?=(secs?|seconds)$)", re.IGNORECASE)
_POSITION = {"p", "pos", "position", "translation"}
_ORIENTATION = {"q", "quat", "quaternion", "orientation", "rotation", "rot", "ori", "o"}
_WHOLE = {
    "positions": {"positions", "position", "pos"},
    "orientations": {"orientations", "orientation", "quaternions", "quaternion", "quat"},
    "joints": {"joints", "joint_positions"},
}
_PREFIXES = {"velocities": "d", "accelerations": "dd"}
_ORDERED = re.compile(r"(?P<name>.*?)[_.\-/ ]?(?P<order>wxyz|xyzw)", re.IGNORECASE)
_COMPONENT = re.compile(r"(?P<part>.*?)[_.\-/ ]?(?P<axis>[wxyz])")
_NUMBERED_JOINT = re.compile(
    r"(?P<arm>(.*[_.\-/ ])?((joint|j|q_d|q|joint_positions)[_.\-/ ]?|joint[_.\-/ ][a-z]))"
    r"(?P<open>\[)?(?P<number>[0-9]{1,4})(?(open)\])"
)
# Words of columns: not of joints' positions, hardly of measured ones, certainly of these. A joint
# may be named by one of the first (`cart_joint`).
OTHER = re.compile(
    r"(?i)(^|[_.\-/ ])(velocit(y|ies)|vel|speed|qd|qd?dot|d?dq|effort|torque|tau|acceleration|acc"
    r"|accel|jerk|force|moment|wrench|twist|temperature|voltage|error|pose|tcp|cart|cartesian|o_t_ee"
    r"|quat|v|[vwf][xyz]|stamp|seq|n?secs?|nanosec)([_.\-/ \d\[](?!joint$)|$)"
)
_SECOND = re.compile(
    r"(^|[_.\-/ ])(current|target|desired|cmd|command(ed)?|ref(erence)?|setpoint)([_.\-/ ]|$)"
)
_MEASURED = re.compile(
    r"(?i)^/?((joint_states|actual|measured|positions?|pos)[_.\-/ ])+|([_.\-/ ](positions?|pos))$"
)
_NAMED_JOINT = re.compile(r"(?!robot\d+_joint$).+_joint")  # robot0_joint_pos has all
_WITH_UNIT = re.compile(
    r"(?P<plain>.+?)(?:[_ ]?\[(?P<a>[a-z°]+)\]|[_ ]?\((?P<b>[a-z°]+)\)|[_ ](?P<c>[a-z]+))",
    re.IGNORECASE,
)
# Orientations of any kind; those that are read as quaternions are found before.
_ROTATED = re.compile(
    r"(.*[_.\-/ ])?([rqno][xyz]|q[ijkr]|r\d\d|roll|pitch|yaw|r|theta|axis[_.\-/ ][xyz]"
    r"|(euler|rot|rotation|rotvec|ori|orientation|quat|quaternion)([_.\-/ ].*)?)"
)
# Names of three angles.
_ANGLES = ("abc", "wpr", "ijk", ("alpha", "beta", "gamma"))
# Axes of a Yaskawa arm, in their order; an arm of seven has E too.
_AXES, _ALL_AXES = "slurbt", "sleurbt"
DEGREE = math.pi / 180.0
_UNITS: dict[str, dict[str, float]] = {
    "time": dict.fromkeys(("s", "sec", "seconds"), 1.0)
    | dict.fromkeys(("ms", "msec", "millis", "milliseconds"), 1e-3)
    | dict.fromkeys(("us", "usec", "micros", "microseconds"), 1e-6)
    | {"ns": 1e-9},
    "positions": {"m": 1.0, "cm": 1e-2, "mm": 1e-3},
    "joints": {"mm": 1e-3, "rad": 1.0, "radians": 1.0, "mrad": 1e-3}
    | dict.fromkeys(("deg", "degree", "degrees", "°"), DEGREE),
}
# Of columns that are no motion's.
_MORE_UNITS = {"-", "rad/s", "deg/s", "°/s", "m/s", "mm/s", "n", "nm", "n m", "a", "v", "hz"}


def unit(name: str, role: str) -> tuple[str, float | None]:
    """A column's name without its unit, and the factor from that unit to SI."""
    match = _WITH_UNIT.fullmatch(name)
    if match is None:
        return name, None
    factor = _UNITS.get(role, {}).get((match["a"] or match["b"] or match["c"]).lower())
    return (name, None) if factor is None else (match["plain"], factor)


def is_unit(text: str) -> bool:
    """Whether a cell of a header is a unit, of whatever column, and no name."""
    plain = text.strip("[]()").lower()
    return plain in _MORE_UNITS or any(plain in units for units in _UNITS.values())


def joint(name: str) -> str:
    """The joint's own name in that of its column, without a unit or words such as "position"."""
    plain = unit(name, "joints")[0]
    return _MEASURED.sub("", plain) or plain


def is_whole(name: str) -> bool:
    """Whether a name is that of an array of all joints."""
    return name.lower() in _WHOLE["joints"]


def quaternion_order(names: Columns) -> str | None:
    """The order of a quaternion's components, such as "xyzw", if the columns' names state it."""
    if len(names) == 1:
        match = _ORDERED.fullmatch(names[0])
        return match["order"].lower() if match else None
    axes = "".join(name[-1:].lower() for name in names)
    return axes if sorted(axes) == sorted("wxyz") else None


def candidates(names: Sequence[str]) -> dict[str, list[Columns]]:
    """Every choice of columns for each of time, positions, orientations and joints."""
    found: dict[str, list[Columns]] = {
        "time": _clocks(names),
        **{
            role: [(name,) for name in names if _whole(name, role).lower() in whole]
            for role, whole in _WHOLE.items()
        },
    }
    plain = {unit(name, "joints")[0].lower(): name for name in names}
    fanuc = {*"wpr"} <= plain.keys()
    for part, axes in _components(names).items():
        last_word = re.split(r"[_.\-/ ]", part)[-1]
        if (last_word in _ORIENTATION or not (part or fanuc)) and len(axes) == 4:
            found["orientations"].append(tuple(axes[axis] for axis in "wxyz"))
        elif (part in ("", *SIDES) or last_word in _POSITION) and {"x", "y"} <= axes.keys():
            found["positions"].append(tuple(axes[axis] for axis in "xyz" if axis in axes))
    may = [name for name in names if not OTHER.search(name)]
    named = tuple(name for name in may if _NAMED_JOINT.fullmatch(joint(name).lower()))
    measured = tuple(name for name in named if not _SECOND.search(name.lower())) or named
    numbered = list(_numbered_joints(may))
    groups = [group for group in numbered if not _SECOND.search(group[0].lower())] or numbered
    found["joints"] += [*groups, *(tuple(each.values()) for each in by_joint(measured))]
    if {*_AXES} <= plain.keys():
        found["joints"].append(tuple(plain[axis] for axis in _ALL_AXES if axis in plain))
    moving = tuple(name for name in names if name + JOINT_SUFFIXES["velocities"] in names)
    if not found["positions"] and set().union(*found["joints"]) < set(moving):
        found["joints"] = [moving]
    return found


def by_joint(names: Sequence[str]) -> list[dict[str, str]]:
    """Columns by their joints: the first of each, then the second of those that have several."""
    groups: list[dict[str, str]] = []
    for name in names:
        own = joint(name)
        group = next((each for each in groups if own not in each), None)
        if group is None:
            groups.append(group := {})
        group[own] = name
    return groups


def of_a_pose(columns: Sequence[str]) -> bool:
    """Whether some columns are lengths, x, y and z of one name, or an orientation: not joints."""
    plain = {unit(name, "positions")[0].lower() for name in columns}
    lengths = any(unit(name, "positions")[1] for name in columns)
    whole = any({name[:-1] + axis for axis in "xyz"} <= plain for name in plain)
    return lengths or whole or any(_ROTATED.fullmatch(name) for name in plain if name[1:])


def owner(columns: Columns) -> str:
    """The body that a position or orientation is of, as its columns' names begin; "" if none."""
    if len(columns) == 1:
        return ""
    match = _COMPONENT.fullmatch(unit(columns[0], "positions")[0].lower())
    words = re.split(r"[_.\-/ ]", match["part"]) if match else []
    return "_".join(each for each in words if each not in _POSITION | _ORIENTATION)


def unread_orientations(names: Sequence[str], beside: Columns | None = None) -> Columns:
    """The columns of orientations that are not read: angles (also KUKA's, Fanuc's), matrices.

    Beside positions that were asked for, those of the same body by their names.
    """
    if beside is not None:
        names = [name for name in names if (own := owner(beside)) and name.lower().startswith(own)]
    plain = {unit(name, "joints")[0].lower(): name for name in names}
    triples = {axis for axes in _ANGLES if {*axes} <= plain.keys() for axis in axes}
    return tuple(name for p, name in plain.items() if p in triples or _ROTATED.fullmatch(p))


def derivatives(names: Sequence[str], joints: Columns) -> dict[str, Columns]:
    """The columns of the joints' velocities and accelerations, where all joints have them."""
    found: dict[str, Columns] = {}
    for role, prefix in _PREFIXES.items():
        choices = [tuple(joint + JOINT_SUFFIXES[role] for joint in joints)]
        choices.append(tuple(prefix + joint for joint in joints))
        if len(joints) == 1 and is_whole(joints[0]):
            choices.append((role,))
        for columns in choices:
            if set(columns) <= set(names):
                found[role] = columns
    return found


def unit_since_1970(time: float) -> float:
    """The unit, s, of times that state none: by their digits if they count from 1970, or else s."""
    return next((unit for unit in (1e-3, 1e-6, 1e-9) if 1e9 <= unit * time < 1e10), 1.0)


def _clocks(names: Sequence[str]) -> list[Columns]:
    """The columns of times, each one or whole seconds and the nanoseconds beyond them."""
    whole = {name.lower(): name for name in names if not _NANO.search(name)}
    seconds = {name: _NANO.sub("", name.lower()) for name in names if _NANO.search(name)}
    pairs: list[Columns] = [(whole[s], name) for name, s in seconds.items() if s in whole]
    known = _TIME - {*_AXES} if {*_AXES} <= {name.lower() for name in names} else _TIME
    times = [name for name in names if unit(name, "time")[0].lower().strip("%_") in known]
    return [(name,) for name in times if not any(name in pair for pair in pairs)] or pairs


def _whole(name: str, role: str) -> str:
    if role == "orientations" and (match := _ORDERED.fullmatch(name)):
        return match["name"]
    return unit(name, role)[0]


def _components(names: Sequence[str]) -> dict[str, dict[str, str]]:
    parts: dict[str, dict[str, str]] = {}
    for name in names:
        if match := _COMPONENT.fullmatch(unit(name, "positions")[0].lower()):
            parts.setdefault(match["part"], {})[match["axis"]] = name
    return parts


def _numbered_joints(names: Sequence[str]) -> Iterator[Columns]:
    arms: dict[tuple[str, bool], dict[int, str]] = {}
    for name in names:
        plain = unit(name, "joints")[0].lower()
        if match := _NUMBERED_JOINT.fullmatch(plain) or _NUMBERED_JOINT.fullmatch(joint(plain)):
            joints, number = arms.setdefault((match["arm"], False), {}), int(match["number"])
            if number in joints:
                joints = arms.setdefault((match["arm"], True), {})
            joints[number] = name
    for joints in arms.values():
        numbers = sorted(joints)
        if numbers[0] in (0, 1) and numbers == list(range(numbers[0], numbers[0] + len(numbers))):
            yield tuple(joints[number] for number in numbers)

"""Finds what a recording's columns hold by their names, upper or lower case.

time: `time`, `times`, `t`, `timestamp`, `stamp`.
positions: `x`, `y` and, where there is one, `z`, alone or after `p`, `pos`, `position` or
`translation` (`px`, `pos_x`, `position.x`, `current_pos_x`).
orientations: `w`, `x`, `y`, `z` after `q`, `quat`, `quaternion`, `orientation`, `rotation` or
`rot` (`qw`, `orientation_w`, `current_orientation_w`).
joints: `joint`, `j` or `q` with a number (`joint_1`, `panda_joint1`, `q0`), in the order of the
numbers, which start at 0 or 1 and leave none out; or names that end in `_joint`
(`shoulder_pan_joint`), in the order of the file.
Arrays that hold a whole part at once: `positions`, `position`, `pos`; `orientations`,
`orientation`, `quaternions`, `quaternion`; `joints`, `joint_positions`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

Columns = tuple[str, ...]

_TIME = {"time", "times", "t", "timestamp", "stamp"}
_POSITION = {"p", "pos", "position", "translation"}
_ORIENTATION = {"q", "quat", "quaternion", "orientation", "rotation", "rot"}
_WHOLE = {
    "positions": {"positions", "position", "pos"},
    "orientations": {"orientations", "orientation", "quaternions", "quaternion"},
    "joints": {"joints", "joint_positions"},
}
_COMPONENT = re.compile(r"(?P<part>.*?)[_.\-/ ]?(?P<axis>[wxyz])")
_NUMBERED_JOINT = re.compile(r"(?P<arm>(.*[_.\-/ ])?(joint|j|q)[_.\-/ ]?)(?P<number>[0-9]{1,4})")


def candidates(names: Sequence[str]) -> dict[str, list[Columns]]:
    """Every choice of columns that fits each of time, positions, orientations and joints."""
    found: dict[str, list[Columns]] = {
        "time": [(name,) for name in names if name.lower() in _TIME],
        **{
            role: [(name,) for name in names if name.lower() in whole]
            for role, whole in _WHOLE.items()
        },
    }
    for part, axes in _components(names).items():
        last_word = re.split(r"[_.\-/ ]", part)[-1]
        if (part == "" or last_word in _POSITION) and {"x", "y"} <= axes.keys():
            found["positions"].append(tuple(axes[axis] for axis in "xyz" if axis in axes))
        elif last_word in _ORIENTATION and len(axes) == 4:
            found["orientations"].append(tuple(axes[axis] for axis in "wxyz"))
    found["joints"] += [*_numbered_joints(names), *_named_joints(names)]
    return found


def _components(names: Sequence[str]) -> dict[str, dict[str, str]]:
    parts: dict[str, dict[str, str]] = {}
    for name in names:
        if match := _COMPONENT.fullmatch(name.lower()):
            parts.setdefault(match["part"], {})[match["axis"]] = name
    return parts


def _numbered_joints(names: Sequence[str]) -> Iterator[Columns]:
    arms: dict[str, dict[int, str]] = {}
    for name in names:
        if match := _NUMBERED_JOINT.fullmatch(name.lower()):
            arms.setdefault(match["arm"], {})[int(match["number"])] = name
    for joints in arms.values():
        numbers = sorted(joints)
        if numbers[0] in (0, 1) and numbers == list(range(numbers[0], numbers[0] + len(numbers))):
            yield tuple(joints[number] for number in numbers)


def _named_joints(names: Sequence[str]) -> Iterator[Columns]:
    joints = tuple(name for name in names if name.lower().endswith("_joint"))
    if joints:
        yield joints

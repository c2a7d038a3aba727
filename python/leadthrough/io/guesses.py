"""Columns to propose where names leave them open, for a person to confirm."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from difflib import get_close_matches
from itertools import chain

import numpy as np

from leadthrough import sanity
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.io import headers
from leadthrough.io.headers import Columns
from leadthrough.io.table import Request, Table, joints_told

_SPACE = 3  # coordinates of a position
_UNEVEN = 1.5  # times the lower quartile of a clock's steps is more than the upper one


def proposal(table: Table, request: Request) -> str:
    """Words with the columns to propose, if there are any."""
    named = [words(role, names) for role, names in guessed(table, request).items()]
    return f"; such as {' '.join(named)}" if named else ""


def words(role: str, names: Columns) -> str:
    """The columns as on the command line, once the argument's name is the option's."""
    return f"columns[{role!r}]={shlex.quote(','.join(names))}"


def nearest(table: Table, role: str, names: Columns) -> str:
    """Words with the columns whose names come nearest, where each has one."""
    near = [get_close_matches(name, table.names, 1) for name in names]
    found = tuple(dict.fromkeys(each[0] for each in near if each))
    return f"; perhaps {words(role, found)}" if len(found) == len(names) else ""


def guessed(table: Table, request: Request) -> dict[str, Columns]:
    """Columns by role: by their names, else the rising one as the time and others as the joints."""
    found = headers.candidates(table.names) | {role: [own] for role, own in table.roles.items()}
    if found["positions"] and [len(names) for names in found["joints"]] == [4]:  # ABB's q1 to q4
        numbers = [numbers_of(table, name) for name in found["joints"][0]]
        if sanity.are_quaternions(np.array([each for each in numbers if each is not None])):
            return {"positions": found["positions"][0], "orientations": found["joints"][0]}
    if known := [role for role in ("joints", "positions") if found[role]]:
        return {known[0]: found[known[0]][0]}
    time = found["time"][0] if found["time"] else rising(table)[:1]
    turned = found["orientations"][0] if found["orientations"] else ()
    names = [n for n in table.names if n not in (*time, *turned) and not headers.OTHER.search(n)]
    rest = [name for name in names if numbers_of(table, name) is not None]
    joints = () if turned else tuple(request.joints)
    many = len(rest) > _SPACE
    if len(rest) < max(len(joints), 2) or (many and (turned or headers.of_a_pose(rest))):
        return {}
    role = "joints" if joints or many else "positions"
    chosen = _of_joints(rest, joints) if joints else tuple(rest)
    by_role = {"time": () if found["time"] else time, role: chosen, "orientations": turned}
    return {role: each for role, each in by_role.items() if each}


def _of_joints(names: Sequence[str], joints: Columns) -> Columns:
    """As many columns as joints, first those that tell by their names which one they are of."""
    told = joints_told(names, joints)
    several = len(names) - len(joints)
    if any(joint is not None for joint in told):  # a counter or a mode stands before the others
        first = next(i for i, joint in enumerate(told) if joint is not None or i == several)
        names, told = names[first:], told[first:]
    names, told = names[: len(joints)], told[: len(joints)]
    others = (name for name, joint in zip(names, told, strict=True) if joint is None)
    own = {joint: name for name, joint in zip(names, told, strict=True) if joint is not None}
    return tuple(own[i] if i in own else next(others) for i in range(len(joints)))


def rising(table: Table) -> Columns:
    """The columns whose numbers rise by similar steps, as times do, and joints hardly."""
    used = {*chain(*chain(*headers.candidates(table.names).values()))}
    columns = ((name, numbers_of(table, name)) for name in table.names if name not in used)
    steps = ((name, np.diff(rows)) for name, rows in columns if rows is not None and len(rows) > 1)
    spread = ((name, each.min(), *np.percentile(each, [25, 75])) for name, each in steps)
    return tuple(name for name, least, q1, q3 in spread if least > 0.0 and q3 < _UNEVEN * q1)


def numbers_of(table: Table, name: str) -> Float64Array | None:
    """A column's numbers; None for one of other things."""
    try:
        rows = table.numbers(name)
    except (InvalidInput, ValueError):
        return None
    return rows if rows.ndim == 1 else None

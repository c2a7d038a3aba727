"""Demonstrations of robomimic and robosuite: HDF5 with a group `data/demo_<i>` for each.

The columns are the arrays of `obs` with one or two axes that lie in the file itself:
`robot0_joint_pos` are the joints, `robot0_eef_pos` and `robot0_eef_quat` (x, y, z, w) the poses.
The rate is the control frequency in `env_args`, where there is one. Needs the extra `hdf5`.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from leadthrough import check
from leadthrough.check import InvalidInput
from leadthrough.io.files import MAX_WIDTH, ReadLimits, refusing_damage
from leadthrough.io.table import ArrayTable, Request

_ROLES = {
    "joints": "robot0_joint_pos",
    "positions": "robot0_eef_pos",
    "orientations": "robot0_eef_quat",
}
_SECOND = "robot1_"  # arm


def labels(path: Path) -> list[str]:
    """The names of the demonstrations, in the order of their numbers."""
    h5py = check.package("h5py", extra="hdf5")
    with refusing_damage("robomimic HDF5 file"), h5py.File(path, "r") as file:
        return _labels(file)


def tables(path: Path, request: Request | None = None) -> list[ArrayTable]:
    """One table per demonstration, in the order of their numbers."""
    h5py = check.package("h5py", extra="hdf5")
    with refusing_damage("robomimic HDF5 file"), h5py.File(path, "r") as file:
        return _tables(file, request.part if request else None)


def _labels(file: Any) -> list[str]:
    data = file.get("data")
    names = [] if data is None else [name for name in data if str(name).startswith("demo_")]
    if not names:
        raise InvalidInput("expected groups data/demo_<i>; save other recordings as .csv or .npz")
    return sorted(names, key=_number)


def _tables(file: Any, part: tuple[int, int] | None) -> list[ArrayTable]:
    names = _labels(file)
    data = file["data"]
    rate = _control_rate(data.attrs.get("env_args"))
    limits = ReadLimits()
    found = []
    for name in names if part is None else names[part[0] : part[1]]:
        sets = _sets(data[name].get("obs", {}))
        limits.columns(len(sets), f"{name}/obs")
        limits.numbers(sum(each.size for each in sets.values()), f"{name}/obs")
        for each in sets.values():  # a chunk is inflated as a whole
            ReadLimits().numbers(math.prod(each.chunks or ()), f"{name}/obs: a chunk")
        arrays = {own: np.asarray(each[()]) for own, each in sets.items()}
        roles = {role: (own,) for role, own in _ROLES.items() if own in arrays}
        if any(name.startswith(_SECOND) for name in arrays):
            roles = {}  # whether the first is the left one is not said
        found.append(
            ArrayTable(
                arrays, roles=roles, label=name, rate=rate, quaternions="xyzw", angles="radians"
            )
        )
    return found


def _sets(group: Any) -> dict[str, Any]:
    return {
        name: each
        for name, each in group.items()
        if isinstance(name, str)  # h5py returns damaged names as bytes
        and hasattr(each, "dtype")
        and each.dtype.kind in "fiu"
        and not (each.external or each.is_virtual)  # numbers from anywhere on the disk
        and (each.ndim == 1 or (each.ndim == 2 and each.shape[1] <= MAX_WIDTH))
    }


def _number(name: str) -> tuple[int, str]:
    digits = name.removeprefix("demo_")
    return (int(digits) if digits.isdecimal() and len(digits) < 10 else -1, name)


def _control_rate(arguments: Any) -> float | None:
    """Hz, if the environment's arguments have it."""
    try:
        rate = json.loads(arguments)["env_kwargs"]["control_freq"]
    except (ValueError, TypeError, KeyError, RecursionError):
        return None
    valid = isinstance(rate, int | float) and not isinstance(rate, bool)
    return float(rate) if valid and 0 < rate < float("inf") else None

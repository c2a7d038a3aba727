"""NumPy's .npz archives and .npy arrays, never with pickle: one motion per file, a row per sample.

`write` uses names that reading finds: `times`, `positions` and `orientations_wxyz`, or `joints`
with `joint_names`, `velocities` and `accelerations`; `event_times` and `event_names`. Joints that
the tip carries along are arrays `<name>_recorded`.

An .npy has rows of numbers, whose columns are named by their numbers, from 1 on. Without the time,
two or three are a position, more are joints.
"""

from __future__ import annotations

import math
import tokenize
import warnings
import zipfile
import zlib
from collections.abc import Mapping
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from leadthrough import check, sanity
from leadthrough.check import InvalidInput
from leadthrough.io.files import ReadLimits, StrPath, read_bytes, refusing_damage, replacing
from leadthrough.io.headers import Columns
from leadthrough.io.joint_trajectory import joint_columns, quantities
from leadthrough.io.recording import demonstrated_columns
from leadthrough.io.table import ArrayTable, Request
from leadthrough.motion import Event, JointTrajectory, Motion, PoseTrajectory, checked_motion

_OF_POINT, _WIDE = (2, 3), 32  # numbers in a row, of a point and of more than an arm
_JITTER = 0.05  # of a clock, in periods: half of its steps are nearer
# Errors of NumPy and zipfile for archives that are cut off, encrypted, pickled or altered, and for
# a single array that was renamed to .npz (TypeError).
DAMAGE = (
    ValueError,
    TypeError,
    KeyError,
    SyntaxError,
    tokenize.TokenError,
    EOFError,
    OSError,
    MemoryError,
    RuntimeError,
    zipfile.BadZipFile,
    zlib.error,
)


def table(path: Path) -> ArrayTable:
    """The arrays of an archive as columns."""
    found = arrays(path)
    if "joint_names" in found and "joints" not in found and "joint_positions" in found:
        found["joints"] = found.pop("joint_positions")
    joints, names = found.get("joints"), found.get("joint_names")
    if joints is None or names is None:
        return ArrayTable(found, events=_events(found))
    labels = [str(name) for name in names.ravel()]
    if joints.ndim != 2 or len(labels) != joints.shape[1] or len(set(labels)) != len(labels):
        raise InvalidInput("joint_names: expected one name, each only once, per column of joints")
    return _named(found, tuple(labels))


def arrays(path: Path) -> dict[str, NDArray[Any]]:  # Any: of whatever type the archive has
    with (
        refusing_damage(".npz archive of plain arrays", damage=DAMAGE),
        warnings.catch_warnings(),  # NumPy warns of headers as Python 2 wrote them
    ):
        warnings.simplefilter("ignore", UserWarning)
        _check_claims(path, ReadLimits())
        # NumPy leaves a file open that it opened itself and could not read.
        with path.open("rb") as file, np.load(file, allow_pickle=False) as archive:
            return {name: archive[name] for name in archive.files}


def write(motion: Motion, path: StrPath) -> None:
    """Writes a motion to the last bit."""
    checked_motion(motion, "motion")
    write_arrays(path, _content(motion))


def write_arrays(path: StrPath, arrays: Mapping[str, Any]) -> None:
    """Writes an archive of arrays by name, whole or not at all."""
    with replacing(path) as temporary, temporary.open("wb") as file:
        np.savez(file, allow_pickle=False, **arrays)


def write_compressed(path: StrPath, arrays: Mapping[str, Any]) -> None:
    """Writes a compressed archive of arrays by name, whole or not at all."""
    with replacing(path) as temporary, temporary.open("wb") as file:
        np.savez_compressed(file, allow_pickle=False, **arrays)


def write_tables(path: StrPath, kind: str, tables: Mapping[str, Any]) -> None:
    """Writes what `leadthrough/skill.hpp` reads in C++: numbers, and texts as bytes."""
    arrays = {"exported": kind} | dict(tables)
    write_arrays(path, {name: _plain(value) for name, value in arrays.items()})


def _plain(value: Any) -> NDArray[Any]:
    if isinstance(value, str):
        return np.frombuffer(value.encode(), dtype=np.uint8)
    return np.ascontiguousarray(value, dtype="<f8")


def _content(motion: Motion) -> dict[str, Any]:
    content: dict[str, Any] = {"times": motion.times}
    if isinstance(motion, JointTrajectory):
        values = quantities(motion)
        content["joints"] = values.pop("positions")
        if motion.joint_names:
            content["joint_names"] = np.array(motion.joint_names)
        content |= values
    else:
        content["positions"] = motion.positions
    if isinstance(motion, PoseTrajectory):
        content["orientations_wxyz"] = motion.orientations
    content |= demonstrated_columns(motion)
    if motion.events:
        content["event_times"] = np.array([event.time for event in motion.events])
        content["event_names"] = np.array([event.name for event in motion.events])
    return content


def _named(found: Mapping[str, NDArray[Any]], names: Columns) -> ArrayTable:
    """The table with a column for each joint."""
    whole = {"joints": "positions", "velocities": "velocities", "accelerations": "accelerations"}
    others = {name: array for name, array in found.items() if name not in whole}
    fitting = {
        quantity: found[name]
        for name, quantity in whole.items()
        if name in found and found[name].shape == found["joints"].shape
    }
    return ArrayTable(
        others | joint_columns(names, fitting),
        roles={"joints": names},
        angles="radians",
        events=_events(found),
    )


def _events(found: Mapping[str, NDArray[Any]]) -> tuple[Event, ...]:
    if "event_times" not in found or "event_names" not in found:
        return ()
    times = check.array(found["event_times"], "event_times", shape=("n",))
    names = [str(name) for name in found["event_names"].ravel()]
    if len(names) != len(times):
        raise check.refused("event_names", f"{len(times)} names, one per event_times", len(names))
    return tuple(Event(time, name) for time, name in zip(times.tolist(), names, strict=True))


def _check_claims(path: Path, limits: ReadLimits) -> None:
    """Refuses archives whose arrays claim too many numbers, before any memory is taken."""
    with zipfile.ZipFile(path) as archive:
        members = archive.infolist()
        limits.columns(len(members), "the archive")
        limits.bytes(sum(member.file_size for member in members), "the archive")
        for member in members:
            if not member.filename.endswith(".npy"):
                continue
            with archive.open(member) as file:
                count, size = claimed(file)
            limits.numbers(count, member.filename)
            if size > member.file_size:  # NumPy would take the memory before it misses the bytes
                raise InvalidInput(
                    f"{member.filename}: its header claims {size:,} bytes of "
                    f"{member.file_size:,}; the archive is damaged"
                )


def read_array(content: bytes, limits: ReadLimits) -> NDArray[Any]:
    """The array of an .npy file."""
    if b"'|O'" in content[:128]:  # its header
        raise InvalidInput("expected numbers, got pickled objects; save an array (n, k) of numbers")
    count, size = claimed(BytesIO(content))
    limits.numbers(count, "the array")
    if size > len(content):
        raise InvalidInput(f"its header claims {size:,} bytes of {len(content):,}")
    with warnings.catch_warnings():  # NumPy warns of headers as Python 2 wrote them
        warnings.simplefilter("ignore", UserWarning)
        return np.asarray(np.load(BytesIO(content), allow_pickle=False))


def table_of_rows(path: Path, request: Request) -> ArrayTable:
    """The rows of an .npy file as columns."""
    limits = ReadLimits()
    with refusing_damage(".npy array of numbers", damage=DAMAGE):
        rows = read_array(read_bytes(path, limits), limits)
    if rows.ndim != 2 or rows.dtype.kind not in "fiu":
        raise InvalidInput(f"expected rows of numbers (n, k), got {rows.dtype} {rows.shape}")
    count, arm = rows.shape[1], len(request.joints)
    if len(rows) < count > _WIDE and not request.columns:
        raise InvalidInput(f"expected a row for each sample, got shape {rows.shape}; transpose it")
    limits.columns(count, "the array")
    numbered = {str(i + 1): rows[:, i] for i in range(count)}
    moved = [name for name in numbered if name not in request.columns.get("time", ())]
    moving = rows[:, [int(name) - 1 for name in moved]]
    if not set(request.columns) - {"time"}:
        first, last = (",".join(names) for names in (moved[:3], moved[3:]))
        sanity.pose(
            moving,
            f"name the columns, columns['positions']={first} and columns['orientations']={last} "
            "with their order, quaternions=wxyz or quaternions=xyzw; or columns['joints']="
            f"{first},{last}",
        )
    if count and not request.columns and request.rate is not None:
        _refuse_clock(rows[:, 0], request.rate)
    role = "positions" if len(moved) in _OF_POINT and len(moved) != arm else "joints"
    return ArrayTable(numbered | {role: moving})


def _refuse_clock(column: NDArray[Any], rate: float) -> None:
    """Refuses a first column that rises as time does at a rate, and would be taken for a joint."""
    steps = np.diff(column) * rate
    if len(steps) > 1 and steps.min() > 0.0 and np.median(np.abs(steps - 1.0)) < _JITTER:
        raise InvalidInput(f"rate: column 1 is time at {rate:g} Hz; give columns['time']=1 for it")


def claimed(file: Any) -> tuple[int, int]:
    """How many numbers an array has according to its header, and their bytes."""
    version = np.lib.format.read_magic(file)
    read = {
        (1, 0): np.lib.format.read_array_header_1_0,
        (2, 0): np.lib.format.read_array_header_2_0,
    }.get(version)
    if read is None:
        raise InvalidInput(f"expected arrays in version 1 or 2 of the format, got {version}")
    shape, _, dtype = read(file)
    count = math.prod(shape)
    return count * max(1, dtype.itemsize // 8), count * dtype.itemsize

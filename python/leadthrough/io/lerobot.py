"""Episodes of LeRobot data sets: Parquet with `timestamp`, `episode_index`, `observation.state`.

The path is that of the data set's folder (`meta/info.json`, `data/**/*.parquet`) or of one of its
files. The numbers of a state that `meta/info.json` names each become a column. A state holds
joints unless its names say otherwise. If they end in ".pos", as those of motors do, their unit
may be percent, and a gripper that opens or closes is an event. Needs the extra `lerobot`.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.io import headers
from leadthrough.io.files import MAX_WIDTH, ReadLimits, read_text, refusing_damage
from leadthrough.io.headers import Columns
from leadthrough.io.recording import is_gripper
from leadthrough.io.table import ArrayTable
from leadthrough.motion import Event

_STATE = "observation.state"
_MOTOR = ".pos"
_MIN_OPENING = 10.0  # degrees or percent; a gripper that moves less neither opens nor closes

Extent = tuple[float, float]


def tables(path: Path) -> list[ArrayTable]:
    """One table per episode."""
    parquet = check.package("pyarrow.parquet", extra="lerobot")
    several = files(path)
    names = _state_names(path)
    limits = ReadLimits()
    limits.items(len(several), "the folder")
    with refusing_damage("Parquet file"):
        found = [table for file in several for table in _episodes(parquet, file, names, limits)]
    motors = [name for name in names if name.endswith(_MOTOR)]
    if not motors:
        return found
    extents = _stated_extents(path, names) or _extents(found, motors)
    return [of_motors(table, {name: extents[name] for name in motors}) for table in found]


def files(path: Path) -> list[Path]:
    """The Parquet files of a data set, or the one that is given."""
    found = sorted((path / "data").rglob("*.parquet")) if path.is_dir() else [path]
    if not found:
        raise InvalidInput("expected files data/**/*.parquet in the folder, got none")
    return found


def lacks_extents(path: Path) -> bool:
    """Whether a data set has motors and does not state their least and greatest numbers."""
    names = _state_names(path)
    return any(name.endswith(_MOTOR) for name in names) and not _stated_extents(path, names)


def _episodes(parquet: Any, file: Path, names: Columns, limits: ReadLimits) -> Iterator[ArrayTable]:
    with parquet.ParquetFile(file) as opened:
        columns = _columns(opened, limits)
    if _STATE not in columns:
        raise InvalidInput(f"expected a column {_STATE!r}, got {', '.join(columns) or 'none'}")
    state = columns.pop(_STATE)
    episode = columns.pop("episode_index", np.zeros(len(state)))
    roles: dict[str, Columns] = {} if "timestamp" not in columns else {"time": ("timestamp",)}
    if state.ndim == 1 or len(names) != state.shape[1]:
        columns[_STATE] = state
        roles["joints"] = (_STATE,)
    else:
        columns |= {name: state[:, i] for i, name in enumerate(names)}
        found = headers.candidates(names)
        if not found["joints"] and not found["positions"]:
            roles["joints"] = names
    numbers = np.unique(episode)
    for number in numbers:
        rows = episode == number if len(numbers) > 1 else slice(None)
        own = {name: values[rows] for name, values in columns.items()}
        yield ArrayTable(own, roles=roles, label=f"episode_{int(number)}")


def of_motors(table: ArrayTable, extents: Mapping[str, Extent]) -> ArrayTable:
    """The table with the extents of its motors, and events where a gripper opens or closes."""
    happening = [
        event
        for name, extent in extents.items()
        if is_gripper(name) and "timestamp" in table.names
        for event in _opening(table.numbers("timestamp"), table.numbers(name), name, extent)
    ]
    return replace(table, extents=extents, events=tuple(sorted(happening)))


def _opening(
    times: Float64Array, numbers: Float64Array, name: str, extent: Extent
) -> Iterator[Event]:
    """Events at which a gripper, whose numbers grow as it opens, passes half its range."""
    least, most = extent
    if most - least < _MIN_OPENING:
        return
    fractions = (numbers - least) / (most - least)
    is_open: bool | None = None
    for time, fraction in zip(times, fractions, strict=True):
        now = is_open if 0.4 < fraction < 0.6 or np.isnan(fraction) else bool(fraction >= 0.6)
        if is_open is not None and now != is_open:
            yield Event(float(time), f"{'open' if now else 'close'} {headers.joint(name)}")
        is_open = now


def _extents(tables: Sequence[ArrayTable], names: Sequence[str]) -> dict[str, Extent]:
    """The least and greatest number of each column in all tables."""
    joined = {name: np.concatenate([table.numbers(name) for table in tables]) for name in names}
    finite = {name: column[np.isfinite(column)] for name, column in joined.items()}
    return {
        name: (float(column.min()), float(column.max())) if len(column) else (0.0, 0.0)
        for name, column in finite.items()
    }


def _stated_extents(path: Path, names: Columns) -> dict[str, Extent]:
    """The least and greatest number of each column that `meta/stats.json` states, or none."""
    file = _meta(path, "stats.json")
    try:
        stats = json.loads(read_text(file, ReadLimits()))[_STATE] if file else {}
        pairs = np.array([stats["min"], stats["max"]], dtype=float)
    except (ValueError, TypeError, KeyError, RecursionError):
        return {}
    if pairs.shape != (2, len(names)) or not np.isfinite(pairs).all():
        return {}
    return {name: (float(a), float(b)) for name, (a, b) in zip(names, pairs.T, strict=True)}


def _columns(file: Any, limits: ReadLimits) -> dict[str, Float64Array]:
    """The columns of numbers, and those of lists of numbers of one length."""
    schema = file.schema_arrow
    wanted = [field.name for field in schema if _is_numeric(field.type)]
    # The metadata of single columns would tell more, but damage in it makes pyarrow crash.
    limits.columns(len(wanted), "the file")
    limits.numbers(file.metadata.num_rows * max(len(wanted), 1), "the columns")
    found = {}
    for name in wanted:
        read = file.read(columns=[name], use_threads=False)
        values = _array(read.column(0), name, limits)
        if values is not None:
            found[name] = values
    return found


def _is_numeric(kind: Any) -> bool:
    types = check.package("pyarrow.types", extra="lerobot")
    if types.is_list(kind) or types.is_large_list(kind) or types.is_fixed_size_list(kind):
        kind = kind.value_type
    return bool(types.is_integer(kind) or types.is_floating(kind))


def _array(column: Any, name: str, limits: ReadLimits) -> Float64Array | None:
    rows = len(column)
    chunks = [chunk.flatten() if hasattr(chunk, "flatten") else chunk for chunk in column.chunks]
    limits.numbers(max(sum(map(len, chunks)) - rows, 0), name)
    parts = [np.asarray(chunk.to_numpy(zero_copy_only=False), np.float64) for chunk in chunks]
    flat = parts[0] if len(parts) == 1 else np.concatenate([np.zeros(0), *parts])
    if not hasattr(column.type, "value_type"):
        return flat
    width = len(flat) // rows if rows else 0
    if column.null_count or len(flat) != rows * width or not 0 < width <= MAX_WIDTH:
        return None
    compute = check.package("pyarrow.compute", extra="lerobot")
    lengths = set(compute.list_value_length(column).unique().to_pylist()) if rows else {width}
    if lengths != {width}:
        raise InvalidInput(f"{name}: expected lists of one length, got {sorted(lengths)}")
    return flat.reshape(rows, width)


def _state_names(path: Path) -> Columns:
    """The names of a state's numbers, or none."""
    file = _meta(path, "info.json")
    return _names_in(file) if file else ()


def _meta(path: Path, name: str) -> Path | None:
    """A file of the data set that a folder or a file belongs to."""
    folders = [path] if path.is_dir() else [*path.absolute().parents][:4]
    files = (folder / "meta" / name for folder in folders)
    return next((file for file in files if file.is_file()), None)


def _names_in(info: Path) -> Columns:
    try:
        names = json.loads(read_text(info, ReadLimits()))["features"][_STATE]["names"]
    except (ValueError, TypeError, KeyError, RecursionError):
        return ()
    if isinstance(names, dict) and len(names) == 1:
        (names,) = names.values()
    valid = isinstance(names, Sequence) and not isinstance(names, str)
    if not valid or not all(isinstance(name, str) for name in names):
        return ()
    return tuple(names) if len(set(names)) == len(names) else ()

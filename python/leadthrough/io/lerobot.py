"""Episodes of LeRobot data sets: Parquet with `timestamp`, `episode_index`, `observation.state`.

A data set is its folder (`meta/info.json`, `data/**/*.parquet`) or one of its files. The numbers
of a state become columns of their own where `meta/info.json` names them. A state is one of joints
unless its names say otherwise. Needs the extra `lerobot`.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput, MissingDependency
from leadthrough.io import bounds, headers
from leadthrough.io.headers import Columns
from leadthrough.io.table import ArrayTable

_STATE = "observation.state"
_INFO = Path("meta", "info.json")
_WIDEST = 256  # numbers a sample; more is a picture


def tables(path: Path) -> list[ArrayTable]:
    """One table an episode. Raises InvalidInput, MissingDependency."""
    try:
        from pyarrow import parquet  # noqa: PLC0415
    except ImportError:
        raise MissingDependency("pyarrow", extra="lerobot") from None
    files = sorted((path / "data").rglob("*.parquet")) if path.is_dir() else [path]
    if not files:
        raise InvalidInput("expected data/**/*.parquet in the folder, got none")
    names = _state_names(path)
    try:
        return [table for file in files for table in _episodes(parquet, file, names)]
    except InvalidInput:
        raise
    # A damaged file makes pyarrow raise whatever the damage leads to.
    except Exception as error:
        what = " ".join(str(error).split())[:200]
        raise InvalidInput(f"not a readable Parquet file ({what})") from None


def _episodes(parquet: Any, file: Path, names: Columns) -> Iterator[ArrayTable]:
    with parquet.ParquetFile(file) as opened:
        columns = _columns(opened)
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
    for number in np.unique(episode):
        rows = episode == number
        own = {name: values[rows] for name, values in columns.items()}
        yield ArrayTable(own, roles, f"episode_{int(number)}")


def _columns(file: Any) -> dict[str, Float64Array]:
    """The columns of numbers, and those of lists of numbers that are all as long."""
    schema = file.schema_arrow
    wanted = [field.name for field in schema if _is_numeric(field.type)]
    # The metadata of single columns would tell more; damaged, they make pyarrow end the process.
    bounds.check_claim(8 * file.metadata.num_rows * max(len(wanted), 1), "the columns")
    found = {}
    for name in wanted:
        values = _array(file.read(columns=[name]).column(0), name)
        if values is not None:
            found[name] = values
    return found


def _is_numeric(kind: Any) -> bool:
    from pyarrow import types  # noqa: PLC0415

    if types.is_list(kind) or types.is_large_list(kind) or types.is_fixed_size_list(kind):
        kind = kind.value_type
    return bool(types.is_integer(kind) or types.is_floating(kind))


def _array(column: Any, name: str) -> Float64Array | None:
    import pyarrow as pa  # noqa: PLC0415

    rows = len(column)
    chunks = [chunk.flatten() if hasattr(chunk, "flatten") else chunk for chunk in column.chunks]
    flat = np.concatenate(
        [np.asarray(chunk.to_numpy(zero_copy_only=False), np.float64) for chunk in chunks]
        or [np.zeros(0)]
    )
    if pa.types.is_integer(column.type) or pa.types.is_floating(column.type):
        return flat
    width = len(flat) // rows if rows else 0
    if column.null_count or len(flat) != rows * width or not 0 < width <= _WIDEST:
        return None
    lengths = {len(each) for each in column.to_pylist()} if rows else {width}
    if lengths != {width}:
        raise InvalidInput(f"{name}: expected lists of one length, got {sorted(lengths)}")
    return flat.reshape(rows, width)


def _state_names(path: Path) -> Columns:
    """The names of a state's numbers, empty where there are none."""
    folders = [path] if path.is_dir() else [*path.absolute().parents][:4]
    for folder in folders:
        if (folder / _INFO).is_file():
            return _names_in(folder / _INFO)
    return ()


def _names_in(info: Path) -> Columns:
    try:
        names = json.loads(bounds.text(info))["features"][_STATE]["names"]
    except (ValueError, TypeError, KeyError, RecursionError):
        return ()
    if isinstance(names, dict) and len(names) == 1:
        (names,) = names.values()
    valid = isinstance(names, Sequence) and not isinstance(names, str)
    if not valid or not all(isinstance(name, str) for name in names):
        return ()
    return tuple(names) if len(set(names)) == len(names) else ()

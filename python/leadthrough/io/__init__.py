"""Reading and writing, one format a file."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from leadthrough import check
from leadthrough.errors import InvalidInput
from leadthrough.io import csv, joint_trajectory, lasa, mat, npz
from leadthrough.io.atomic import StrPath
from leadthrough.io.table import Table, motion, named_columns
from leadthrough.motion import Demonstration

__all__ = ["joint_trajectory", "lasa", "read_demonstrations"]


def read_demonstrations(
    paths: StrPath | Sequence[StrPath],
    *,
    columns: Mapping[str, str | Sequence[str]] | None = None,
    rate: float | None = None,
) -> list[Demonstration]:
    """The demonstrations in one file or several, in their order.

    paths: .csv (also .tsv, .txt), .npz or .mat. A .mat file may hold several demonstrations; they
    are named after the file, with [i] where it has several.
    columns: which columns, arrays or fields to read, any of {"time": name, "positions": [names],
    "orientations": [names of w, x, y, z], "joints": [names]}. Joints make a JointTrajectory,
    positions and orientations a PoseTrajectory, positions alone a Trajectory. Without a motion
    named here it is found by the names in the file (`leadthrough.io.headers` lists them), as the
    time is (s).
    rate: Hz, > 0, for files without time, whose first sample is then at 0 s.
    Raises InvalidInput, which names the file and where it is at fault.
    """
    named = named_columns(columns)
    hertz = None if rate is None else check.number(rate, "rate", above=0.0)
    demonstrations: list[Demonstration] = []
    for path in _paths(paths):
        try:
            demonstrations += _read(path, named, hertz)
        except InvalidInput as error:
            raise InvalidInput(f"{path}: {error}") from None
    return demonstrations


def _paths(paths: Any) -> list[Path]:
    several = [paths] if isinstance(paths, str | os.PathLike) else paths
    if not isinstance(several, Sequence) or not all(
        isinstance(path, str | os.PathLike) for path in several
    ):
        raise InvalidInput(f"paths: expected a path or a sequence of paths, got {paths!r}")
    if not several:
        raise InvalidInput("paths: expected at least one path, got none")
    return [Path(path) for path in several]


def _read(
    path: Path, named: Mapping[str, tuple[str, ...]], rate: float | None
) -> list[Demonstration]:
    tables = _tables(path)
    names = [path.stem] if len(tables) == 1 else [f"{path.stem}[{i}]" for i in range(len(tables))]
    return [
        Demonstration(motion(table, named, rate), name=name)
        for name, table in zip(names, tables, strict=True)
    ]


def _tables(path: Path) -> Sequence[Table]:
    if path.is_dir():
        raise InvalidInput("expected a file, got a folder")
    if not path.is_file():
        raise InvalidInput("no such file")
    try:
        match path.suffix.lower():
            case ".csv" | ".tsv" | ".txt":
                return [csv.table(path)]
            case ".npz":
                return [npz.table(path)]
            case ".mat":
                return mat.tables(path)
    except OSError as error:
        raise InvalidInput(f"cannot be read ({error.strerror})") from None
    raise InvalidInput(f"expected .csv, .tsv, .txt, .npz or .mat, got {path.suffix!r}")

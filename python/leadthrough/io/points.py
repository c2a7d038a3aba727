"""Points in space from files: PCD, PLY, NumPy's .npy, and tables of text.

Of a table or a file with named fields, the columns x, y and z count; else the first three. Points
that a sensor did not see, written as NaN, are left out.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.io import npz
from leadthrough.io.files import ReadLimits, StrPath, checked_path, read_bytes, refusing_damage
from leadthrough.shapes import PointCloud

SUFFIXES = (".pcd", ".ply", ".npy", ".csv", ".txt", ".xyz")

_XYZ = ("x", "y", "z")
_MAX_HEADER = 2**16  # bytes
_DAMAGE = (*npz.DAMAGE, IndexError)

# Types of numbers by the words of PLY, and by the letters and sizes of PCD.
_PLY = {
    **dict.fromkeys(("char", "int8"), "i1"),
    **dict.fromkeys(("uchar", "uint8"), "u1"),
    **dict.fromkeys(("short", "int16"), "i2"),
    **dict.fromkeys(("ushort", "uint16"), "u2"),
    **dict.fromkeys(("int", "int32"), "i4"),
    **dict.fromkeys(("uint", "uint32"), "u4"),
    **dict.fromkeys(("float", "float32"), "f4"),
    **dict.fromkeys(("double", "float64"), "f8"),
}
_PCD = {"F": "f", "I": "i", "U": "u"}


def read_point_cloud(
    path: StrPath,
    radius: float,
    *,
    scale: float = 1.0,
    position: ArrayLike = (0.0, 0.0, 0.0),
    orientation: ArrayLike = (1.0, 0.0, 0.0, 0.0),
) -> PointCloud:
    """The points of a file as an obstacle: a ball around each.

    Args:
        path: a file .pcd, .ply, .npy, .csv, .txt or .xyz, with columns x, y and z; points that
            were not seen (NaN) are left out.
        radius: of the balls, m, > 0.
        scale: m per unit of the file, > 0: 0.001 for millimetres.
        position: of the camera's or the cloud's own frame in the base frame, (3,), m.
        orientation: w, x, y, z of that frame in the base frame, (4,).

    Raises:
        InvalidInput: if the file cannot be read or has no points or too many.
    """
    unit = check.number(scale, "scale", above=0.0)
    return PointCloud(unit * read_points(checked_path(path)), radius, position, orientation)


def read_points(path: Path) -> Float64Array:
    """The points (n, 3) of a file, in its unit."""
    limits = ReadLimits()
    with check.prefixed(path), refusing_damage("file of points", damage=_DAMAGE):
        found = _read(path, read_bytes(path, limits), limits)
        seen = np.ascontiguousarray(found[~np.isnan(found).any(axis=1)], dtype=np.float64)
    if len(seen) == 0 or not np.isfinite(seen).all():
        raise InvalidInput(f"{path}: expected finite points, got {len(seen)} that are not NaN")
    return seen


def _read(path: Path, content: bytes, limits: ReadLimits) -> NDArray[Any]:
    match path.suffix.lower():
        case ".pcd":
            return _pcd(content, limits)
        case ".ply":
            return _ply(content, limits)
        case ".npy":
            return _array(content, limits)
        case ".csv" | ".txt" | ".xyz":
            return _table(content, limits)
    raise InvalidInput(f"expected a file {', '.join(SUFFIXES)}")


def _array(content: bytes, limits: ReadLimits) -> Float64Array:
    array = npz.read_array(content, limits)
    if array.ndim != 2 or array.shape[1] < 3 or array.dtype.kind not in "fiu":
        raise InvalidInput(f"expected numbers (n, 3), got {array.dtype} {array.shape}")
    return np.asarray(array[:, :3], dtype=np.float64)


def _table(content: bytes, limits: ReadLimits) -> Float64Array:
    head = next((line for line in content[:_MAX_HEADER].splitlines() if line.strip()), b"")
    separator = next((mark for mark in ",;\t" if mark.encode() in head), None)
    words = [word.strip() for word in head.decode("utf-8-sig").lower().split(separator)]
    named = not re.match(rb"\s*([-+.\d]|nan)", head.removeprefix(b"\xef\xbb\xbf").lower())
    columns = [words.index(name) for name in _XYZ] if set(_XYZ) <= set(words) else [0, 1, 2]
    body = content[content.index(head) + len(head) :] if named else content
    return _numbers(body, columns, limits, separator=separator)


def _numbers(
    body: bytes,
    columns: Sequence[int],
    limits: ReadLimits,
    *,
    separator: str | None = None,
    rows: int | None = None,
) -> Float64Array:
    """Columns of a table of text, at most so many rows of it."""
    lines = body.count(b"\n") + 1
    limits.items(lines, "the lines")
    limits.numbers(3 * lines, "the points")
    if not body.strip():
        return np.zeros((0, 3))
    text = BytesIO(body.replace(b"\r\n", b"\n").replace(b"\r", b"\n"))
    return np.loadtxt(text, delimiter=separator, usecols=columns, max_rows=rows, ndmin=2)


def _ply(content: bytes, limits: ReadLimits) -> NDArray[Any]:
    head, body = _parted(content, rb"end_header *\r?\n", "end_header")
    order, fields, count = "", [], -1
    for words in (line.split() for line in head):
        match words:
            case ["format", form, _]:
                order = form
            case ["element", name, number]:
                if count >= 0:
                    break  # elements after the vertices are skipped
                if name != "vertex":
                    raise InvalidInput(f"expected the vertices first, got {name!r}")
                count = int(number)
            case ["property", kind, name]:
                fields.append((name, _PLY[kind]))
            case ["property", *_]:
                raise InvalidInput("expected vertices without lists")
    signs = {"binary_little_endian": "<", "binary_big_endian": ">"}
    return _fields(body, fields, max(count, 0), limits, order=signs.get(order, ""))


def _pcd(content: bytes, limits: ReadLimits) -> NDArray[Any]:
    head, body = _parted(content, rb"(?m)^DATA[^\n]*\n", "DATA")
    lines = {line.split()[0]: line.split()[1:] for line in head if line.strip()}
    sizes = zip(lines["FIELDS"], lines["TYPE"], lines["SIZE"], strict=True)
    repeats = map(int, lines.get("COUNT", ["1"] * len(lines["FIELDS"])))
    fields: list[tuple[str, str]] = []
    for (name, kind, size), repeat in zip(sizes, repeats, strict=True):
        limits.columns(len(fields) + repeat, "the fields")
        numbered = [name] if repeat == 1 else [f"{name} {i}" for i in range(repeat)]
        fields += [(each, _PCD[kind] + size) for each in numbered]
    (data,) = lines["DATA"]
    if data not in ("ascii", "binary"):
        raise InvalidInput(f"expected ascii or binary data, got {data}; save it uncompressed")
    order = "<" if data == "binary" else ""
    return _fields(body, fields, int(lines["POINTS"][0]), limits, order=order)


def _parted(content: bytes, end: bytes, word: str) -> tuple[list[str], bytes]:
    """The lines of a header, up to and with its last one, and what follows."""
    found = re.search(end, content[:_MAX_HEADER])
    if found is None:
        raise InvalidInput(f"expected a header that ends with {word}")
    return content[: found.end()].decode("ascii").splitlines(), content[found.end() :]


def _fields(
    body: bytes, fields: list[tuple[str, str]], count: int, limits: ReadLimits, *, order: str
) -> NDArray[Any]:
    """x, y and z (n, 3) of rows of fields; order: of their bytes, "" for text."""
    names = [name for name, _ in fields]
    if not set(_XYZ) <= set(names):
        raise InvalidInput(f"expected fields x, y and z, got {', '.join(names) or 'none'}")
    limits.numbers(3 * count, "the points")
    if not order:
        return _numbers(body, [names.index(name) for name in _XYZ], limits, rows=count)[:count]
    # Other fields may have one name; only these three are looked at.
    unique = [
        (name if name in _XYZ else f"{i}", order + kind) for i, (name, kind) in enumerate(fields)
    ]
    row = np.dtype(unique)
    if len(body) < count * row.itemsize:
        raise InvalidInput(f"expected {count * row.itemsize:,} bytes of points, got {len(body):,}")
    table = np.frombuffer(body, row, count)
    return np.column_stack([table[name].astype(np.float64) for name in _XYZ])

"""The MATLAB level 5 format (versions 5 to 7.2): numbers, structures and cell arrays.

Source: The MathWorks, "MAT-File Format". SciPy reads it as well, but a damaged file makes its
compiled reader crash the interpreter.
"""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Iterator
from itertools import islice
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from leadthrough.errors import InvalidInput
from leadthrough.io import bounds

# An array of numbers, a structure as a dict, a cell array or an array of structures as a list, in
# MATLAB's order of elements; None for anything else: text, complex, sparse, objects.
# Any: of whatever number type the file has.
Value: TypeAlias = "NDArray[Any] | dict[str, Value] | list[Value] | None"
Elements = Iterator[tuple[int, memoryview]]

_HEADER_SIZE = 128
_MATRIX, _COMPRESSED = 14, 15  # kinds of elements
_CELL, _STRUCTURE, _NUMBERS = 1, 2, range(6, 16)  # classes of arrays
_COMPLEX = 0x0800
_NUMBER_TYPES = {
    1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"
}  # fmt: skip
_DEEPEST = 32  # levels of cells within cells; no recording nests so deep

_DAMAGE = (ValueError, KeyError, IndexError, StopIteration, MemoryError, struct.error, zlib.error)


def variables(content: bytes) -> dict[str, Value]:
    """The variables of a file, by name.

    Args:
        content: all bytes of the file.

    Raises:
        InvalidInput: if it is no MATLAB file of versions 5 to 7.2, or damaged.
    """
    order = {b"IM": "<", b"MI": ">"}.get(content[126:_HEADER_SIZE])
    if order is None:
        raise InvalidInput("expected a MATLAB file of version 5 to 7.2, got something else")
    if struct.unpack_from(order + "H", content, 124)[0] != 0x0100:
        raise InvalidInput("expected MATLAB 7.2 or older; save with -v7")
    found = {}
    with bounds.reading("MATLAB file", damage=_DAMAGE):
        for kind, data in _elements(memoryview(content)[_HEADER_SIZE:], order):
            if kind == _COMPRESSED:
                kind, data = next(_elements(memoryview(_inflated(data)), order))  # noqa: PLW2901
            if kind == _MATRIX:
                name, value = _matrix(data, order, 0)
                found[name] = value
    return found


def _inflated(data: memoryview) -> bytes:
    inflater = zlib.decompressobj()
    content = inflater.decompress(data, bounds.LARGEST)
    if not inflater.eof:
        raise ValueError("a compressed element is cut off, or larger than a GiB")
    return content


def _elements(data: memoryview, order: str) -> Elements:
    """Kind and content of each element.

    An element of up to four bytes has its kind, size and content in eight bytes together.
    """
    at = 0
    while at < len(data):
        (word,) = struct.unpack_from(order + "I", data, at)
        if small := word >> 16:
            kind, size, start, following = word & 0xFFFF, small, at + 4, at + 8
        else:
            (size,) = struct.unpack_from(order + "I", data, at + 4)
            kind, start = word, at + 8
            padding = 0 if kind == _COMPRESSED else -size % 8
            following = start + size + padding
        if start + size > min(len(data), following):
            raise ValueError(f"an element of {size} bytes is cut off")
        yield kind, data[start : start + size]
        at = following


def _matrix(data: memoryview, order: str, depth: int) -> tuple[str, Value]:
    if len(data) == 0:
        return "", np.zeros((0, 0))
    if depth > _DEEPEST:
        raise ValueError(f"nested deeper than {_DEEPEST}")
    parts = _elements(data, order)
    flags = int(_numbers(next(parts), order)[0])
    shape = [int(size) for size in _numbers(next(parts), order)]
    if not shape or min(shape) < 0:
        raise ValueError(f"an array of shape {shape}")
    name = bytes(next(parts)[1]).decode("utf-8")
    kind = flags & 0xFF
    if kind == _CELL:
        return name, _matrices(parts, math.prod(shape), order, depth)
    if kind == _STRUCTURE:
        return name, _structures(parts, math.prod(shape), order, depth)
    if kind in _NUMBERS and not flags & _COMPLEX:
        return name, _numbers(next(parts), order).reshape(shape, order="F")
    return name, None


def _matrices(parts: Elements, count: int, order: str, depth: int) -> list[Value]:
    values = [_matrix(data, order, depth + 1)[1] for _, data in islice(parts, count)]
    if len(values) != count:
        raise ValueError(f"{count} elements announced, {len(values)} found")
    return values


def _structures(parts: Elements, count: int, order: str, depth: int) -> list[Value]:
    width = int(_numbers(next(parts), order)[0])
    text = bytes(next(parts)[1])
    if width <= 0:
        raise ValueError(f"field names of {width} bytes")
    names = [
        text[i : i + width].split(b"\0")[0].decode("ascii") for i in range(0, len(text), width)
    ]
    if not names:
        return []
    return [
        dict(zip(names, _matrices(parts, len(names), order, depth), strict=True))
        for _ in range(count)
    ]


def _numbers(element: tuple[int, memoryview], order: str) -> NDArray[Any]:
    kind, data = element
    return np.frombuffer(bytes(data), order + _NUMBER_TYPES[kind]) if len(data) else np.zeros(0)

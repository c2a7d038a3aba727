"""Recordings in MATLAB files, versions 5 to 7.2.

Each element of an array of structures, or of a cell array of them, is one recording with its
fields as columns; all structures are in one variable. A file without structures is one recording
with its variables as columns. Time runs along the longer axis of a field, along the columns of a
square one.

Source: The MathWorks, "MAT-File Format", level 5. SciPy reads it too, but a damaged file makes its
compiled reader crash the interpreter.
"""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import InvalidInput
from leadthrough.io.files import MAX_BYTES, ReadLimits, read_bytes, refusing_damage
from leadthrough.io.table import ArrayTable

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
_MAX_AXES = 32
# An element takes as much memory, and far more time, than several lines of a text.
_ITEMS_PER_ELEMENT = 8
_DAMAGE = (ValueError, KeyError, IndexError, StopIteration, MemoryError, struct.error, zlib.error)


def tables(path: Path) -> list[ArrayTable]:
    """One table per recording."""
    limits = ReadLimits()
    found = variables(read_bytes(path, limits), limits)
    structures = {name: list(_structures(value)) for name, value in found.items()}
    filled = {name: records for name, records in structures.items() if records}
    if len(filled) > 1:
        raise InvalidInput(f"expected structures in one variable, got them in {', '.join(filled)}")
    records = next(iter(filled.values()), [found])
    return [
        ArrayTable({name: _samples_first(value) for name, value in record.items()})
        for record in records
    ]


def _structures(value: Value) -> Iterator[dict[str, Value]]:
    if isinstance(value, dict):
        yield value
    elif isinstance(value, list):
        for element in value:
            yield from _structures(element)


def _samples_first(value: Value) -> Value:
    if not isinstance(value, np.ndarray) or value.ndim != 2:
        return value
    samples_first = value if value.shape[0] > value.shape[1] else value.T
    return samples_first[:, 0] if samples_first.shape[1] == 1 else samples_first


def variables(content: bytes, limits: ReadLimits | None = None) -> dict[str, Value]:
    """The variables of a file, by name."""
    order = {b"IM": "<", b"MI": ">"}.get(content[126:_HEADER_SIZE])
    if order is None:
        raise InvalidInput("expected a MATLAB file of version 5 to 7.2, got something else")
    if struct.unpack_from(order + "H", content, 124)[0] != 0x0100:
        raise InvalidInput("expected MATLAB 7.2 or older; save with -v7")
    with refusing_damage("MATLAB file", damage=_DAMAGE):
        return _Reader(order, limits or ReadLimits()).variables(content)


class _Reader:
    """Reads elements of one byte order, and has the limits count each before it is made."""

    def __init__(self, order: str, limits: ReadLimits) -> None:
        self._order, self._limits = order, limits

    def variables(self, content: bytes) -> dict[str, Value]:
        found = {}
        for kind, data in self._elements(memoryview(content)[_HEADER_SIZE:]):
            if kind == _COMPRESSED:
                kind, data = next(self._elements(self._inflated(data)))  # noqa: PLW2901
            if kind == _MATRIX:
                name, value = self._matrix(data, 0)
                found[name] = value
        return found

    def _inflated(self, data: memoryview) -> memoryview:
        inflater = zlib.decompressobj()
        content = inflater.decompress(data, MAX_BYTES)
        self._limits.bytes(len(content) + bool(inflater.unconsumed_tail), "a compressed element")
        if not inflater.eof:
            raise ValueError("a compressed element is cut off")
        return memoryview(content)

    def _elements(self, data: memoryview) -> Elements:
        """Kind and content of each element."""
        at = 0
        while at < len(data):
            self._limits.items(_ITEMS_PER_ELEMENT, "the elements")
            (word,) = struct.unpack_from(self._order + "I", data, at)
            if small := word >> 16:
                kind, size, start, following = word & 0xFFFF, small, at + 4, at + 8
            else:
                (size,) = struct.unpack_from(self._order + "I", data, at + 4)
                kind, start = word, at + 8
                padding = 0 if kind == _COMPRESSED else -size % 8
                following = start + size + padding
            if start + size > min(len(data), following):
                raise ValueError(f"an element of {size} bytes is cut off")
            yield kind, data[start : start + size]
            at = following

    def _matrix(self, data: memoryview, depth: int) -> tuple[str, Value]:
        if len(data) == 0:
            return "", np.zeros((0, 0))
        self._limits.depth(depth, "a cell array")
        parts = self._elements(data)
        flags = int(self._numbers(next(parts))[0])
        sizes = self._numbers(next(parts))
        shape = sizes[: _MAX_AXES + 1].astype(int).tolist()
        if not 0 < len(shape) <= _MAX_AXES or min(shape) < 0:
            raise ValueError(f"an array of shape {shape}")
        name = bytes(next(parts)[1]).decode("utf-8")
        kind = flags & 0xFF
        if kind == _CELL:
            return name, self._matrices(parts, math.prod(shape), depth)
        if kind == _STRUCTURE:
            return name, self._structures(parts, math.prod(shape), depth)
        if kind in _NUMBERS and not flags & _COMPLEX:
            return name, self._numbers(next(parts)).reshape(shape, order="F")
        return name, None

    def _matrices(self, parts: Elements, count: int, depth: int) -> list[Value]:
        values = [self._matrix(data, depth + 1)[1] for _, data in islice(parts, count)]
        if len(values) != count:
            raise ValueError(f"{count} elements announced, {len(values)} found")
        return values

    def _structures(self, parts: Elements, count: int, depth: int) -> list[Value]:
        width = int(self._numbers(next(parts))[0])
        text = bytes(next(parts)[1])
        if width <= 0:
            raise ValueError(f"field names of {width} bytes")
        self._limits.columns(len(text) // width, "a structure")
        names = [
            text[i : i + width].split(b"\0")[0].decode("ascii") for i in range(0, len(text), width)
        ]
        if not names:
            return []
        return [
            dict(zip(names, self._matrices(parts, len(names), depth), strict=True))
            for _ in range(count)
        ]

    def _numbers(self, element: tuple[int, memoryview]) -> NDArray[Any]:
        kind, data = element
        if len(data) == 0:
            return np.zeros(0)
        numbers = np.frombuffer(data, self._order + _NUMBER_TYPES[kind])
        self._limits.numbers(len(numbers), "an array")
        return numbers

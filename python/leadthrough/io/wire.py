"""Plain values and arrays over a pipe, between two of our own processes; never with pickle."""

from __future__ import annotations

import json
import struct
from collections.abc import Sequence
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

_LENGTH = struct.Struct("<Q")


def send(stream: IO[bytes], head: object, arrays: Sequence[NDArray[Any]] = ()) -> None:
    """Writes plain values, as JSON knows them, and arrays of numbers."""
    shapes = [[array.dtype.str, array.shape] for array in arrays]
    content = json.dumps([head, shapes]).encode()
    stream.write(_LENGTH.pack(len(content)) + content)
    for array in arrays:
        stream.write(_bytes(np.ascontiguousarray(array)))
    stream.flush()


def receive(stream: IO[bytes]) -> tuple[Any, list[NDArray[Any]]]:
    """The values and arrays of one `send`."""
    (length,) = _LENGTH.unpack(_exactly(stream, _LENGTH.size))
    head, shapes = json.loads(_exactly(stream, length))
    arrays = []
    for kind, shape in shapes:
        array = np.empty(shape, np.dtype(kind))
        # Buffered binary files have it, though their common type does not say so.
        if array.nbytes and stream.readinto(_bytes(array)) != array.nbytes:  # type: ignore[attr-defined]
            raise EOFError
        arrays.append(array)
    return head, arrays


def _bytes(array: NDArray[Any]) -> memoryview:
    return array.reshape(-1).view(np.uint8).data


def _exactly(stream: IO[bytes], count: int) -> bytes:
    content = stream.read(count)
    if len(content) != count:
        raise EOFError
    return content

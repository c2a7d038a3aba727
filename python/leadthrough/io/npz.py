"""Reads NumPy's .npz archives, never with pickle: one demonstration, one row a sample."""

from __future__ import annotations

import zipfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from leadthrough.errors import InvalidInput
from leadthrough.io.table import ArrayTable

# What NumPy and zipfile let through on archives that are cut off, encrypted, pickled or altered,
# and on a single array that was renamed to .npz (TypeError).
_UNREADABLE = (
    ValueError,
    TypeError,
    KeyError,
    SyntaxError,
    EOFError,
    OSError,
    MemoryError,
    RuntimeError,
    zipfile.BadZipFile,
    zlib.error,
)


def table(path: Path) -> ArrayTable:
    """The arrays of an archive as columns. Raises InvalidInput."""
    return ArrayTable(arrays(path))


def arrays(path: Path) -> dict[str, NDArray[Any]]:
    """The arrays of an archive by name. Raises InvalidInput."""
    try:
        # NumPy leaves a file open that it opened itself and could not read.
        with path.open("rb") as file, np.load(file, allow_pickle=False) as archive:
            return {name: archive[name] for name in archive.files}
    except _UNREADABLE as error:
        raise InvalidInput(f"not a readable .npz archive of plain arrays ({error})") from None

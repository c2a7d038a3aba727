"""Reads MATLAB files, version 7.2 and older.

Every element of an array of structures, or of a cell array of them, is one demonstration, its
fields the columns; the structures are in one variable. A file without structures is itself one
demonstration, its variables the columns. The longer axis of a field is time, rows in a square.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import loadmat

from leadthrough.errors import InvalidInput
from leadthrough.io.table import ArrayTable


def tables(path: Path) -> list[ArrayTable]:
    """One table a demonstration. Raises InvalidInput."""
    try:
        content = loadmat(path)
    except NotImplementedError:
        raise InvalidInput("expected MATLAB 7.2 or older; save with -v7") from None
    except Exception as error:  # SciPy's parser lets through whatever it trips over.
        raise InvalidInput(f"not a readable MATLAB file ({error})") from None
    variables = {name: value for name, value in content.items() if not name.startswith("__")}
    structures = {name: list(_structures(value)) for name, value in variables.items()}
    filled = {name: found for name, found in structures.items() if found}
    if len(filled) > 1:
        raise InvalidInput(f"expected structures in one variable, got them in {', '.join(filled)}")
    records = next(iter(filled.values()), [variables])
    return [
        ArrayTable({name: _samples_first(record[name]) for name in record}) for record in records
    ]


def _structures(value: Any) -> Iterator[dict[str, Any]]:
    if not isinstance(value, np.ndarray):
        return
    if value.dtype.names is not None:
        for element in value.ravel():
            yield {name: element[name] for name in value.dtype.names}
    elif value.dtype == object:
        for cell in value.ravel():
            yield from _structures(cell)


def _samples_first(value: Any) -> Any:
    array = np.asarray(value)
    if array.ndim != 2:
        return array
    samples_first = array if array.shape[0] > array.shape[1] else array.T
    return samples_first[:, 0] if samples_first.shape[1] == 1 else samples_first

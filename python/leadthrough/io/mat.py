"""Recordings in MATLAB files, versions 5 to 7.2.

Each element of an array of structures, or of a cell array of them, is one recording with its
fields as columns; all structures are in one variable. A file without structures is one recording
with its variables as columns. Time runs along the longer axis of a field, along the columns of a
square one.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from leadthrough.errors import InvalidInput
from leadthrough.io import bounds, mat5
from leadthrough.io.table import ArrayTable


def tables(path: Path) -> list[ArrayTable]:
    """One table per recording."""
    gate = bounds.Gate()
    variables = mat5.variables(bounds.content(path, gate), gate)
    structures = {name: list(_structures(value)) for name, value in variables.items()}
    filled = {name: found for name, found in structures.items() if found}
    if len(filled) > 1:
        raise InvalidInput(f"expected structures in one variable, got them in {', '.join(filled)}")
    records = next(iter(filled.values()), [variables])
    return [
        ArrayTable({name: _samples_first(value) for name, value in record.items()})
        for record in records
    ]


def _structures(value: mat5.Value) -> Iterator[dict[str, mat5.Value]]:
    if isinstance(value, dict):
        yield value
    elif isinstance(value, list):
        for element in value:
            yield from _structures(element)


def _samples_first(value: mat5.Value) -> mat5.Value:
    if not isinstance(value, np.ndarray) or value.ndim != 2:
        return value
    samples_first = value if value.shape[0] > value.shape[1] else value.T
    return samples_first[:, 0] if samples_first.shape[1] == 1 else samples_first

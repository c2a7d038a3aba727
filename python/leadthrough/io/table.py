"""A recording as named columns, as every reader hands it on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.events import Events
from leadthrough.io.headers import Columns


class Table(Protocol):
    """What a reader returns: columns that become numbers when they are asked for."""

    @property
    def names(self) -> Sequence[str]:
        """The columns."""
        ...

    @property
    def roles(self) -> Mapping[str, Columns]:
        """What the format itself says of its columns, whatever their names."""
        ...

    @property
    def label(self) -> str | None:
        """The recording's own name, where the format gives it one."""
        ...

    @property
    def rate(self) -> float | None:
        """Hz, where the format states it and there is no time column."""
        ...

    @property
    def quaternions(self) -> str | None:
        """The order of four numbers in one column, "wxyz" or "xyzw", where the format fixes it."""
        ...

    @property
    def angles(self) -> str | None:
        """The unit of joints, "radians" or "degrees", where the format fixes it."""
        ...

    @property
    def events(self) -> Events:
        """What happened meanwhile, on the table's clock."""
        ...

    def numbers(self, name: str) -> Float64Array:
        """The column (n,), or several columns at once (n, k); NaN where there is no number.

        Raises InvalidInput.
        """
        ...

    def place(self, row: int) -> str:
        """Where a sample stands in the file, for messages."""
        ...


@dataclass(frozen=True, eq=False)
class ArrayTable:
    """Columns that are arrays already, one row a sample."""

    arrays: Mapping[str, Any]
    roles: Mapping[str, Columns] = field(default_factory=dict)
    label: str | None = None
    rate: float | None = None
    quaternions: str | None = None
    angles: str | None = None
    events: Events = ()

    @property
    def names(self) -> Sequence[str]:
        return tuple(self.arrays)

    def numbers(self, name: str) -> Float64Array:
        value = self.arrays[name]
        flat = isinstance(value, np.ndarray) and value.ndim == 1
        return check.with_gaps(value, name, shape=("n",) if flat else ("n", "k"))

    def place(self, row: int) -> str:
        return f"sample {row}"

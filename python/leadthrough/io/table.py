"""A recording as named columns: what every reader returns."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.events import Events
from leadthrough.io.headers import AngleUnit, Columns, QuaternionOrder


@dataclass(frozen=True, eq=False, kw_only=True)
class Table(ABC):
    """Columns that become numbers when they are asked for."""

    roles: Mapping[str, Columns] = field(default_factory=dict)
    label: str | None = None  # the recording's own name, where the format gives it one
    rate: float | None = None  # Hz, where the format states it and there is no time column
    quaternions: QuaternionOrder | None = None
    angles: AngleUnit | None = None  # unit of the joints, where the format fixes it
    extents: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    events: Events = ()  # on the table's clock

    @property
    @abstractmethod
    def names(self) -> Sequence[str]:
        """The names of the columns."""

    @abstractmethod
    def numbers(self, name: str) -> Float64Array:
        """A column (n,), or (n, k) where it holds k numbers per sample."""

    @abstractmethod
    def place(self, row: int) -> str:
        """Where a sample stands in the file, for messages."""


@dataclass(frozen=True, eq=False)
class ArrayTable(Table):
    """Columns that are arrays already."""

    arrays: Mapping[str, object]

    @property
    def names(self) -> Sequence[str]:
        return tuple(self.arrays)

    def numbers(self, name: str) -> Float64Array:
        value = self.arrays[name]
        flat = isinstance(value, np.ndarray) and value.ndim == 1
        return check.with_gaps(value, name, shape=("n",) if flat else ("n", "k"))

    def place(self, row: int) -> str:
        return f"sample {row}"

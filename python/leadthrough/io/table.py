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
    """Columns that become numbers when they are asked for.

    Attributes:
        roles: what the format itself says of its columns, whatever their names.
        label: the recording's own name, where the format gives it one.
        rate: Hz, where the format states it and there is no time column.
        quaternions: order of four numbers in one column, where the format fixes it.
        angles: unit of the joints, where the format fixes it.
        extents: the least and the greatest number of each joint in the whole data set, where the
            format leaves open whether they are degrees or percent of the joint's range.
        events: on the table's clock.
    """

    roles: Mapping[str, Columns] = field(default_factory=dict)
    label: str | None = None
    rate: float | None = None
    quaternions: QuaternionOrder | None = None
    angles: AngleUnit | None = None
    extents: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    events: Events = ()

    @property
    @abstractmethod
    def names(self) -> Sequence[str]:
        """The names of the columns."""

    @abstractmethod
    def numbers(self, name: str) -> Float64Array:
        """A column (n,), or (n, k) where it holds k numbers per sample; NaN where one is missing.

        Args:
            name: of the column.

        Raises:
            InvalidInput: if the column holds something other than numbers.
        """

    @abstractmethod
    def place(self, row: int) -> str:
        """Where a sample stands in the file, for messages."""


@dataclass(frozen=True, eq=False)
class ArrayTable(Table):
    """Columns that are arrays already.

    Attributes:
        arrays: a column per name, one row per sample; what is not numeric is refused when asked
            for.
    """

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

"""Where a query wants a motion to be."""

from __future__ import annotations

from typing import TypeAlias

from numpy.typing import ArrayLike

# A point or joints (d,); of poses a position (3,), or (position (3,), orientation (4,) w, x, y, z).
Place: TypeAlias = ArrayLike | tuple[ArrayLike, ArrayLike]

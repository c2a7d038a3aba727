"""How much of a change a motion may take without leaving a bound."""

from __future__ import annotations

import numpy as np

from leadthrough.check import Float64Array

# No phase is moved by more than this many times what the ends were moved by.
MOST_GAIN = 1.45


def fraction_inside(base: Float64Array, more: Float64Array, limit: float) -> float:
    """The largest fraction in [0, 1] with |base + fraction more| <= limit in every row."""
    squared = (more**2).sum(axis=1)
    mixed = (base * more).sum(axis=1)
    room = np.maximum(limit**2 - (base**2).sum(axis=1), 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        most = (np.sqrt(mixed**2 + squared * room) - mixed) / squared
    return float(np.where(squared > 0.0, most, 1.0).min(initial=1.0))

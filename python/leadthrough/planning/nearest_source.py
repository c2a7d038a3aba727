"""Which of several sources a front came from."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from leadthrough import _core
from leadthrough.errors import InvalidInput
from leadthrough.planning.grid import spacings
from leadthrough.planning.march_input import flat_indices, regular


def nearest_sources(
    arrival: ArrayLike, sources: ArrayLike, *, spacing: ArrayLike = 1.0
) -> NDArray[np.int32]:
    """The index of the source from which the front reached each cell; -1 where none did.

    The index is carried down the characteristics: each cell takes a mean of its earlier
    neighbours' fractions of the sources, by the weights of the differentiated upwind equation.
    Where two fronts meet, the border is right to about a cell.

    Args:
        arrival: 2-D or 3-D times >= 0, from `arrival_times` with the same sources and spacing.
        sources: indices of cells (k, d); of sources in one cell the first counts.
        spacing: distance between neighbouring cells, > 0, (d,) or one number.

    Returns:
        Indices of the shape of `arrival`.

    Raises:
        InvalidInput: if the times, sources or spacing are not of this kind.
    """
    raw = regular(arrival, "arrival")
    if raw.dtype.kind != "f" or raw.ndim not in (2, 3) or raw.size == 0 or not raw.min() >= 0.0:
        raise InvalidInput(
            "arrival: expected a 2-D or 3-D array of times >= 0, "
            f"got shape {raw.shape} of {raw.dtype}"
        )
    cells = flat_indices(sources, "sources", raw.shape)
    times = np.ascontiguousarray(raw, np.float64)
    return _core.nearest_sources(times, spacings(spacing, raw.ndim).tolist(), cells.tolist())

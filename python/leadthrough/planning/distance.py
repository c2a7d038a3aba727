"""Exact Euclidean distances to a set of cells.

Source: Felzenszwalb and Huttenlocher 2012, "Distance transforms of sampled functions".
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import _core, check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.planning.grid import MOST_CELLS, spacings


def distance_transform(mask: ArrayLike, *, spacing: ArrayLike = 1.0) -> Float64Array:
    """Distance of every cell to the nearest True cell, centre to centre; inf if there is none.

    Args:
        mask: 2-D or 3-D booleans.
        spacing: distance between neighbouring cells, > 0, (d,) or one number.

    Returns:
        Distances in the unit of the spacing, of the mask's shape.

    Raises:
        InvalidInput: if the mask is not such an array or a spacing is not > 0.
    """
    cells = np.asarray(mask)
    if cells.dtype != np.bool_ or cells.ndim not in (2, 3) or not 0 < cells.size <= MOST_CELLS:
        raise InvalidInput(
            f"mask: expected a 2-D or 3-D array of booleans with 1 to {MOST_CELLS:.0e} cells, "
            f"got shape {cells.shape} of {cells.dtype}"
        )
    steps = spacings(spacing, cells.ndim).tolist()
    with check.enough_memory(f"mask: a grid of shape {cells.shape}"):
        return _core.distance_transform(np.ascontiguousarray(cells), steps)

"""Running means, to the last bit those of SciPy's `uniform_filter1d`, which takes long to load."""

from __future__ import annotations

import numpy as np

from leadthrough.check import Float64Array


def running_mean(values: Float64Array, size: int, mode: str = "nearest") -> Float64Array:
    """Means (n,) or (n, d) over `size` neighbouring samples."""
    before = size // 2
    beside = [(before, size - 1 - before)] + [(0, 0)] * (values.ndim - 1)
    padded = np.pad(values, beside, mode="edge" if mode == "nearest" else "wrap")
    # One sum that goes along, in the order of the samples.
    first = np.add.accumulate(padded[:size], axis=0)[-1:]
    steps = padded[size:] - padded[:-size]
    return np.asarray(np.add.accumulate(np.concatenate([first, steps]), axis=0) / size)

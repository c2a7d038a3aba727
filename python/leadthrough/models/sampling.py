"""Even times at which a motion is sampled."""

from __future__ import annotations

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput

# A motion of more samples is a slip of the unit of dt or of the duration.
MOST_SAMPLES = 10_000_000
# A duration of n steps of dt has n steps, whatever the quotient rounds to.
_ROUNDING = 1e-9


def even_times(duration: float, dt: float) -> Float64Array:
    """Times (n,) from 0 to `duration`, at most `dt` apart, both s. Raises InvalidInput."""
    if not duration / dt <= MOST_SAMPLES:
        raise InvalidInput(
            f"dt: expected at most {MOST_SAMPLES:.0e} samples in {duration:.6g} s, got {dt} s"
        )
    steps = max(int(np.ceil(duration / dt - _ROUNDING)), 1)
    return np.linspace(0.0, duration, steps + 1)

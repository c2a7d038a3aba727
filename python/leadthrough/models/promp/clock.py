"""Times of a ProMP as phases of its motion."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.models.queries import asked_times

# A time may lie this fraction of the duration outside the motion, by rounding: evenly spaced times
# up to the duration may end an ulp beyond it.
_ROUNDING = 1e-9


def phases_at(
    times: ArrayLike, name: str, *, duration: float, repeats: bool, at_least: int = 0
) -> Float64Array:
    """Phases (n,) at times of a motion."""
    phases = asked_times(times, name, at_least=at_least) / duration
    if repeats or len(phases) == 0:
        return phases
    if len(phases) == 1:  # the quick way: via points come one at a time
        first = last = float(phases[0])
    else:
        first, last = float(phases.min()), float(phases.max())
    if first < -_ROUNDING or last > 1.0 + _ROUNDING:
        outside = (first if first < -_ROUNDING else last) * duration
        raise InvalidInput(
            f"{name}: expected times in [0, {duration:.6g}] s, the motion's duration, "
            f"got {outside:.6g} s"
        )
    return phases if first >= 0.0 and last <= 1.0 else np.clip(phases, 0.0, 1.0)

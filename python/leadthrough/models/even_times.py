"""Evenly spaced times at which a motion is sampled."""

from __future__ import annotations

import math
import sys

import numpy as np

from leadthrough import plausible
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput

# More samples than this come from a wrong unit of dt or of the duration.
MOST_SAMPLES = 10_000_000
# A duration of n steps of dt has n steps, whatever the quotient rounds to.
_ROUNDING = 1e-9
# Shorter steps have few digits left, and times would not rise.
_SHORTEST = sys.float_info.min  # s


def even_times(duration: float, dt: float) -> Float64Array:
    """Evenly spaced times (n,) from 0 to a duration, s."""
    return duration * even_phases(duration, dt)


def even_phases(duration: float, dt: float) -> Float64Array:
    """Those times as fractions (n,) of the duration, from 0 to 1; arguments as in `even_times`."""
    if not duration / dt <= MOST_SAMPLES:
        raise InvalidInput(
            f"dt: expected at most {MOST_SAMPLES:.0e} samples in {duration:.6g} s, got steps of "
            f"{dt} s; check the units of dt and duration"
        )
    plausible.step(dt, duration)
    steps = max(math.ceil(duration / dt - _ROUNDING), 1)
    if duration / steps < _SHORTEST:
        raise InvalidInput(
            f"duration: expected at least {_SHORTEST:.3g} s a step, got {duration} s in {steps}"
        )
    return np.arange(steps + 1) / steps

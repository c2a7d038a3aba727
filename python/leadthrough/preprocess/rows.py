"""The arrays of a motion or recording that have one row per sample."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from leadthrough.errors import InvalidInput
from leadthrough.io.recording import Recording
from leadthrough.motion import Demonstration, MotionT, as_demonstration, fields_of, rows_of


def chosen(recording: Recording, samples: NDArray[np.intp]) -> Recording:
    """The recording of samples by their indices, with all events."""
    rows = {name: rows[samples] for name, rows in rows_of(recording).items()}
    return replace(recording, times=recording.times[samples], **fields_of(recording, rows))


def several_samples(demonstration: Demonstration[MotionT] | MotionT) -> Demonstration[MotionT]:
    """The demonstration, if it has at least two samples."""
    shown = as_demonstration(demonstration, "demonstration")
    if len(shown.motion.times) < 2:
        raise InvalidInput("demonstration: expected at least two samples, got one")
    return shown

"""The arrays of a motion or recording that have one row per sample."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from leadthrough import events
from leadthrough.errors import InvalidInput
from leadthrough.io.recording import Recording
from leadthrough.motion import Demonstration, Motion, MotionT, as_demonstration

_FIELDS = ("positions", "orientations", "velocities", "accelerations")


def rows_of(recorded: Motion | Recording) -> dict[str, Any]:
    """The arrays (n, k) that there are, by their fields, without the times.

    Any: type checkers would refuse exact types where `dataclasses.replace` takes them.
    """
    found = {name: getattr(recorded, name, None) for name in _FIELDS}
    return {name: rows for name, rows in found.items() if rows is not None}


def piece_of(motion: MotionT, samples: slice) -> MotionT:
    """The motion of consecutive samples, at their own times, with the events between them."""
    times = motion.times[samples]
    return replace(
        motion,
        times=times,
        events=events.within(motion.events, times[0], times[-1]),
        **{name: rows[samples] for name, rows in rows_of(motion).items()},
    )


def chosen(recording: Recording, samples: NDArray[np.intp]) -> Recording:
    """The recording of samples by their indices, with all events."""
    rows = {name: rows[samples] for name, rows in rows_of(recording).items()}
    return replace(recording, times=recording.times[samples], **rows)


def several_samples(demonstration: Demonstration[MotionT] | MotionT) -> Demonstration[MotionT]:
    """The demonstration, if it has at least two samples.

    Raises:
        InvalidInput: if it has not, or is neither a demonstration nor a motion.
    """
    shown = as_demonstration(demonstration, "demonstration")
    if len(shown.motion.times) < 2:
        raise InvalidInput("demonstration: expected at least two samples, got one")
    return shown

"""Admission of motions from any source, braking, and connections onto and off a motion."""

from leadthrough.guard.admission import (
    Admission as Admission,
    CommandedState as CommandedState,
    Reason as Reason,
)
from leadthrough.guard.chunks import Chunks as Chunks
from leadthrough.guard.connect import connect as connect
from leadthrough.guard.guard import Guard as Guard
from leadthrough.guard.playback import Playback as Playback, Push as Push

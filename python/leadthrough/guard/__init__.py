"""Admission of motions from any source, braking, and connections onto and off a motion."""

from leadthrough.guard.admission import Admission, CommandedState, Reason
from leadthrough.guard.connect import connect
from leadthrough.guard.guard import Guard
from leadthrough.guard.playback import Playback

__all__ = ["Admission", "CommandedState", "Guard", "Playback", "Reason", "connect"]

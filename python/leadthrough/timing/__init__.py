"""The time law: limits judged, kept by slowing down, and used as far as they allow."""

from leadthrough.timing.binding import Binding, binding_limits
from leadthrough.timing.retiming import retime
from leadthrough.timing.scaling import (
    LimitsReport,
    Peak,
    check_limits,
    differentiate,
    scale_to_limits,
)

__all__ = [
    "Binding",
    "LimitsReport",
    "Peak",
    "binding_limits",
    "check_limits",
    "differentiate",
    "retime",
    "scale_to_limits",
]

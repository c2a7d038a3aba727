"""The time law: limits checked, kept by slowing down, and used as far as they allow."""

from leadthrough.timing.binding import Binding, binding_limits
from leadthrough.timing.limits_report import LimitsReport, Peak, check_limits
from leadthrough.timing.retiming import retime
from leadthrough.timing.scaling import differentiate, scale_to_limits

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

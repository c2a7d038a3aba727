"""The time law: the fastest one inside joint limits, the given one, and the verdict on limits."""

from leadthrough.timing.limits_report import (
    Binding,
    LimitsReport,
    Peak,
    binding_limits,
    check_limits,
)
from leadthrough.timing.request import TipSpeed
from leadthrough.timing.retiming import keep_timing, retime

__all__ = [
    "Binding",
    "LimitsReport",
    "Peak",
    "TipSpeed",
    "binding_limits",
    "check_limits",
    "keep_timing",
    "retime",
]

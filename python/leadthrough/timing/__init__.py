"""The time law: the fastest one inside joint limits, the given one, and the verdict on limits."""

from leadthrough.timing.limits_report import (
    Binding as Binding,
    LimitsReport as LimitsReport,
    Peak as Peak,
    binding_limits as binding_limits,
    check_limits as check_limits,
)
from leadthrough.timing.request import TipSpeed as TipSpeed, TipTolerance as TipTolerance
from leadthrough.timing.retiming import keep_timing as keep_timing, retime as retime

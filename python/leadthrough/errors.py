"""Every exception that leadthrough raises; each is a `LeadthroughError`.

They are defined beside the checks, which raise most of them.
"""

from leadthrough.check import (
    CodeMismatch,
    FitError,
    IkFailure,
    InvalidInput,
    InvalidRobot,
    LeadthroughError,
    LimitsInfeasible,
    MissingDependency,
    NoContinuousLogarithm,
    NoPath,
    NotFitted,
    SchedulerUnreachable,
    UnsupportedQuery,
)

__all__ = [
    "CodeMismatch",
    "FitError",
    "IkFailure",
    "InvalidInput",
    "InvalidRobot",
    "LeadthroughError",
    "LimitsInfeasible",
    "MissingDependency",
    "NoContinuousLogarithm",
    "NoPath",
    "NotFitted",
    "SchedulerUnreachable",
    "UnsupportedQuery",
]

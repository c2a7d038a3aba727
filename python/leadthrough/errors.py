"""Every exception that leadthrough raises; each is a `LeadthroughError`.

They are defined beside the checks, which raise most of them.
"""

from leadthrough.check import (
    CodeMismatch as CodeMismatch,
    FitError as FitError,
    IkFailure as IkFailure,
    InvalidInput as InvalidInput,
    InvalidRobot as InvalidRobot,
    LeadthroughError as LeadthroughError,
    LimitsInfeasible as LimitsInfeasible,
    MissingDependency as MissingDependency,
    NoContinuousLogarithm as NoContinuousLogarithm,
    NoPath as NoPath,
    NotFitted as NotFitted,
    SchedulerUnreachable as SchedulerUnreachable,
    UnsupportedQuery as UnsupportedQuery,
)

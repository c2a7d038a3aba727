"""Every exception that leadthrough raises; each is a `LeadthroughError`.

The root and `InvalidInput` are defined beside the checks, which raise it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from leadthrough.check import InvalidInput, LeadthroughError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

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


class UnsupportedQuery(InvalidInput):
    """The fitted skill cannot honour this part of a query."""


class FitError(LeadthroughError):
    """No model can be fitted to these demonstrations."""


class NotFitted(LeadthroughError, AttributeError):
    """A model was used like a fitted skill."""


class NoPath(LeadthroughError):
    """No path exists between start and goal.

    Attributes:
        reason: short code such as "start_in_wall" or "goal_enclosed".
    """

    def __init__(self, message: str, *, reason: str) -> None:
        super().__init__(message)
        self.reason = reason


class NoContinuousLogarithm(LeadthroughError):
    """A motion's rotation vectors cannot be continued without a jump.

    Attributes:
        index: sample at which the continuation breaks.
    """

    def __init__(self, message: str, *, index: int) -> None:
        super().__init__(message)
        self.index = index


class SchedulerUnreachable(LeadthroughError):
    """The scheduler of a Dask cluster does not answer any more; what was finished is stored."""


class CodeMismatch(InvalidInput):
    """A worker of a Dask cluster has other code than the machine that sends the tasks."""


class IkFailure(LeadthroughError):
    """No joint configuration reaches a sample of a motion.

    Attributes:
        index: sample that is not reached.
        status: why the solver stopped.
        residual: remaining errors (position in m, orientation in rad).
        q: closest joint configuration found, (n,) rad (m for prismatic joints).
        limiting_joints: the joints whose limits bar the way.
    """

    def __init__(
        self,
        message: str,
        *,
        index: int,
        status: str,
        residual: tuple[float, float],
        q: NDArray[np.float64],
        limiting_joints: tuple[str, ...] = (),
    ) -> None:
        super().__init__(message)
        self.index = index
        self.status = status
        self.residual = residual
        self.q = q
        self.limiting_joints = limiting_joints


class LimitsInfeasible(LeadthroughError):
    """No slower execution brings this motion inside the limits.

    Attributes:
        joint: name of the joint whose limits cannot be met.
    """

    def __init__(self, message: str, *, joint: str) -> None:
        super().__init__(message)
        self.joint = joint


class InvalidRobot(LeadthroughError, ValueError):
    """A robot description is malformed or contradicts itself.

    Attributes:
        where: element at fault.
        why: the fault.
    """

    def __init__(self, where: str, why: str) -> None:
        super().__init__(f"{where}: {why}")
        self.where = where
        self.why = why


class MissingDependency(LeadthroughError, ImportError):
    """An optional package is not installed.

    Attributes:
        package: name of the package.
        extra: extra of leadthrough that installs it.
    """

    def __init__(self, package: str, *, extra: str) -> None:
        super().__init__(
            f"{package} is not installed; install it with: pip install 'leadthrough[{extra}]'"
        )
        self.package = package
        self.extra = extra

"""Every exception that leadthrough raises; each is a `LeadthroughError`."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


# How messages begin: "rate: ...", "frames[2]: ...", perhaps behind a file: "day.csv: rate: ...".
_ARGUMENT = re.compile(r"(?:^|: )(?P<name>[a-z_]\w*(?:\[[^\]]*\])?): ")


class LeadthroughError(Exception):
    """Root of the package's errors; each can be pickled, so a worker process may raise it."""

    @property
    def argument(self) -> str | None:
        """Name of the argument at fault, such as "rate"; None if the message names none."""
        found = _ARGUMENT.search(str(self))
        return found["name"] if found else None

    def __reduce__(self) -> tuple[Any, ...]:  # Any: the type that Exception declares
        # Exception's own version calls the class with the message alone; some need more.
        return _restored, (type(self), self.args, self.__dict__)


class InvalidInput(LeadthroughError, ValueError):
    """An argument is wrong; the message names it, the expected and the given value.

    Every function raises it for an argument that is not as documented: another type or shape, out
    of the stated range, not finite. Under "Raises" stand only further causes.

    Attributes:
        argument: name of the argument, such as "rate"; None if no single one is at fault.
        value: the given value, if it is a number or a text; else None.
    """

    def __init__(self, message: str, *, argument: str | None = None, value: object = None) -> None:
        super().__init__(message)
        self._argument = argument
        self.value = value if isinstance(value, str | int | float) else None

    @property
    def argument(self) -> str | None:
        return super().argument if self._argument is None else self._argument


class UnsupportedQuery(InvalidInput):
    """The fitted skill cannot honour this part of a query."""


class FitError(LeadthroughError):
    """No model can be fitted to these demonstrations."""


class NotFitted(LeadthroughError, AttributeError):
    """A model was asked for what only a fitted skill has."""


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


def _restored(
    kind: type[LeadthroughError], args: tuple[Any, ...], attributes: dict[str, Any]
) -> LeadthroughError:
    error = kind.__new__(kind, *args)
    error.__dict__.update(attributes)
    return error

"""Every exception that leadthrough raises; all of them are a `LeadthroughError`."""

from __future__ import annotations

from typing import Any


class LeadthroughError(Exception):
    """Root of the package's errors; they survive the way back from a worker process."""

    def __reduce__(self) -> tuple[Any, ...]:
        # Exception's own calls the class with the message alone, which not all of them take.
        return _restored, (type(self), self.args, self.__dict__)


class InvalidInput(LeadthroughError, ValueError):
    """An argument is wrong; the message names it, what came and what would be right."""


class UnsupportedQuery(InvalidInput):
    """The fitted skill cannot honour this part of a query."""


class FitError(LeadthroughError):
    """No model could be fitted to these demonstrations."""


class NoPath(LeadthroughError):
    """No path exists; `reason` is a short code such as "start_in_wall" or "goal_enclosed"."""

    def __init__(self, message: str, *, reason: str) -> None:
        super().__init__(message)
        self.reason = reason


class NoContinuousLogarithm(LeadthroughError):
    """A motion's rotation vectors cannot be continued; `index` is the sample where they break."""

    def __init__(self, message: str, *, index: int) -> None:
        super().__init__(message)
        self.index = index


class IkFailure(LeadthroughError):
    """No joint configuration reaches a sample of a motion.

    index: the sample. status: why the solver stopped. residual: (position m, orientation rad).
    q: (n,) the closest configuration found.
    """

    def __init__(
        self, message: str, *, index: int, status: str, residual: tuple[float, float], q: Any
    ) -> None:
        super().__init__(message)
        self.index = index
        self.status = status
        self.residual = residual
        self.q = q


class LimitsInfeasible(LeadthroughError):
    """No slowing down brings this motion inside the limits; `joint` names the one at fault."""

    def __init__(self, message: str, *, joint: str) -> None:
        super().__init__(message)
        self.joint = joint


class InvalidRobot(LeadthroughError, ValueError):
    """A robot description is malformed or contradictory.

    where: the element at fault. why: what is wrong with it.
    """

    def __init__(self, where: str, why: str) -> None:
        super().__init__(f"{where}: {why}")
        self.where = where
        self.why = why


class MissingDependency(LeadthroughError, ImportError):
    """An optional package is not installed; the message names the extra that brings it."""

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

"""What `retime` may be asked for besides the limits, checked."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.timing.bounds import InverseDynamics, Jacobian


@dataclass(frozen=True, eq=False)
class Request:
    """Options of `retime`; rows: those of the path, joints: its columns."""

    rows: int
    joints: int
    rate: float
    path_tolerance: float
    blend: float
    holds: Mapping[int, float]
    not_before: Float64Array | None
    start_velocity: Float64Array | None
    end_velocity: Float64Array | None
    tip_speed: float | None
    jacobian: Jacobian | None
    inverse_dynamics: InverseDynamics | None

    def __post_init__(self) -> None:
        number = check.number
        self._set("rate", number(self.rate, "rate", above=0.0))
        self._set("path_tolerance", number(self.path_tolerance, "path_tolerance", above=0.0))
        self._set("blend", number(self.blend, "blend", at_least=0.0))
        self._set("holds", _holds(self.holds, self.rows))
        if self.not_before is not None:
            times = check.times(self.not_before, "not_before")
            check.array(times, "not_before", shape=(self.rows,))
            self._set("not_before", times)
        for name in ("start_velocity", "end_velocity"):
            if getattr(self, name) is not None:
                self._set(name, check.frozen(getattr(self, name), name, shape=(self.joints,)))
        if self.tip_speed is not None:
            self._set("tip_speed", number(self.tip_speed, "tip_speed", above=0.0))
            if self.jacobian is None:
                raise InvalidInput("jacobian: expected a function, as tip_speed asks for it")
        for name in ("jacobian", "inverse_dynamics"):
            value: Callable[..., Any] | None = getattr(self, name)
            if value is not None and not callable(value):
                raise InvalidInput(f"{name}: expected a function, got {type(value).__name__}")

    def _set(self, name: str, value: Any) -> None:
        object.__setattr__(self, name, value)


def _holds(holds: Any, rows: int) -> dict[int, float]:
    if holds is None:
        return {}
    if not isinstance(holds, Mapping):
        raise InvalidInput(f"holds: expected seconds by row, got {type(holds).__name__}")
    return {
        check.integer(row, "holds", at_least=0, at_most=rows - 1): check.number(
            time, f"holds[{row}]", at_least=0.0
        )
        for row, time in holds.items()
    }

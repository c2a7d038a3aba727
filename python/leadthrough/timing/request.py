"""The options of `retime` besides the limits of rates, checked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.timing.bounds import InverseDynamics, Jacobian

# Rounding may take positions beyond their limits by this, rad or m.
POSITION_ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class Request:
    """Options of `retime`, checked against the path; see there for what each one means."""

    rate: float
    lower: Float64Array  # position limits (joints,), rad or m
    upper: Float64Array  # the same from above
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
        if self.tip_speed is not None and self.jacobian is None:
            raise InvalidInput("jacobian: expected a function beside tip_speed, got None")
        for name in ("jacobian", "inverse_dynamics"):
            value = getattr(self, name)
            if value is not None and not callable(value):
                raise InvalidInput(f"{name}: expected a function, got {type(value).__name__}")

    def keeps_positions(self, q: Float64Array) -> bool:
        """Whether configurations (n, joints) lie inside the position limits, but for rounding."""
        outside = np.maximum(self.lower - q, q - self.upper)
        return bool(outside.max() <= POSITION_ROUNDING)

    @property
    def along_lines(self) -> bool:
        """Whether straight lines between rests have a motion in closed form."""
        bounds = (self.not_before, self.tip_speed, self.inverse_dynamics)
        velocities = (self.start_velocity, self.end_velocity)
        return all(bound is None for bound in bounds) and not any(
            velocity is not None and velocity.any() for velocity in velocities
        )

    def between_rests(self, *, first: bool, last: bool) -> Request:
        """The request for a part of the path."""
        return replace(
            self,
            start_velocity=self.start_velocity if first else None,
            end_velocity=self.end_velocity if last else None,
        )


def checked_holds(holds: Mapping[int, float] | None, rows: int) -> dict[int, float]:
    """Seconds of rest by row; none where `holds` is None."""
    if holds is None:
        return {}
    if not isinstance(holds, Mapping):
        what = type(holds).__name__
        raise InvalidInput(f"holds: expected a mapping from rows to seconds, got {what}")
    return {
        check.integer(row, "holds", at_least=0, at_most=rows - 1): check.number(
            time, f"holds[{row}]", at_least=0.0
        )
        for row, time in holds.items()
    }


def checked_schedule(not_before: ArrayLike | None, rows: int) -> Float64Array | None:
    """A time, s, for every row, or None."""
    if not_before is None:
        return None
    return check.array(check.times(not_before, "not_before"), "not_before", shape=(rows,))


def checked_velocity(velocity: ArrayLike | None, name: str, joints: int) -> Float64Array | None:
    """A velocity (joints,), or None."""
    return None if velocity is None else check.frozen(velocity, name, shape=(joints,))


def checked_tip_speed(tip_speed: float | None) -> float | None:
    """A speed > 0 in m/s, or None."""
    return None if tip_speed is None else check.number(tip_speed, "tip_speed", above=0.0)

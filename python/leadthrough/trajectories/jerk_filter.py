"""A time-optimal reference with bounded jerk: the one of second order, averaged.

The mean of the last N samples has the velocities and accelerations of these samples' means, inside
the same limits; its acceleration changes in a period T by at most 2 a / N, so that N = 2 a / (j T)
keeps the jerk below j. It comes to rest on its target N samples after what it averages, and
neither passes it nor chatters.
Source: Biagiotti and Melchiorri 2012, "FIR filters for online trajectory planning".
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.trajectories.filters import (
    FilterState,
    TimeOptimalFilter,
    check_period,
    rate_limit,
)

_MOST_SAMPLES = 100_000


@dataclass(frozen=True, eq=False)
class JerkFilterState(FilterState):
    """The averaged reference; inner: the last one of second order; recent: (N, 3, d) of these."""

    inner: FilterState
    recent: Float64Array


@dataclass(frozen=True, eq=False)
class JerkFilter:
    """To rest at a target inside limits of velocity, acceleration and jerk, > 0, every period, s.

    Limits: (d,) or one number for all. Raises InvalidInput.
    """

    velocity: Any
    acceleration: Any
    jerk: Any
    period: float
    samples: int = field(init=False)

    def __post_init__(self) -> None:
        inner = TimeOptimalFilter(self.velocity, self.acceleration)
        jerk, period = rate_limit(self.jerk, "jerk"), check_period(self.period)
        ratio = float(np.max(2.0 * inner.acceleration / jerk)) / period
        if ratio > _MOST_SAMPLES:
            raise InvalidInput(f"jerk: expected limits that {_MOST_SAMPLES} samples can keep")
        object.__setattr__(self, "jerk", jerk)
        object.__setattr__(self, "period", period)
        object.__setattr__(self, "samples", max(1, math.ceil(ratio - 1e-9)))

    def at_rest(self, position: Any) -> JerkFilterState:
        """The state at rest at a position (d,). Raises InvalidInput."""
        inner = FilterState.at_rest(position)
        rows = np.stack([inner.position, inner.velocity, inner.acceleration])
        return self._state(inner, np.repeat(rows[None], self.samples, axis=0))

    def step(self, state: JerkFilterState, target: Any) -> JerkFilterState:
        """The state one period on, towards a target (d,). Raises InvalidInput."""
        if not isinstance(state, JerkFilterState) or len(state.recent) != self.samples:
            raise InvalidInput("state: expected one of this filter; begin with at_rest")
        goal = check.array(target, "target", shape=state.position.shape)
        filtered = TimeOptimalFilter(self.velocity, self.acceleration)
        inner = filtered.step(state.inner, goal, self.period)
        row = np.stack([inner.position, inner.velocity, inner.acceleration])
        return self._state(inner, np.concatenate([state.recent[1:], row[None]]))

    @staticmethod
    def _state(inner: FilterState, recent: Float64Array) -> JerkFilterState:
        # About the last sample, so that equal samples have exactly their own value for a mean.
        means = recent[-1] + (recent - recent[-1]).mean(axis=0)
        return JerkFilterState(means[0], means[1], means[2], inner, recent)

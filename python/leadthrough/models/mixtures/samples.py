"""Demonstrations as the points that a mixture is fitted to: the time first, then the columns."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.models.chart import Chart, chart_of
from leadthrough.models.demonstrated import Demonstrations, motions_of
from leadthrough.models.mean_turning import mean_orientations
from leadthrough.models.out_of_step import warn_of_others_timing
from leadthrough.motion import Motion, MotionT, MotionT_co, normalised_times

# Points of each demonstration, so that all count the same and the work is bounded.
SAMPLES = 200


@dataclass(frozen=True, eq=False)
class Sampled(Generic[MotionT_co]):
    """Demonstrations, resampled at evenly spaced times.

    Attributes:
        motions: the demonstrated motions.
        phases: normalised times (n,) of each motion's samples.
        chart: what the d columns mean.
        duration: median duration of the motions, s, to which all are stretched.
        rows: points (200, 1 + d) of each motion, the time first, s.
    """

    motions: Sequence[MotionT_co]
    phases: Sequence[Float64Array]
    chart: Chart[MotionT_co]
    duration: float
    rows: Sequence[Float64Array]

    @property
    def points(self) -> Float64Array:
        """The points (n, 1 + d) of all motions."""
        return np.concatenate(self.rows)

    @property
    def ends(self) -> Float64Array:
        """Mean start and mean goal (2, d) of the motions."""
        return np.asarray(np.mean([each[[0, -1], 1:] for each in self.rows], axis=0))


def sampled(
    demonstrations: Demonstrations[MotionT],
    *,
    middle: Callable[[Sequence[Float64Array]], Float64Array] = mean_orientations,
) -> Sampled[MotionT]:
    """Demonstrations, resampled at evenly spaced times."""
    motions = motions_of(demonstrations)
    phases = [normalised_times(motion.times) for motion in motions]
    chart = chart_of(motions, phases, middle=middle)
    warn_of_others_timing(motions)
    duration = float(np.median([motion.duration for motion in motions]))
    return Sampled(
        motions, phases, chart, duration, timed_columns(motions, phases, chart, duration)
    )


def timed_columns(
    motions: Sequence[Motion], phases: Sequence[Float64Array], chart: Chart, duration: float
) -> list[Float64Array]:
    """Times, s, and columns (200, 1 + d) of each motion."""
    even = np.linspace(0.0, 1.0, SAMPLES)
    result = []
    for i, (motion, at) in enumerate(zip(motions, phases, strict=True)):
        columns = chart.columns(motion, at, f"demonstrations[{i}]")
        values = [np.interp(even, at, column) for column in columns.T]
        result.append(np.column_stack([even * duration, *values]))
    return result

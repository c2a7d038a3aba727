"""Motions of many weights at the same times: what they share is made once.

New memory takes longer to get than its numbers to compute, and threads wait for one another there:
several motions lie in one block.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property
from typing import Any, Generic, cast

import numpy as np

from leadthrough import _core, check, events, rotations
from leadthrough.check import Float64Array
from leadthrough.computed import computed, computed_joints
from leadthrough.models.chart import Chart, turned_by
from leadthrough.models.many import mapped
from leadthrough.motion import MotionT_co, PoseTrajectory, Trajectory

# Bytes of a block, which stays in memory as long as one of its motions does. Larger ones would be
# asked for anew each time by the usual C library.
_BLOCK = 32 * 2**20
_SURELY_FINITE = 1e300
_NAMES = ("positions", "velocities", "accelerations")


class Drawing(Generic[MotionT_co]):
    """Makes motions of weights.

    Args:
        chart: what their columns are.
        times: (n,) s, which become read-only.
        duration: s, of the motions.
        bases: values (n, k) of the basis functions and, for joints, of their first and second
            derivatives by the phase.
    """

    def __init__(
        self,
        chart: Chart[MotionT_co],
        times: Float64Array,
        duration: float,
        bases: Sequence[Float64Array],
    ) -> None:
        phases = times / duration
        self._chart, self._times, self._duration, self._bases = chart, times, duration, bases
        self._shape = (len(bases), len(times), chart.width)
        self._events = events.moved(chart.events, phases, times)
        self._joints = None if chart.posture is None else chart.posture.along(times, phases)
        self._reference = None if chart.reference is None else chart.reference_at(phases)

    def motions(self, weights: Float64Array, threads: int) -> list[MotionT_co]:
        """A motion for each of several weights.

        Args:
            weights: (m, d k), one column after the other.
            threads: their number, 1 to 256; does not change the motions.

        Raises:
            InvalidInput: for another number of threads, or where a number is not finite.
        """
        places = self._places(len(weights))
        # The sum of so many products cannot overflow: no value of a motion need be looked at.
        largest = len(self._bases[0].T) * self._peak * float(np.abs(weights).max())
        certain = largest < _SURELY_FINITE
        asked = ((*each, certain) for each in zip(weights, places, strict=True))
        return mapped(self._motion, asked, threads)

    @cached_property
    def _peak(self) -> float:
        """The largest absolute value of the basis functions and their derivatives by time."""
        return max(
            max(float(rows.max()), -float(rows.min())) * max(self._duration**-order, 1.0)
            for order, rows in enumerate(self._bases)
        )

    def _places(self, count: int) -> list[Float64Array | None]:
        """Where the values of each motion go that are its own arrays; those of poses are not."""
        if self._reference is not None:
            return [None] * count
        together = max(1, _BLOCK // (8 * math.prod(self._shape)))
        # Nothing is written yet: threads get what they write to from the system side by side.
        return [
            place
            for first in range(0, count, together)
            for place in np.empty((min(together, count - first), *self._shape))
        ]

    def _compute(self, weights: Float64Array, values: Float64Array, *, certain: bool) -> None:
        """Writes columns (n, d) and their derivatives by time, certain to be finite or not."""
        curves = weights.reshape(self._chart.width, -1).T
        for order, rows in enumerate(self._bases):
            np.matmul(rows, curves, out=values[order])
            if order > 0:
                values[order] *= self._duration**-order
        if not certain and not _core.all_finite(values):
            for rows, name in zip(values, _NAMES, strict=False):
                check.array(rows, name, shape=rows.shape)

    def _motion(self, asked: tuple[Float64Array, Float64Array | None, bool]) -> MotionT_co:
        """The motion of weights, whose values are written to a place if there is one.

        asked: weights, the place, and whether the values are certain to be finite.
        """
        weights, place, certain = asked
        values = np.empty(self._shape) if place is None else place
        self._compute(weights, values, certain=certain)
        chart, times = self._chart, self._times
        made: Any
        if chart.kind == "joints":
            names = chart.joint_names
            made = computed_joints(times, *values, joint_names=names, events=self._events)
        elif self._reference is None:
            made = computed(
                Trajectory,
                times=times,
                positions=values[0],
                events=self._events,
                joints=self._joints,
            )
        else:
            turned = turned_by(self._reference, values[0, :, 3:])
            made = computed(
                PoseTrajectory,
                times=times,
                positions=values[0, :, :3].copy(),
                orientations=rotations.align_signs(turned),
                events=self._events,
                joints=self._joints,
            )
        return cast(MotionT_co, made)  # of the type that the chart was made for

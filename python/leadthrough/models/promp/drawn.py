"""Motions of many weights at the same times: what they share is made once.

New memory takes longer to get than its numbers to compute, and threads wait for one another there:
several motions lie in one block.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Generic, cast

import numpy as np

from leadthrough import check, events, rotations
from leadthrough.check import Float64Array
from leadthrough.computed import computed, computed_joints
from leadthrough.models.chart import Chart, turned_by
from leadthrough.models.many import mapped
from leadthrough.motion import MotionT_co, PoseTrajectory, Trajectory

# Bytes of a block, which stays in memory as long as one of its motions does.
_BLOCK = 8 * 2**20


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
        each = 8 * len(self._bases) * len(self._times) * self._chart.width
        size = max(1, _BLOCK // each)
        runs = [weights[i : i + size] for i in range(0, len(weights), size)]
        return [motion for run in mapped(self._run, runs, threads) for motion in run]

    def _run(self, weights: Float64Array) -> list[MotionT_co]:
        block = np.empty((len(weights), len(self._bases), len(self._times), self._chart.width))
        for own, values in zip(weights, block, strict=True):
            self._compute(own, values)
        block.setflags(write=False)
        return [self._motion(values) for values in block]

    def _compute(self, weights: Float64Array, values: Float64Array) -> None:
        """Writes columns (n, d) and their derivatives by time."""
        curves = weights.reshape(self._chart.width, -1).T
        names = ("positions", "velocities", "accelerations")
        for order, (rows, name) in enumerate(zip(self._bases, names, strict=False)):
            np.matmul(rows, curves, out=values[order])
            if order > 0:
                values[order] *= self._duration**-order
            check.array(values[order], name, shape=values[order].shape)

    def _motion(self, values: Float64Array) -> MotionT_co:
        chart, times = self._chart, self._times
        made: Any
        if chart.kind == "joints":
            names = chart.joint_names
            made = computed_joints(times, *values, joint_names=names, events=self._events)
        elif self._reference is None:
            along = {"events": self._events, "joints": self._joints}
            made = computed(Trajectory, times=times, positions=values[0], **along)
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

"""Motions of many weights at the same times: what they share is made once.

New memory takes longer to get than its numbers to compute, and threads wait for one another there:
several motions lie in one block.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Generic, cast

import numpy as np

from leadthrough import _core, check, events, rotations
from leadthrough.check import Float64Array
from leadthrough.models.chart import Chart, turned_by
from leadthrough.models.promp.basis import Basis
from leadthrough.models.queries import checked_threads, mapped
from leadthrough.motion import (
    JointTrajectory,
    MotionT_co,
    PoseTrajectory,
    Trajectory,
    computed,
    computed_joints,
)

# Bytes of a block, which stays in memory as long as one of its motions does. Larger ones would be
# asked for anew each time by the usual C library.
_BLOCK = 32 * 2**20
_NAMES = ("positions", "velocities", "accelerations")


class Drawing(Generic[MotionT_co]):
    """Makes motions of weights."""

    def __init__(
        self, chart: Chart[MotionT_co], basis: Basis, times: Float64Array, duration: float
    ) -> None:
        self._chart, self._basis, self._times = chart, basis, times
        self._phases = phases = times / duration
        orders = 3 if chart.kind == "joints" else 1
        self._paces = duration ** -np.arange(orders, dtype=np.float64)
        self._together = max(1, _BLOCK // (8 * orders * len(times) * chart.width))
        self._events = events.moved(chart.events, phases, times)
        self._joints = None if chart.posture is None else chart.posture.along(times, phases)
        self._reference = None if chart.reference is None else chart.reference_at(phases)

    def motions(self, weights: Float64Array, threads: int) -> list[MotionT_co]:
        """A motion for each of several weights."""
        checked_threads(threads)
        made: list[Any]  # of the type that the chart was made for
        if self._chart.kind == "joints":
            made = [self._joint_motion(values) for values in self._curves(weights, threads)]
        elif self._reference is None:
            made = [self._points(values) for values in self._curves(weights, threads)]
        else:
            made = []
            for first in range(0, len(weights), self._together):
                some = weights[first : first + self._together]
                made += mapped(self._poses, self._curves(some, threads), threads)
        return cast(list[MotionT_co], made)

    def _curves(self, weights: Float64Array, threads: int) -> Iterator[Float64Array]:
        """The columns (1, n, d) of each motion, of joints with their derivatives (3, n, d)."""
        blocks, certain = self._basis.curves(
            self._phases, weights, self._paces, most=self._together, threads=threads
        )
        for block in blocks:
            if not certain and not _core.all_finite(block):
                _refuse_infinite(block)
            yield from block

    def _joint_motion(self, values: Float64Array) -> JointTrajectory:
        names = self._chart.joint_names
        return computed_joints(self._times, *values, joint_names=names, events=self._events)

    def _points(self, values: Float64Array) -> Trajectory:
        return computed(
            Trajectory,
            times=self._times,
            positions=values[0],
            events=self._events,
            joints=self._joints,
        )

    def _poses(self, values: Float64Array) -> PoseTrajectory:
        assert self._reference is not None
        return computed(
            PoseTrajectory,
            times=self._times,
            positions=values[0, :, :3].copy(),
            orientations=rotations.align_signs(turned_by(self._reference, values[0, :, 3:])),
            events=self._events,
            joints=self._joints,
        )


def _refuse_infinite(block: Float64Array) -> None:
    for values in block:
        for rows, name in zip(values, _NAMES, strict=False):
            check.array(rows, name, shape=rows.shape)

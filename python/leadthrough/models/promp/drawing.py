"""Motions of many weights at the same times, which share their basis functions, events and joints.

New memory takes longer to get than its numbers to compute, and threads wait for one another there:
several motions lie in one block.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Generic, cast

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check, rotations
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.models.coordinates import Coordinates, rotated_by
from leadthrough.models.promp.basis import Basis
from leadthrough.models.queries import asked_times, checked_threads, mapped
from leadthrough.motion import (
    JointTrajectory,
    MotionT_co,
    PoseTrajectory,
    Trajectory,
    computed,
    computed_joints,
    moved_events,
)

# Bytes of a block, which stays in memory as long as one of its motions does. Larger ones would be
# asked for anew each time by the usual C library.
_BLOCK = 32 * 2**20
_NAMES = ("positions", "velocities", "accelerations")
# A time may lie this fraction of the duration outside the motion, by rounding: evenly spaced times
# up to the duration may end an ulp beyond it.
_ROUNDING = 1e-9


class Drawing(Generic[MotionT_co]):
    """Makes motions of weights."""

    def __init__(
        self,
        coordinates: Coordinates[MotionT_co],
        basis: Basis,
        times: Float64Array,
        duration: float,
    ) -> None:
        self._coordinates, self._basis, self._times = coordinates, basis, times
        self._phases = phases = times / duration
        orders = 3 if coordinates.kind == "joints" else 1
        self._paces = duration ** -np.arange(orders, dtype=np.float64)
        self._together = max(1, _BLOCK // (8 * orders * len(times) * coordinates.width))
        self._events = moved_events(coordinates.events, phases, times)
        self._joints = (
            None if coordinates.posture is None else coordinates.posture.along(times, phases)
        )
        self._reference = (
            None if coordinates.reference is None else coordinates.reference_at(phases)
        )

    def motions(self, weights: Float64Array, threads: int) -> list[MotionT_co]:
        """A motion for each of several weights."""
        checked_threads(threads)
        made: list[Any]  # of the type that the coordinates was made for
        if self._coordinates.kind == "joints":
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
            if not certain and not core.all_finite(block):
                _refuse_infinite(block)
            yield from block

    def _joint_motion(self, values: Float64Array) -> JointTrajectory:
        names = self._coordinates.joint_names
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
            orientations=rotations.align_signs(rotated_by(self._reference, values[0, :, 3:])),
            events=self._events,
            joints=self._joints,
        )


def _refuse_infinite(block: Float64Array) -> None:
    for values in block:
        for rows, name in zip(values, _NAMES, strict=False):
            check.array(rows, name, shape=rows.shape)


def phases_at(
    times: ArrayLike, name: str, *, duration: float, repeats: bool, at_least: int = 0
) -> Float64Array:
    """Phases (n,) at times of a motion."""
    phases = asked_times(times, name, at_least=at_least) / duration
    if repeats or len(phases) == 0:
        return phases
    if len(phases) == 1:  # the quick way: via points come one at a time
        first = last = float(phases[0])
    else:
        first, last = float(phases.min()), float(phases.max())
    if first < -_ROUNDING or last > 1.0 + _ROUNDING:
        outside = (first if first < -_ROUNDING else last) * duration
        raise InvalidInput(
            f"{name}: expected times in [0, {duration:.6g}] s, the motion's duration, "
            f"got {outside:.6g} s"
        )
    return phases if first >= 0.0 and last <= 1.0 else np.clip(phases, 0.0, 1.0)

"""Frames that move with a task, and motions and distributions seen from them.

Seen from a frame, points and joints are shifted and rotated. Orientations of poses are rotated too,
and written as rotation vectors in the tangent spaces along the frame's own reference. For the
frames of a new situation these references are averaged, and each frame's Gaussians are carried into
the tangent spaces of the mean reference to first order.

Source: Zeestraten et al. 2017, "An approach for imitation learning on Riemannian manifolds",
section III-C.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from leadthrough import rotations
from leadthrough.check import Float64Array
from leadthrough.errors import FitError, InvalidInput, NoContinuousLogarithm
from leadthrough.models.chart import NODES, Chart, carried
from leadthrough.models.frame import Frame
from leadthrough.models.mean_turning import mean_orientations
from leadthrough.motion import MotionT

# Half the span of phases over which a drift is measured by finite differences.
_AROUND = 2.5e-3


@dataclass(frozen=True, eq=False)
class Placed:
    """A frame's k Gaussians, in the common columns of a situation.

    Attributes:
        means: means (k, w).
        maps: matrices (k, w, w) that carry deviations from the frame's own columns.
        drift: rates (k, w) at which the means change because the reference moves on, per second.
    """

    means: Float64Array
    maps: Float64Array
    drift: Float64Array


def common_chart(
    chart: Chart[MotionT], own: Sequence[Chart], frames: Sequence[Frame]
) -> Chart[MotionT]:
    """A chart whose reference is the mean of the frames' own, seen from the base frame."""
    if chart.kind != "poses":
        return chart
    predicted = [_predicted(each, frame, NODES) for each, frame in zip(own, frames, strict=True)]
    try:
        return replace(chart, reference=mean_orientations(predicted))
    except FitError:  # frames turned against each other, which a situation may ask for
        return replace(chart, reference=_between(predicted))


def placed(frame: Frame, own: Chart, common: Chart, means: Float64Array, duration: float) -> Placed:
    """A frame's Gaussians, carried from its own columns into the common ones."""
    size, count = own.size, len(means)
    means, phases = means[:, 1:], np.clip(means[:, 0] / duration, 0.0, 1.0)
    moved = means[:, :size] @ frame.axes.T + frame.origin
    if own.kind != "poses":
        maps = np.broadcast_to(frame.axes, (count, size, size))
        return Placed(moved, maps, np.zeros_like(moved))

    def tangent(at: Float64Array) -> Float64Array:
        turned = rotations.compose(_predicted(own, frame, at), rotations.exp(means[:, 3:]))
        return common.tangent(turned, at)

    here = tangent(phases)
    before, after = np.maximum(phases - _AROUND, 0.0), np.minimum(phases + _AROUND, 1.0)
    drift = (tangent(after) - tangent(before)) / (duration * (after - before))[:, None]
    maps = np.zeros((count, 6, 6))
    maps[:, :3, :3] = frame.axes
    maps[:, 3:, 3:] = carried(means[:, 3:], here)
    return Placed(np.hstack([moved, here]), maps, np.hstack([np.zeros((count, 3)), drift]))


def checked_frames(
    frames: Sequence[Sequence[Frame]], count: int, chart: Chart
) -> list[tuple[Frame, ...]]:
    """The frames of each of several demonstrations."""
    if not isinstance(frames, Sequence) or len(frames) != count:
        got = len(frames) if isinstance(frames, Sequence) else type(frames).__name__
        raise InvalidInput(
            f"frames: expected one sequence of frames per demonstration, {count}, got {got}"
        )
    given = [tuple(each) for each in frames]
    for frame in (frame for each in given for frame in each):
        if not isinstance(frame, Frame) or len(frame.origin) != chart.size:
            got = len(frame.origin) if isinstance(frame, Frame) else type(frame).__name__
            raise InvalidInput(f"frames: expected frames of {chart.size} dimensions, got {got}")
        if chart.kind == "poses" and np.linalg.det(frame.axes) < 0.0:
            raise InvalidInput("frames: expected right-handed axes for poses")
    if len({len(each) for each in given}) != 1 or not given[0]:
        numbers = sorted({len(each) for each in given})
        raise InvalidInput(
            "frames: expected the same number of frames for every demonstration, at least one, "
            f"got {', '.join(map(str, numbers))}"
        )
    return given


def _between(predicted: Sequence[Float64Array]) -> Float64Array:
    """Orientations (n, 4) between several rows of them, without a jump where they are far apart."""
    back = rotations.inverse(predicted[0])
    try:
        turns = [rotations.lift(rotations.compose(back, each)) for each in predicted]
    except NoContinuousLogarithm:
        return rotations.align_signs(predicted[0])
    middle = rotations.exp(np.mean(turns, axis=0))
    return rotations.align_signs(rotations.compose(predicted[0], middle))


def _predicted(own: Chart, frame: Frame, phases: Float64Array) -> Float64Array:
    """A frame's reference orientation (n, 4) in the base frame."""
    return rotations.compose(frame.orientations(len(phases)), own.reference_at(phases))

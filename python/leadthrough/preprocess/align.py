"""Demonstrations of different timing, aligned in time.

Dynamic time warping (Sakoe and Chiba 1978) brings every demonstration to the mean timing of all,
around a mean that is warped along with them (Petitjean et al. 2011, "A global averaging method for
dynamic time warping"). Alignment by arc length gives all a constant speed, so that pauses vanish.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from leadthrough import _core, check, events, rotations
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.motion import (
    Demonstration,
    JointTrajectory,
    Motion,
    MotionT,
    PoseTrajectory,
    as_demonstration,
    normalised_times,
)

# Samples at which motions are compared; a path of pairs takes a byte for each pair.
_COMPARED = 1000
# Rounds in which the mean curve and the warps to it are improved in turn.
_ROUNDS = 3
# What the whole duration counts as, in the motion's extent: much where demonstrations are about in
# step, as then their small differences in timing belong to their shapes, and little where warping
# takes away more than half of their spread, as with pauses of some of them.
_USUAL_RIGIDITY, _LEAST_RIGIDITY = 2.0, 0.03
_OUT_OF_STEP = 0.45
_SMOOTHED = 21  # samples of a warp that are averaged
# A smaller turn counts as if it were this large: what is left of it is mostly noise.
_LEAST_TURN = 0.1  # rad
# The Frobenius distance of two rotation matrices is this times their angle, if that is small.
_CHORD = np.sqrt(2.0)
# Steps shorter than this fraction of the motion's extent are trembling of the hand or noise of the
# sensor: summed over a pause they would count as distance.
_TREMBLING = 2e-3


def align_by_time_warping(
    demonstrations: Sequence[Demonstration[MotionT] | MotionT], *, reference: int | None = None
) -> list[Demonstration[MotionT]]:
    """The demonstrations with their mean timing, all at the same 1000 times.

    What happens at some fraction of the duration happens in the demonstrations at that fraction
    on average. Positions and orientations are compared, each in units of its extent; events
    follow. Velocities and accelerations of joints are left out, as they no longer fit.

    Args:
        demonstrations: at least one, all of one type and size, two samples or more each; a motion
            stands for a demonstration of it.
        reference: index of one whose timing and duration all others take, instead of the mean's.

    Raises:
        InvalidInput: if the demonstrations don't fit, or there is none of that index.
    """
    shown = _comparable(demonstrations)
    features = _features(shown)
    durations = [each.motion.duration for each in shown]
    if reference is None:
        total = float(np.mean(durations))
        first = features[int(np.argmin(durations))]
        warps = _mean_timing(features, first, rigidity=_USUAL_RIGIDITY)
        free = _mean_timing(features, first, rigidity=_LEAST_RIGIDITY)
        if _spread(features, free) < _OUT_OF_STEP * _spread(features, None):
            warps = free
    else:
        chosen = check.integer(reference, "reference", at_least=0, at_most=len(shown) - 1)
        total = durations[chosen]
        warps = [_warp(features[chosen], each, rigidity=_LEAST_RIGIDITY) for each in features]
    times = np.linspace(0.0, total, _COMPARED)
    return [
        Demonstration(_retimed(each.motion, warp, times), each.name)
        for each, warp in zip(shown, warps, strict=True)
    ]


def align_by_arc_length(
    demonstrations: Sequence[Demonstration[MotionT] | MotionT],
) -> list[Demonstration[MotionT]]:
    """The demonstrations at constant speed, all at the same 1000 times.

    All take the median of their durations. Pauses and trembling vanish. Velocities and
    accelerations of joints are left out.

    Args:
        demonstrations: at least one, all of one type and size, two samples or more each; a motion
            stands for a demonstration of it.

    Raises:
        InvalidInput: if the demonstrations don't fit, or one does not move.
    """
    shown = _comparable(demonstrations)
    total = float(np.median([each.motion.duration for each in shown]))
    times = np.linspace(0.0, total, _COMPARED)
    result = []
    for i, each in enumerate(shown):
        at, covered = _distance(each.motion, f"demonstrations[{i}]")
        fractions = np.interp(np.linspace(0.0, covered[-1], _COMPARED), covered, at)
        result.append(Demonstration(_retimed(each.motion, fractions, times), each.name))
    return result


def _comparable(
    demonstrations: Sequence[Demonstration[MotionT] | MotionT],
) -> list[Demonstration[MotionT]]:
    if not isinstance(demonstrations, Sequence):
        got = type(demonstrations).__name__
        raise InvalidInput(
            f"demonstrations: expected a sequence of demonstrations, got one {got}; "
            "put a single one in a list"
        )
    if not demonstrations:
        raise InvalidInput("demonstrations: expected at least one, got none")
    shown = [
        as_demonstration(each, f"demonstrations[{i}]") for i, each in enumerate(demonstrations)
    ]
    for i, each in enumerate(shown):
        if len(each.motion.times) < 2:
            raise InvalidInput(f"demonstrations[{i}]: expected at least two samples, got one")
    if len({(type(each.motion), each.motion.positions.shape[1]) for each in shown}) > 1:
        raise InvalidInput(
            "demonstrations: expected one type of motion and the same number of columns in all"
        )
    return shown


def _positions_at(motion: Motion, fractions: Float64Array) -> Float64Array:
    own = normalised_times(motion.times)
    return np.column_stack([np.interp(fractions, own, column) for column in motion.positions.T])


def _retimed(motion: MotionT, fractions: Float64Array, times: Float64Array) -> MotionT:
    """The motion at fractions (n,) of its duration, which are now at times (n,)."""
    parts: dict[str, Any] = {
        "times": times,
        "positions": _positions_at(motion, fractions),
        "events": events.moved(motion.events, motion.times[0] + fractions * motion.duration, times),
    }
    if isinstance(motion, PoseTrajectory):
        own = normalised_times(motion.times)
        parts["orientations"] = rotations.interpolate(own, motion.orientations, fractions)
    if isinstance(motion, JointTrajectory):
        parts |= {"velocities": None, "accelerations": None}
    elif (joints := motion.joints) is not None:
        rows = _positions_at(joints, fractions)
        parts["joints"] = JointTrajectory(times, rows, joint_names=joints.joint_names)
    return replace(motion, **parts)


def _features(shown: Sequence[Demonstration[Any]]) -> list[Float64Array]:
    """What is compared, (1000, m) at evenly spaced times, in units of the motions' extent.

    Orientations enter as rotation matrices, of which half turns and signs are no special cases.
    """
    even = np.linspace(0.0, 1.0, _COMPARED)
    positions = [_positions_at(each.motion, even) for each in shown]
    extent = float(np.mean([np.linalg.norm(np.ptp(each, axis=0)) for each in positions])) or 1.0
    features = [each / extent for each in positions]
    if not isinstance(shown[0].motion, PoseTrajectory):
        return features
    turned = [
        rotations.interpolate(normalised_times(each.motion.times), each.motion.orientations, even)
        for each in shown
    ]
    reach = np.mean(
        [rotations.distance(each, each[:1].repeat(_COMPARED, 0)).max() for each in turned]
    )
    unit = _CHORD * max(float(reach), _LEAST_TURN)
    return [
        np.hstack([own, rotations.to_matrix(each).reshape(-1, 9) / unit])
        for own, each in zip(features, turned, strict=True)
    ]


def _spread(features: Sequence[Float64Array], warps: Sequence[Float64Array] | None) -> float:
    """Root mean square distance of curves (1000, m) from their mean, warped or as they are."""
    pairs = zip(warps, features, strict=True) if warps else ()
    curves = [_curve_at(warp, each) for warp, each in pairs] or features
    return float(np.sqrt(np.var(curves, axis=0).sum(axis=1).mean()))


def _mean_timing(
    features: Sequence[Float64Array], first: Float64Array, *, rigidity: float
) -> list[Float64Array]:
    """For each curve (1000, m) its fractions (1000,) of the duration at those of the mean timing.

    Args:
        features: the curves.
        first: the curve that they are warped to at first, then to their mean.
        rigidity: see `_warp`.
    """
    even = np.linspace(0.0, 1.0, _COMPARED)
    middle = first
    for _ in range(_ROUNDS):
        warps = [_warp(middle, each, rigidity=rigidity) for each in features]
        back = np.interp(even, np.mean(warps, axis=0), even)
        warps = [np.interp(back, even, warp) for warp in warps]
        pairs = list(zip(warps, features, strict=True))
        middle = np.mean([_curve_at(warp, each) for warp, each in pairs], axis=0)
    return warps


def _warp(middle: Float64Array, curve: Float64Array, *, rigidity: float) -> Float64Array:
    """Fractions (1000,) of a curve's duration that belong to those of another, end to end.

    A difference in time counts as a distance too, so that noise is not matched with noise at any
    price; and the warp is smoothed, so that its steps do not become steps of the motion.

    Args:
        middle: the curve (1000, m) that sets the timing.
        curve: the curve (1000, m) to warp.
        rigidity: what the whole duration counts as, in the motion's extent.
    """
    even = np.linspace(0.0, 1.0, _COMPARED)
    timed = [np.column_stack([each, rigidity * even]) for each in (middle, curve)]
    late = _mean_partner(_core.dtw_path(*timed)) / (_COMPARED - 1.0) - even
    # Mirrored through both ends, where it is 0, by as much as two averages take away.
    late = np.pad(late, _SMOOTHED - 1, mode="reflect", reflect_type="odd")
    for _ in range(2):
        late = np.convolve(late, np.full(_SMOOTHED, 1.0 / _SMOOTHED), mode="valid")
    warp = np.clip(even + late, 0.0, 1.0)
    warp[[0, -1]] = 0.0, 1.0
    return np.asarray(np.maximum.accumulate(warp))


def _curve_at(fractions: Float64Array, curve: Float64Array) -> Float64Array:
    even = np.linspace(0.0, 1.0, len(curve))
    return np.column_stack([np.interp(fractions, even, column) for column in curve.T])


def _mean_partner(pairs: NDArray[np.integer[Any]]) -> Float64Array:
    """For each sample of the first curve the mean index of those paired with it, end to end."""
    first, second = pairs[:, 0], pairs[:, 1]
    partners = np.bincount(first, second) / np.bincount(first)
    partners[[0, -1]] = second[[0, -1]]
    return np.asarray(partners)


def _distance(motion: Motion, name: str) -> tuple[Float64Array, Float64Array]:
    """Fractions of the duration, and the distance covered up to each, without trembling."""
    points = motion.positions
    least = _TREMBLING * float(np.linalg.norm(np.ptp(points, axis=0)))
    if least == 0.0:
        raise InvalidInput(f"{name}: does not move; leave it out")
    kept = [0]
    for i in range(1, len(points)):
        if np.linalg.norm(points[i] - points[kept[-1]]) >= least:
            kept.append(i)
    if kept[-1] != len(points) - 1:
        kept[-1 if len(kept) > 1 else 1 :] = [len(points) - 1]
    covered = np.cumsum(np.linalg.norm(np.diff(points[kept], axis=0), axis=1))
    return normalised_times(motion.times)[kept], np.concatenate([[0.0], covered])

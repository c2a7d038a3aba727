"""Demonstrations aligned in time, and distances of curves whose points are paired in order.

Dynamic time warping (Sakoe and Chiba 1978) brings each demonstration to the mean timing of all,
around a mean that is warped along with them (Petitjean et al. 2011, "A global averaging method for
dynamic time warping"). Demonstrations clearly out of step are warped freely; the others rigidly, if
the mean of the rest then predicts a left-out demonstration better; else not at all.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

import leadthrough._core as core
from leadthrough import check, rotations
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.motion import (
    Demonstration,
    JointTrajectory,
    Motion,
    MotionT,
    PoseTrajectory,
    alike,
    as_demonstration,
    lerp,
    moved_events,
    normalised_times,
)
from leadthrough.preprocess.moved_ends import with_ends

# Steps shorter than this fraction of the motion's extent are trembling of the hand or noise of the
# sensor: summed over a pause they would count as distance.
_TREMBLING = 2e-3
# Samples at which motions are compared; a path of pairs takes a byte for each pair.
COMPARED = 1000
_ROUNDS = 3
_SMOOTHED, _MAX_SMOOTHED = 0.021, 21  # fraction of a warp that is averaged, and samples
# A smaller turn counts as if it were this large: what is left of it is mostly noise.
MIN_TURN = 0.1  # rad
TURNING = 0.3  # weight of the orientations' extent against the positions', where both are one
# The Frobenius distance of two rotation matrices is this times their angle, if that is small.
_CHORD = np.sqrt(2.0)
# Cost of shifting by one duration, as a fraction of the motion's extent.
FREE = 0.03
_RIGID = 2.0
# Out of step: free warping leaves less than this fraction of the spread.
_OUT_OF_STEP = 0.45
# Clearly so: of a few motions of random shapes, warping leaves 0.42 and more by chance.
_CLEARLY = 0.3
# A gain in predicting left-out demonstrations counts from this many standard errors on, of at least
# so many demonstrations. Fewer samples are enough to tell.
_SURELY = 2.0
_MIN_COUNT = 4
_FEW_SAMPLES, _MIN_SAMPLES = 200, 100
_LATE = 0.15  # fraction of the duration ahead or behind that is reported
_MAX_COMPARED = 12  # demonstrations
# A glance at fewer samples, warped once, leaves at least this fraction of the spread of motions in
# step: twice of what those clearly out of step keep after closer looks.
_GLANCED_SAMPLES, _GLANCED = 40, 2.0 * _CLEARLY
_ROUNDING = 1e-12  # of the motions' extent
_MAX_PAIRS = 10**10  # of points whose distances are compared, in about two minutes


def align_by_time_warping(
    demonstrations: Sequence[Demonstration[MotionT] | MotionT], *, reference: int | None = None
) -> list[Demonstration[MotionT]]:
    """The demonstrations with their mean timing, all at the same times, mostly 1000.

    A point of the motion comes at the demonstrations' mean fraction of the duration. Positions and
    orientations are compared, each in units of its extent; events follow. Velocities and
    accelerations of joints are left out, as they no longer fit.

    Differences in timing stay where taking them away gains nothing beyond chance: if warping
    leaves more than half of the spread, and the mean of the others predicts a left-out
    demonstration no better after it. Demonstrations that also share their times come back as they
    are.

    Args:
        demonstrations: at least one, all of one type and size, two samples or more each; a motion
            stands for a demonstration of it.
        reference: index of one whose timing and duration all others take, instead of the mean's.
    """
    demonstrations = _comparable(demonstrations)
    motions = [each.motion for each in demonstrations]
    durations = [motion.duration for motion in motions]
    if reference is None:
        total, warps = float(np.mean(durations)), fractions_in_step(motions)
        if warps is None:
            if all(np.array_equal(each.times, motions[0].times) for each in motions):
                return demonstrations
            warps = [np.linspace(0.0, 1.0, COMPARED)] * len(demonstrations)
    else:
        chosen = check.integer(reference, "reference", at_least=0, at_most=len(demonstrations) - 1)
        total, curves = durations[chosen], features(motions)
        warps = [warp(curves[chosen], each, rigidity=FREE) for each in curves]
    times = np.linspace(0.0, total, COMPARED)
    return [
        Demonstration(_retimed(each.motion, fractions, times), each.name)
        for each, fractions in zip(demonstrations, warps, strict=True)
    ]


def align_by_arc_length(
    demonstrations: Sequence[Demonstration[MotionT] | MotionT],
) -> list[Demonstration[MotionT]]:
    """The demonstrations at constant speed, all at the same 1000 times.

    All take the median of their durations. Pauses and trembling vanish. Velocities and
    accelerations of joints are left out. Demonstrations are as for `align_by_time_warping`.

    Raises:
        InvalidInput: if the demonstrations don't fit, or one does not move.
    """
    demonstrations = _comparable(demonstrations)
    total = float(np.median([each.motion.duration for each in demonstrations]))
    times = np.linspace(0.0, total, COMPARED)
    result = []
    for i, each in enumerate(demonstrations):
        at, covered = _distance(each.motion, f"demonstrations[{i}]")
        fractions = np.interp(np.linspace(0.0, covered[-1], COMPARED), covered, at)
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
    compared = [
        as_demonstration(each, f"demonstrations[{i}]") for i, each in enumerate(demonstrations)
    ]
    for i, each in enumerate(compared):
        if len(each.motion.times) < 2:
            raise InvalidInput(f"demonstrations[{i}]: expected at least two samples, got one")
    if len({(type(each.motion), each.motion.positions.shape[1]) for each in compared}) > 1:
        raise InvalidInput(
            "demonstrations: expected one type of motion and the same number of columns in all"
        )
    ordered = alike([each.motion for each in compared], "demonstrations")
    return [
        each if motion is each.motion else Demonstration(motion, each.name)
        for each, motion in zip(compared, ordered, strict=True)
    ]


def _retimed(motion: MotionT, fractions: Float64Array, times: Float64Array) -> MotionT:
    """The motion at fractions (n,) of its duration, which are now at times (n,)."""
    parts: dict[str, Any] = {
        "times": times,
        "positions": positions_at(motion, fractions),
        "events": moved_events(motion.events, motion.times[0] + fractions * motion.duration, times),
    }
    if isinstance(motion, PoseTrajectory):
        own = normalised_times(motion.times)
        parts["orientations"] = rotations.interpolate(own, motion.orientations, fractions)
    if isinstance(motion, JointTrajectory):
        parts |= {"velocities": None, "accelerations": None}
    elif (joints := motion.joints) is not None:
        rows = positions_at(joints, fractions)
        parts["joints"] = JointTrajectory(times, rows, joint_names=joints.joint_names)
    return replace(motion, **parts)


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


def positions_at(motion: Motion, fractions: Float64Array) -> Float64Array:
    """Positions (n, d) of a motion at fractions (n,) of its duration."""
    own = normalised_times(motion.times)
    return lerp(fractions, own, motion.positions)


def features(motions: Sequence[Motion], samples: int = COMPARED) -> list[Float64Array]:
    """Rows to compare, (samples, m) at evenly spaced times, in units of the motions' extent."""
    even = np.linspace(0.0, 1.0, samples)
    positions = [positions_at(each, even) for each in motions]
    extent = float(np.mean([np.linalg.norm(np.ptp(each, axis=0)) for each in positions])) or 1.0
    scaled = [each / extent for each in positions]
    orientations = [
        rotations.interpolate(normalised_times(each.times), each.orientations, even)
        for each in motions
        if isinstance(each, PoseTrajectory)
    ]
    if not orientations:
        return scaled
    reach = np.mean(
        [rotations.distance(each, each[:1].repeat(samples, 0)).max() for each in orientations]
    )
    unit = _CHORD * max(float(reach), MIN_TURN)
    return [
        np.hstack([own, rotations.to_matrix(each).reshape(-1, 9) / unit])
        for own, each in zip(scaled, orientations, strict=True)
    ]


def spread(curves: Sequence[Float64Array]) -> float:
    """Root mean square distance of curves (n, m) from their mean."""
    return float(np.sqrt(np.var(curves, axis=0).sum(axis=1).mean()))


def mean_timing(
    curves: Sequence[Float64Array],
    first: Float64Array,
    *,
    rigidity: float,
    rounds: int = _ROUNDS,
) -> list[Float64Array]:
    """For each curve (n, m) its fractions (n,) of the duration at those of the mean timing."""
    even = np.linspace(0.0, 1.0, len(first))
    middle = first
    for _ in range(rounds):
        warps = [warp(middle, each, rigidity=rigidity) for each in curves]
        back = np.interp(even, np.mean(warps, axis=0), even)
        warps = [np.interp(back, even, each) for each in warps]
        middle = np.mean(warped(curves, warps), axis=0)
    return warps


def warp(middle: Float64Array, curve: Float64Array, *, rigidity: float) -> Float64Array:
    """Fractions (n,) of a curve's duration that belong to those of another, end to end."""
    even = np.linspace(0.0, 1.0, len(middle))
    timed = [np.column_stack([each, rigidity * even]) for each in (middle, curve)]
    late = _mean_partner(core.dtw_path(*timed)) / (len(even) - 1.0) - even
    # Mirrored through both ends, where it is 0, by as much as two averages take away.
    window = min(round(_SMOOTHED * len(even)), _MAX_SMOOTHED) | 1
    late = np.concatenate([-late[window - 1 : 0 : -1], late, -late[-2 : -window - 1 : -1]])
    for _ in range(2):
        late = np.convolve(late, np.full(window, 1.0 / window), mode="valid")
    fractions = np.clip(even + late, 0.0, 1.0)
    fractions[[0, -1]] = 0.0, 1.0
    return np.asarray(np.maximum.accumulate(fractions))


def warped(curves: Sequence[Float64Array], warps: Sequence[Float64Array]) -> list[Float64Array]:
    """Curves (n, m) at fractions (n,) of their durations."""
    even = np.linspace(0.0, 1.0, len(curves[0]))
    return [lerp(fractions, even, curve) for curve, fractions in zip(curves, warps, strict=True)]


def _mean_partner(pairs: NDArray[np.integer[Any]]) -> Float64Array:
    """For each sample of the first curve the mean index of those paired with it, end to end."""
    first, second = pairs[:, 0], pairs[:, 1]
    partners = np.bincount(first, second) / np.bincount(first)
    partners[[0, -1]] = second[[0, -1]]
    return np.asarray(partners)


def fractions_in_step(motions: Sequence[Motion]) -> list[Float64Array] | None:
    """Per motion, the fractions (1000,) of its duration that match even ones of the mean."""
    curves = features(motions)
    first = int(np.argmin([motion.duration for motion in motions]))
    free = mean_timing(curves, curves[first], rigidity=FREE)
    if spread(warped(curves, free)) < _OUT_OF_STEP * spread(curves):
        return free
    if _predicts_better(motions):
        return mean_timing(curves, curves[first], rigidity=_RIGID)
    return None


def lateness(motions: Sequence[Motion]) -> Float64Array:
    """How far each motion is ahead of or behind the mean timing, at most."""
    result = np.zeros(len(motions))
    if len(motions) < 2:
        return result
    some = np.linspace(0, len(motions) - 1, min(len(motions), _MAX_COMPARED)).round().astype(int)
    compared = [motions[i] for i in some]
    glanced = features(compared, _GLANCED_SAMPLES)
    warps = mean_timing(glanced, glanced[0], rigidity=FREE, rounds=1)
    if spread(warped(glanced, warps)) > _GLANCED * spread(glanced):
        return result
    curves = features(compared, _MIN_SAMPLES)
    warps = mean_timing(curves, curves[0], rigidity=FREE)
    if spread(warped(curves, warps)) < _CLEARLY * spread(curves):
        late = np.abs(np.array(warps) - np.linspace(0.0, 1.0, _MIN_SAMPLES)).max(axis=1)
        result[some] = np.where(late.max() > _LATE, late, 0.0)
    return result


def _predicts_better(motions: Sequence[Motion]) -> bool:
    """Whether means of rigidly warped motions predict left-out ones better than those of others."""
    if len(motions) < _MIN_COUNT:
        return False
    curves = features(motions, _FEW_SAMPLES)
    size = motions[0].positions.shape[1]
    gains = []
    for i, left_out in enumerate(curves):
        others = [each for j, each in enumerate(curves) if j != i]
        warps = mean_timing(others, others[0], rigidity=_RIGID)
        before = _errors(others, left_out, size)
        gains.append(1.0 - _errors(warped(others, warps), left_out, size) / before)
    gain, deviation = np.mean(gains, axis=0), np.std(gains, axis=0, ddof=1)
    error = deviation / np.sqrt(len(gains))
    return bool(gain[0] > _SURELY * error[0] and (gain > -error).all())


def _errors(curves: Sequence[Float64Array], left_out: Float64Array, size: int) -> Float64Array:
    """Errors of the mean of curves, carried to the ends of the left-out one."""
    carried = [with_ends(each, left_out[0], left_out[-1]) for each in curves]
    missed = np.mean(carried, axis=0) - left_out
    path, wanted = (missed + left_out)[:, :size], left_out[:, :size]
    groups = [missed[:, :size], missed[:, size:]][: 1 + (missed.shape[1] > size)]
    distances = [float(np.linalg.norm(group, axis=1).mean()) for group in groups]
    return np.array([dtw_distance(path, wanted) / len(wanted), *distances]) + _ROUNDING


def dtw_distance(a: ArrayLike, b: ArrayLike, *, band: int | None = None) -> float:
    """The dynamic time warping distance: the smallest sum of distances over paired points.

    Args:
        a: points (n, d) of the first curve.
        b: points (m, d) of the second curve.
        band: largest difference of paired rows, in rows of the shorter curve from the table's
            diagonal; None: any. The time is that of the pairs within it, 10 ns each.

    Returns:
        The sum, in the curves' unit.

    Raises:
        InvalidInput: if more than 10^10 pairs are to be compared.

    Source: Sakoe and Chiba 1978, with symmetric steps of weight one.
    """
    return _finite(core.dtw_distance(*_paired(a, b, band)))


def frechet_distance(a: ArrayLike, b: ArrayLike, *, band: int | None = None) -> float:
    """The discrete Frechet distance: the smallest possible largest distance of paired points.

    Arguments, result and errors are as of `dtw_distance`.

    Source: Eiter and Mannila 1994; the band: Sakoe and Chiba 1978.
    """
    return _finite(core.frechet_distance(*_paired(a, b, band)))


def _paired(a: ArrayLike, b: ArrayLike, band: int | None) -> tuple[Float64Array, Float64Array, int]:
    """The curves and the width of the band, if all its pairs can be compared in minutes."""
    first, second = _curves(a, b)
    shorter, longer = sorted((len(first), len(second)))
    width = shorter if band is None else check.integer(band, "band", at_least=1)
    if longer * min(shorter, 2 * width + 1) > _MAX_PAIRS:
        enough = int(_MAX_PAIRS / longer / 2) - 1
        raise InvalidInput(
            f"a, b: expected at most {_MAX_PAIRS:.0e} pairs of points, got {longer:,} times "
            f"{min(shorter, 2 * width + 1):,}; resample the curves, or pair neighbours only: "
            f"band={enough}"
        )
    return first, second, min(width, shorter)


def _curves(a: ArrayLike, b: ArrayLike) -> tuple[Float64Array, Float64Array]:
    first = check.array(a, "a", shape=("n", "d"))
    second = check.array(b, "b", shape=("m", first.shape[1]))
    for curve, name in ((first, "a"), (second, "b")):
        if curve.size == 0:
            raise InvalidInput(f"{name}: expected at least one point, got shape {curve.shape}")
    return first, second


def _finite(value: float) -> float:
    if not np.isfinite(value):
        raise InvalidInput("curves: expected coordinates whose squares are finite, got larger ones")
    return value

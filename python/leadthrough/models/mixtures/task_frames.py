"""Frames that move with a task: distributions seen from them, their product, and moved ends.

Orientations are rotation vectors in the tangent spaces along a frame's own reference. In a new
situation the references are averaged, and each frame's Gaussians are carried to the mean's tangent
spaces to first order. The weights of the frames' means come from covariances mixed with round ones,
as much as it takes to keep the mean near the frames' means. The motion keeps within 1.45 times the
move of the ends of the nominal one.

Source: Zeestraten et al. 2017, "An approach for imitation learning on Riemannian manifolds",
section III-C; Calinon 2016, "A tutorial on task-parameterized movement learning and retrieval",
sections 2 to 4; shrinkage: Murphy 2012, "Machine learning: a probabilistic perspective", 4.6.2.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from leadthrough import rotations
from leadthrough.check import FitError, Float64Array, NoContinuousLogarithm
from leadthrough.models.coordinates import NODES, Coordinates, carried, mean_orientations
from leadthrough.models.framed import Frame
from leadthrough.models.gaussians.mixture import Blocks, Mixture
from leadthrough.motion import MotionT, PoseTrajectory, normalised_times
from leadthrough.preprocess.moved_ends import MAX_GAIN, fraction_inside, with_ends
from leadthrough.preprocess.resample import arc_length

# Half the span of phases over which a drift is measured by finite differences.
_AROUND = 2.5e-3
# Weight of a round covariance, in demonstrations: that of a single one.
_ROUND_COUNTS = 1.0
# A frame that moves shifts the mean by at most this many times its own move.
_MAX_FRAME_GAIN = 1.2
# Fractions of round covariances to try, the least that keeps the gain. Round ones alone give every
# frame a weight between 0 and 1.
_ROUND = (0.0, 0.01, 0.03, 0.1, 0.2, 0.4, 0.7, 1.0)
_ROTATION = 3  # columns at the end of those of poses


@dataclass(frozen=True, eq=False)
class Placed:
    """A frame's k Gaussians, in the common columns of a situation."""

    means: Float64Array  # (k, w)
    maps: Float64Array  # (k, w, w) that carry deviations from the frame's own columns
    drift: Float64Array  # (k, w) changes of the means as the reference moves on, per second


def common_coordinates(
    coordinates: Coordinates[MotionT], own: Sequence[Coordinates], frames: Sequence[Frame]
) -> Coordinates[MotionT]:
    """A coordinates whose reference is the mean of the frames' own, seen from the base frame."""
    if coordinates.kind != "poses":
        return coordinates
    predicted = [_predicted(each, frame, NODES) for each, frame in zip(own, frames, strict=True)]
    try:
        return replace(coordinates, reference=mean_orientations(predicted))
    except FitError:  # frames rotated against each other, which a situation may ask for
        return replace(coordinates, reference=_between(predicted))


def placed(
    frame: Frame, own: Coordinates, common: Coordinates, means: Float64Array, duration: float
) -> Placed:
    """A frame's Gaussians, carried from its own columns into the common ones."""
    size, count = own.size, len(means)
    means, phases = means[:, 1:], np.clip(means[:, 0] / duration, 0.0, 1.0)
    moved = means[:, :size] @ frame.axes.T + frame.origin
    if own.kind != "poses":
        maps = np.broadcast_to(frame.axes, (count, size, size))
        return Placed(moved, maps, np.zeros_like(moved))

    def tangent(at: Float64Array) -> Float64Array:
        seen = rotations.compose(_predicted(own, frame, at), rotations.exp(means[:, 3:]))
        return common.tangent(seen, at)

    here = tangent(phases)
    before, after = np.maximum(phases - _AROUND, 0.0), np.minimum(phases + _AROUND, 1.0)
    drift = (tangent(after) - tangent(before)) / (duration * (after - before))[:, None]
    maps = np.zeros((count, 6, 6))
    maps[:, :3, :3] = frame.axes
    maps[:, 3:, 3:] = carried(means[:, 3:], here)
    return Placed(np.hstack([moved, here]), maps, np.hstack([np.zeros((count, 3)), drift]))


def _between(predicted: Sequence[Float64Array]) -> Float64Array:
    """Orientations (n, 4) between several rows of them, without a jump where they are far apart."""
    back = rotations.inverse(predicted[0])
    try:
        turns = [rotations.lift(rotations.compose(back, each)) for each in predicted]
    except NoContinuousLogarithm:
        return rotations.align_signs(predicted[0])
    middle = rotations.exp(np.mean(turns, axis=0))
    return rotations.align_signs(rotations.compose(predicted[0], middle))


def _predicted(own: Coordinates, frame: Frame, phases: Float64Array) -> Float64Array:
    """A frame's reference orientation (n, 4) in the base frame."""
    return rotations.compose(frame.orientations(len(phases)), own.reference_at(phases))


def shrunk(covariances: Float64Array, demonstrations: int, *, poses: bool) -> Float64Array:
    """Covariances of the time and the columns, those of the columns given the time made rounder."""
    fraction = _ROUND_COUNTS / (demonstrations - 1.0 + _ROUND_COUNTS)
    given_time = conditional(covariances)
    result = covariances.copy()
    result[:, 1:, 1:] += fraction * (round_ones(given_time, poses=poses) - given_time)
    return result


def conditional(covariances: Float64Array) -> Float64Array:
    """Covariances (k, d, d) of the columns, given the time."""
    rates = covariances[:, 0, 1:] / covariances[:, :1, 0]
    return np.asarray(covariances[:, 1:, 1:] - rates[:, :, None] * covariances[:, :1, 1:])


def round_ones(covariances: Float64Array, *, poses: bool) -> Float64Array:
    """Covariances (k, d, d) of the same variances in all directions."""
    size = covariances.shape[1]
    even = np.zeros_like(covariances)
    split = size - _ROTATION if poses else size
    for group in (np.arange(split), np.arange(split, size)):
        if len(group) > 0:
            variances = covariances[:, group, group].mean(axis=1)
            even[:, group, group] = variances[:, None]
    return even


def multiplied(components: Blocks, seen: Sequence[Placed], *, poses: bool) -> Mixture:
    """The mixture of the time and the common columns, in a situation."""
    rates, inner = [], []
    for each, covariances in zip(seen, components.covariances, strict=True):
        rate = covariances[:, 0, 1:] / covariances[:, :1, 0]
        rates.append(_applied(each.maps, rate) + each.drift)
        inner.append(each.maps @ conditional(covariances) @ each.maps.transpose(0, 2, 1))
    weights = _weights(inner, _units(seen, poses=poses), poses=poses)
    means = _combined(weights, [each.means for each in seen])
    slope = _combined(weights, rates)
    within = np.asarray(np.linalg.inv(np.sum([np.linalg.inv(each) for each in inner], axis=0)))
    times, variances = components.means[0][:, 0], components.covariances[0][:, 0, 0]
    covariance = np.empty((len(times), len(within[0]) + 1, len(within[0]) + 1))
    covariance[:, 0, 0] = variances
    covariance[:, 0, 1:] = covariance[:, 1:, 0] = variances[:, None] * slope
    outer = slope[:, :, None] * slope[:, None, :] * variances[:, None, None]
    covariance[:, 1:, 1:] = 0.5 * (within + within.transpose(0, 2, 1)) + outer
    return Mixture(components.weights, np.column_stack([times, means]), covariance)


def _weights(
    covariances: Sequence[Float64Array], units: Float64Array, *, poses: bool
) -> list[Float64Array]:
    """The matrices (k, d, d) by which the frames' means count; they sum to one."""
    scaled = [each / units / units[:, None] for each in covariances]
    rounds = [round_ones(each, poses=poses) for each in scaled]
    chosen = _products(scaled)
    done = np.zeros(len(scaled[0]), dtype=bool)
    for fraction in _ROUND:
        mixed = [
            (1.0 - fraction) * own + fraction * even
            for own, even in zip(scaled, rounds, strict=True)
        ]
        tried = _products(mixed)
        gains = np.max([np.linalg.norm(each, ord=2, axis=(1, 2)) for each in tried], axis=0)
        fits = ~done & ((gains <= _MAX_FRAME_GAIN) | (fraction == 1.0))
        for each, better in zip(chosen, tried, strict=True):
            each[fits] = better[fits]
        done |= fits
        if done.all():
            break
    return [each * units[:, None] / units for each in chosen]


def _products(covariances: Sequence[Float64Array]) -> list[Float64Array]:
    """The weights (k, d, d) of the means in a product of Gaussians."""
    precisions = [np.asarray(np.linalg.inv(each)) for each in covariances]
    total = np.asarray(np.linalg.inv(np.sum(precisions, axis=0)))
    return [total @ each for each in precisions]


def _units(seen: Sequence[Placed], *, poses: bool) -> Float64Array:
    """Lengths (d,) that count alike: the motion's extent, for a rotation one radian."""
    size = seen[0].means.shape[1]
    units = np.ones(size)
    split = size - _ROTATION if poses else size
    if poses:
        extent = float(np.linalg.norm(np.ptp(seen[0].means[:, :split], axis=0)))
        units[:split] = extent or 1.0
    return units


def _combined(weights: Sequence[Float64Array], vectors: Sequence[Float64Array]) -> Float64Array:
    """The sum (k, d) of vectors of each frame, weighted."""
    parts = [_applied(w, each) for w, each in zip(weights, vectors, strict=True)]
    return np.asarray(np.sum(parts, axis=0))


def _applied(matrices: Float64Array, vectors: Float64Array) -> Float64Array:
    """Products (k, d) of matrices (k, d, d) with vectors (k, d)."""
    return np.asarray(np.einsum("kij,kj->ki", matrices, vectors))


def bounded(adapted: MotionT, nominal: MotionT) -> MotionT:
    """A motion between moved ends, drawn to the nominal one until it is within the bound."""
    deviation = _deviation(adapted, nominal)
    limits = _limits(deviation, nominal.positions)
    offsets = _within(deviation.offsets, deviation.fractions, limits[0])
    positions = nominal.positions + offsets
    if not isinstance(adapted, PoseTrajectory) or not isinstance(nominal, PoseTrajectory):
        return replace(adapted, positions=positions)
    turns = rotations.exp(_within(deviation.turns, deviation.fractions, limits[1]))
    rotated = rotations.align_signs(rotations.compose(nominal.orientations, turns))
    return replace(adapted, positions=positions, orientations=rotated)


@dataclass(frozen=True, eq=False)
class _Deviation:
    offsets: Float64Array  # (n, d) of the positions
    turns: Float64Array
    fractions: Float64Array  # (n,) of the nominal path covered


def _deviation(adapted: MotionT, nominal: MotionT) -> _Deviation:
    covered = arc_length(nominal.positions)
    total = float(covered[-1])
    fractions = covered / total if total > 0.0 else normalised_times(nominal.times)
    offsets = adapted.positions - nominal.positions
    turns = np.zeros((len(offsets), 3))
    if isinstance(adapted, PoseTrajectory) and isinstance(nominal, PoseTrajectory):
        turns = _turns(nominal.orientations, adapted.orientations, fractions)
    return _Deviation(offsets, turns, fractions)


def _turns(nominal: Float64Array, adapted: Float64Array, fractions: Float64Array) -> Float64Array:
    """Rotation vectors (n, 3) from nominal orientations (n, 4) to adapted ones."""
    between = rotations.compose(rotations.inverse(nominal), adapted)
    try:
        return rotations.lift(between)
    except NoContinuousLogarithm:
        ends = rotations.log(between[[0, -1]])
        return np.outer(1.0 - fractions, ends[0]) + np.outer(fractions, ends[1])


def _limits(deviation: _Deviation, positions: Float64Array) -> tuple[float, float]:
    """The largest distance and the largest rotation, rad, from the nominal motion."""
    ends = [0, -1]
    levers = [float(np.linalg.norm(positions - positions[i], axis=1).max()) for i in ends]
    moved = [float(np.linalg.norm(deviation.offsets[i])) for i in ends]
    rotated = [float(np.linalg.norm(deviation.turns[i])) for i in ends]
    pairs = list(zip(moved, rotated, levers, strict=True))
    distance = max(m + t * lever for m, t, lever in pairs)
    angle = max(t + (m / lever if lever > 0.0 else 0.0) for m, t, lever in pairs)
    return MAX_GAIN * distance, MAX_GAIN * angle


def _within(changes: Float64Array, fractions: Float64Array, limit: float) -> Float64Array:
    """Changes (n, d) with those of the ends, drawn to their fade as far as the limit asks."""
    fade = with_ends(np.zeros_like(changes), changes[0], changes[-1], fractions)
    more = changes - fade
    return np.asarray(fade + fraction_inside(fade, more, limit) * more)

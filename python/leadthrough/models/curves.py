"""Demonstrations as curves over a common phase, apart from their timing, and their modes.

Two phases: the fraction of the arc length, and an elastic one that brings each demonstration to
the mean of all by dynamic programming (Sakoe and Chiba 1978) on position and tangent. The timing is
a progress: the fraction of the path covered over normalised time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from leadthrough import rotations
from leadthrough.check import Float64Array
from leadthrough.models.coordinates import mean_orientations
from leadthrough.motion import Motion, PoseTrajectory, kept, lerp, normalised_times
from leadthrough.noise import without_noise
from leadthrough.preprocess.align import FREE, MIN_TURN, TURNING, warp
from leadthrough.preprocess.moved_ends import with_ends
from leadthrough.preprocess.resample import arc_length
from leadthrough.preprocess.smooth import in_pieces

# Rows of a curve: as few as keep all samples within a fraction of the extent, doubled from the
# first number up to the second, of many samples to half of these, at most the third.
_ROWS, MAX_ROWS, _MAX_OF_MANY, _DETAIL = 200, 12_800, 51_200, 1e-3
# A motion is of as few cubic pieces, doubled from the first number, as leave out no more than a
# fraction of the extent, each of at least so many rows; of more pieces, all is detail.
_PIECES, _MAX_PIECES, _ROWS_A_PIECE, _TREMOR = 8, 256, 3, 2.5e-3
# Rows by which curves are aligned, as their pairs grow with the square; every eighth of long ones.
_ALIGNED_ROWS, _ALIGNED_STEP = 200, 8
# Fraction of a curve's length that time adds to it, so that phases rise during pauses.
_PAUSE = 1e-4
_TANGENT = 0.3  # weight of the unit tangent against the position in units of the extent
_ROUNDS = 2
# Demonstrations of two modes lie farther apart than this fraction of their length, and this many
# times as far as those of one mode.
_APART, _GAP = 0.05, 2.5


@dataclass(frozen=True, eq=False)
class Curves:
    """Demonstrations (k, n, width) at n even phases, with the times (k, n) of these."""

    rows: Float64Array
    times: Float64Array

    def __post_init__(self) -> None:
        for each in (self.rows, self.times):
            each.setflags(write=False)

    def at(self, phases: Float64Array) -> Curves:
        """Those at phases (k, n) of each."""
        even = even_phases(self.rows.shape[1])
        rows = [lerp(u, even, each) for u, each in zip(phases, self.rows, strict=True)]
        times = [np.interp(u, even, each) for u, each in zip(phases, self.times, strict=True)]
        return Curves(np.array(rows), np.array(times))

    def coarse(self, count: int) -> Curves:
        """The same at some of the phases, about as many as a number."""
        last = self.rows.shape[1] - 1
        some = np.append(np.arange(0, last, max(1, (last + 1) // count)), last)
        return Curves(self.rows.take(some, axis=1), self.times.take(some, axis=1))


@lru_cache(maxsize=16)
def even_phases(count: int) -> Float64Array:
    """Evenly spaced phases (n,) from 0 to 1, not to be written to."""
    phases = np.linspace(0.0, 1.0, count)
    phases.flags.writeable = False
    return phases


def arc_phases(rows: Float64Array) -> Float64Array:
    """The fraction (..., n) of the length covered at rows (..., n, width), rising also in rests."""
    steps = np.linalg.norm(np.diff(rows, axis=-2), axis=-1)
    total = steps.sum(axis=-1, keepdims=True)
    steps += np.where(total > 0.0, _PAUSE * total, 1.0) / steps.shape[-1]
    covered = np.zeros(rows.shape[:-1])
    np.cumsum(steps, axis=-1, out=covered[..., 1:])
    covered /= covered[..., -1:]
    return covered


def by_arc(columns: Sequence[Float64Array], times: Sequence[Float64Array]) -> Curves:
    """Demonstrations (n, width) each, with their times (n,) from 0 on, by their arc length."""
    phases = [arc_phases(each) for each in columns]
    even = even_phases(_row_count(columns, phases))
    rows = [lerp(even, u, each) for u, each in zip(phases, columns, strict=True)]
    timed = [np.interp(even, u, each) for u, each in zip(phases, times, strict=True)]
    return Curves(np.array(rows), np.array(timed))


def _row_count(columns: Sequence[Float64Array], phases: Sequence[Float64Array]) -> int:
    """The number of even rows between which no sample lies far from the line."""
    count, most = _ROWS, min(max(MAX_ROWS, max(map(len, columns)) // 2), _MAX_OF_MANY)
    while count < most:
        even = even_phases(count)
        missed = [
            np.linalg.norm(each - lerp(u, even, lerp(even, u, each)), axis=1).max()
            / float(np.linalg.norm(np.ptp(each, axis=0)))
            for u, each in zip(phases, columns, strict=True)
        ]
        if max(missed) <= _DETAIL:
            break
        count *= 2
    return count


def piece_count(rows: Float64Array) -> int:
    """The number of cubic pieces that hold curves (k, n, width) but for tremor; 0 if none do."""
    count, extents = _PIECES, np.linalg.norm(np.ptp(rows, axis=1), axis=1)
    while count <= min(_MAX_PIECES, rows.shape[1] // _ROWS_A_PIECE):
        missed = (np.linalg.norm(smoothed(each, count) - each, axis=1).max() for each in rows)
        if all(each <= _TREMOR * extent for each, extent in zip(missed, extents, strict=True)):
            return count
        count *= 2
    return 0


def smoothed(rows: Float64Array, pieces: int) -> Float64Array:
    """Rows (n, width) of so many cubic pieces; as they are with 0."""
    return in_pieces(rows, pieces) if pieces > 0 else rows


def elastic(curves: Curves) -> Curves:
    """Curves by arc length, each aligned to the mean of all."""
    if len(curves.rows) < 2:
        return curves
    count = curves.rows.shape[1]
    coarse = curves.rows[
        :, :: _ALIGNED_STEP if count > MAX_ROWS else max(1, count // _ALIGNED_ROWS)
    ]
    even = even_phases(coarse.shape[1])
    features = [_features(each) for each in _with_mean_ends(coarse)]
    apart = [sum(float(np.abs(a - b).mean()) for b in features) for a in features]
    middle = features[int(np.argmin(apart))]
    for _ in range(_ROUNDS):
        warps = [warp(middle, each, rigidity=FREE) for each in features]
        aligned = [lerp(u, even, each) for u, each in zip(warps, coarse, strict=True)]
        middle = _features(_with_mean_ends(np.array(aligned)).mean(axis=0))
    fine = even_phases(curves.rows.shape[1])
    return curves.at(np.array([np.interp(fine, even, each) for each in warps]))


def _features(rows: Float64Array) -> Float64Array:
    """Position and direction (n, 2 width) of a curve in units of the extent."""
    tangent = np.gradient(rows, axis=0)
    length = np.linalg.norm(tangent, axis=1, keepdims=True)
    return np.hstack([rows, _TANGENT * tangent / np.where(length > 0.0, length, 1.0)])


def _with_mean_ends(rows: Float64Array) -> Float64Array:
    return with_ends(rows, *rows[:, [0, -1]].mean(axis=0))


def modes_of(rows: Float64Array) -> NDArray[np.int64]:
    """The mode (k,) of each of the curves (k, n, width), numbered from 0."""
    # Shifted to the same ends, those of one mode lie near each other: linkage distances have a gap.
    from scipy.cluster.hierarchy import fcluster, linkage
    from scipy.spatial.distance import pdist

    one_way = np.zeros(len(rows), dtype=np.int64)
    if len(rows) < 3:
        return one_way
    length = np.linalg.norm(np.diff(rows, axis=1), axis=2).sum(axis=1).mean()
    flat = _with_mean_ends(rows).reshape(len(rows), -1) / np.sqrt(rows.shape[1])
    joined = linkage(pdist(flat) / length, "single")
    at = joined[:, 2]
    gaps = np.where(at[1:] > _APART, at[1:] / np.maximum(at[:-1], 1e-12), 0.0)
    widest = int(np.argmax(gaps))
    if gaps[widest] < _GAP:
        return one_way
    groups = fcluster(joined, np.sqrt(at[widest] * at[widest + 1]), "distance")
    _, first, numbers = np.unique(groups, return_index=True, return_inverse=True)
    return np.asarray(np.argsort(np.argsort(first))[numbers], dtype=np.int64)


def columns_of(motions: Sequence[Motion]) -> tuple[list[Float64Array], Float64Array]:
    """Columns (n, width) of each motion without noise, and the mean goal of poses' orientations."""
    smooth = [_smooth(each)[:, : each.positions.shape[1]] for each in motions]
    poses = [each for each in motions if isinstance(each, PoseTrajectory)]
    if not poses:
        return smooth, np.empty((1, 4))
    reference = mean_orientations([each.orientations[-1:] for each in poses])
    turned = [without_noise(_lifted(each, reference)) for each in poses]
    return [np.hstack(each) for each in zip(smooth, turned, strict=True)], reference


@kept
def _smooth(motion: Motion) -> Float64Array:
    """Positions (n, d), and rotation matrices of poses, without noise."""
    parts = [motion.positions]
    if isinstance(motion, PoseTrajectory):
        parts.append(rotations.to_matrix(motion.orientations).reshape(-1, 9))
    return np.hstack([without_noise(each) for each in parts])


def features_of(motions: Sequence[Motion]) -> list[Float64Array]:
    """Rows to tell modes apart, of positions and of rotation matrices, which need no reference."""
    columns = [_smooth(each) for each in motions]
    scale = scale_of(columns, motions[0].positions.shape[1])
    return [each / scale for each in columns]


def scale_of(columns: Sequence[Float64Array], size: int) -> Float64Array:
    """The extent (width,) of positions, and that of orientations for their weight."""
    width = columns[0].shape[1]
    extent = [float(np.mean([_extent(each[:, :size]) for each in columns]))]
    if width > size:
        turn = np.mean([_extent(each[:, size:]) for each in columns])
        extent.append(max(float(turn), MIN_TURN) / TURNING)
    scale = np.repeat([each or 1.0 for each in extent], [size, width - size][: len(extent)])
    return np.asarray(scale, dtype=np.float64)


def _extent(rows: Float64Array) -> float:
    return float(np.linalg.norm(np.ptp(rows, axis=0)))


def _lifted(motion: PoseTrajectory, reference: Float64Array) -> Float64Array:
    """Rotation vectors (n, 3) from a reference (1, 4), continuous, the last at most pi long."""
    back = rotations.inverse(np.repeat(reference, len(motion.times), 0))
    return rotations.lift(rotations.compose(back, motion.orientations), anchor="goal")


PROGRESS_SAMPLES = 1001  # of progress, at evenly spaced normalised times
# Fraction of the duration over which the speed is averaged twice: the acceleration becomes
# continuous, and recorded speeds lose their noise.
_SMOOTHING = 0.035
_RESTS, _MOVES = 0.1, 0.5  # speeds of a rest and of a movement, in means of the whole


def progress_of(times: Float64Array, path: Float64Array) -> Float64Array:
    """The fraction of a path covered at evenly spaced normalised times, (1001,) from 0 to 1."""
    covered = arc_length(path)
    fraction = covered / covered[-1] if covered[-1] > 0 else np.linspace(0.0, 1.0, len(path))
    return np.interp(np.linspace(0, 1, PROGRESS_SAMPLES), normalised_times(times), fraction)


def uniform_progress() -> Float64Array:
    """Progress at constant speed, (1001,)."""
    return np.linspace(0.0, 1.0, PROGRESS_SAMPLES)


def weighted_median(values: Float64Array, weights: Float64Array) -> float:
    """The median of values (k,) that count as much as their weights (k,)."""
    order = np.argsort(values, kind="stable")
    fraction = weights[order] / weights.sum()
    return float(np.interp(0.5, np.cumsum(fraction) - 0.5 * fraction, values[order]))


def speed_of(progress: Float64Array) -> Float64Array:
    """The smoothed change of a progress (1001,) from sample to sample, (1001,)."""
    from scipy.ndimage import uniform_filter1d

    speed = np.gradient(progress)
    for _ in range(2):
        speed = uniform_filter1d(speed, int(_SMOOTHING * PROGRESS_SAMPLES), mode="nearest")
    return np.asarray(speed)


def smoothed_progress(progress: Float64Array) -> Float64Array:
    """The progress (n,) at even times, smoothed, with its own speeds at the start and at the end.

    Each of several movements between rests is as smooth as a motion of one.
    """
    even = even_phases(len(progress))
    ahead = progress - even
    width = int(_SMOOTHING / _movement_count(progress) * len(progress)) | 1
    # Mirrored through both ends, where it is 0, by as much as two averages take away.
    ahead = np.concatenate([-ahead[width - 1 : 0 : -1], ahead, -ahead[-2 : -width - 1 : -1]])
    for _ in range(2):
        ahead = np.convolve(ahead, np.full(width, 1.0 / width), mode="valid")
    return np.asarray(np.maximum.accumulate(np.clip(even + ahead, 0.0, 1.0)))


def _movement_count(progress: Float64Array) -> int:
    """How often it rests and moves again, or begins to, over the even times (n,)."""
    speed = len(progress) * np.diff(progress)
    moves = (speed > _MOVES)[(speed > _MOVES) | (speed < _RESTS)]
    return max(int(np.count_nonzero(moves[1:] & ~moves[:-1]) + moves[:1].sum()), 1)

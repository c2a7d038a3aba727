"""Demonstrations as columns of numbers: positions, and rotation vectors that follow any turn."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from leadthrough import rotations
from leadthrough.check import Float64Array
from leadthrough.models.coordinates import mean_orientations
from leadthrough.motion import Motion, PoseTrajectory
from leadthrough.preprocess.align import MIN_TURN, TURNING


def columns_of(motions: Sequence[Motion]) -> tuple[list[Float64Array], Float64Array]:
    """Columns (n, width) of each motion, and the mean goal orientation (1, 4) of poses.

    Orientations are rotation vectors from that mean, continuous along the motion.
    """
    poses = [each for each in motions if isinstance(each, PoseTrajectory)]
    if not poses:
        return [each.positions for each in motions], np.empty((1, 4))
    reference = mean_orientations([each.orientations[-1:] for each in poses])
    return [np.hstack([each.positions, _lifted(each, reference)]) for each in poses], reference


def features_of(motions: Sequence[Motion]) -> list[Float64Array]:
    """Rows to tell modes apart, of positions and of rotation matrices, which need no reference."""
    columns = [
        np.hstack([each.positions, rotations.to_matrix(each.orientations).reshape(-1, 9)])
        if isinstance(each, PoseTrajectory)
        else each.positions
        for each in motions
    ]
    scale = scale_of(columns, motions[0].positions.shape[1])
    return [each / scale for each in columns]


def clocks_of(motions: Sequence[Motion]) -> list[Float64Array]:
    """The times (n,) of each motion from 0 on, s."""
    return [each.times - each.times[0] for each in motions]


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

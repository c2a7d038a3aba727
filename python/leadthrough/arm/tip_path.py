"""A path of the tip as the core takes it, and the joints along it as the core returns them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

import leadthrough._core as core
from leadthrough import check, rotations
from leadthrough.arm.inverse_kinematics import Axis, IkOptions, compiled
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.motion import PoseTrajectory, Trajectory


@dataclass(frozen=True, eq=False)
class TipPath:
    """A path of the tip, sample by sample."""

    times: Float64Array  # (n,) s
    positions: Float64Array  # (n, 3) m
    orientations: Float64Array  # (n, 4) w, x, y, z, or no rows where they are free
    postures: Float64Array = field(default_factory=lambda: np.empty((0, 0)))
    free: tuple[Axis, ...] = ()  # axes of the poses that are left free
    tube: Float64Array = field(default_factory=lambda: np.empty((0, 6)))

    @staticmethod
    def of(motion: Trajectory | PoseTrajectory) -> TipPath:
        """The path of poses, or of points in 3-D."""
        if isinstance(motion, PoseTrajectory):
            return TipPath(motion.times, motion.positions, motion.orientations)
        if isinstance(motion, Trajectory) and motion.positions.shape[1] == 3:
            return TipPath(motion.times, motion.positions, np.empty((0, 4)))
        what = type(motion).__name__
        if isinstance(motion, Trajectory):
            what += f" in {motion.positions.shape[1]}-D"
        raise InvalidInput(f"motion: expected a PoseTrajectory or a Trajectory in 3-D, got {what}")

    def __len__(self) -> int:
        return len(self.times)

    @property
    def dimension(self) -> int:
        """Dimension of the task at a sample: 6 with orientations, 3 without, less what is free."""
        return (6 if len(self.orientations) else 3) - len(self.free)

    def options(self, *, nullspace_gain: float = 0.0) -> core.IkOptions:
        """The options of inverse kinematics for a single sample."""
        return compiled(IkOptions(free=self.free, nullspace_gain=nullspace_gain), 0)

    def only(self, samples: slice | NDArray[np.intp]) -> TipPath:
        """The path of these samples alone."""
        orientations = self.orientations[samples] if len(self.orientations) else self.orientations
        postures = self.postures[samples]
        own = (self.times[samples], self.positions[samples], orientations)
        return TipPath(*own, postures, self.free)

    def pull(self, rate: float) -> tuple[Float64Array, Float64Array]:
        """The postures, and the fractions (n,) of the way there that each sample moves."""
        fractions = np.minimum(rate * np.diff(self.times, prepend=self.times[0]), 1.0)
        return self.postures, fractions


@dataclass(frozen=True, eq=False)
class Track:
    """Joints up to and including the first sample that was missed."""

    q: Float64Array  # (k, joints)
    position_errors: Float64Array  # (k,) m
    orientation_errors: Float64Array  # (k,) rad
    reached: int  # number of samples that were not missed

    @staticmethod
    def of(
        columns: tuple[Float64Array, Float64Array, Float64Array], allowed: tuple[float, float]
    ) -> Track:
        """The track that the core returned, with the errors allowed at a sample, m and rad."""
        q, positions, orientations = columns
        missed = positions[-1] > allowed[0] or orientations[-1] > allowed[1]
        return Track(q, positions, orientations, len(q) - int(missed))

    @staticmethod
    def standing(chain: core.Chain, path: TipPath, sample: int, q: Float64Array) -> Track:
        """The arm stands still at q (joints,) and misses the given sample of a path."""
        position, orientation = chain.forward_kinematics(q[None])
        wanted = path.only(slice(sample, sample + 1))
        far = float(np.linalg.norm(position - wanted.positions))
        angle = 0.0
        if len(wanted.orientations):
            angle = float(rotations.distance(orientation, wanted.orientations)[0])
        rows = np.repeat(q[None], sample + 1, axis=0)
        errors = np.full(sample + 1, far), np.full(sample + 1, angle)
        return Track(rows, *errors, sample)


def solve_sample(
    chain: core.Chain, path: TipPath, i: int, guesses: Float64Array, options: core.IkOptions
) -> tuple[Float64Array, NDArray[np.int32], Float64Array]:
    """Configurations (m, joints), status codes and errors (m,) for one sample from many guesses."""
    sample = path.only(np.full(len(guesses), i))
    q, status, position_errors, orientation_errors, *_ = core.solve_ik_batch(
        chain, sample.positions, sample.orientations, guesses, options, 1
    )
    return q, status, position_errors + orientation_errors


def tube_around(path: TipPath, deviation: tuple[ArrayLike, ArrayLike]) -> Float64Array:
    """The room at each sample as the core takes it, (6 n, 6)."""
    if not isinstance(deviation, tuple | list) or len(deviation) != 2:
        raise InvalidInput(
            f"deviation: expected the room in m and in rad, (m, rad), got {deviation!r}"
        )
    room = np.zeros((len(path), 6, 6))
    room[:, :3, :3] = _in_frames(path, _room(deviation[0], "deviation in m", len(path)))
    room[:, 3:, 3:] = _room(deviation[1], "deviation in rad", len(path))
    room[[0, -1]] = 0.0
    return np.ascontiguousarray(room.reshape(-1, 6))


def _room(value: ArrayLike, name: str, samples: int) -> Float64Array:
    """Squares (3, 3) along the axes, or the matrices (n, 3, 3) as they are."""
    if np.ndim(value) == 0:
        return np.diag(np.full(3, check.number(value, name, at_least=0.0) ** 2))
    if np.ndim(value) == 1:
        lengths = check.array(value, name, shape=(3,))
        if lengths.min() < 0.0:
            raise InvalidInput(f"{name}: expected numbers >= 0, got {lengths.min()}")
        return np.diag(lengths**2)
    matrices = check.array(value, name, shape=(samples, 3, 3))
    if not all(core.is_covariance(np.ascontiguousarray(each)) for each in matrices):
        raise InvalidInput(
            f"{name}: expected covariances, symmetric and without negative variances"
        )
    return matrices


def _in_frames(path: TipPath, room: Float64Array) -> Float64Array:
    """Room given by matrices in the base frame as seen from each sample."""
    if room.ndim == 2 or not len(path.orientations):
        return room
    frames = rotations.to_matrix(path.orientations)
    return np.asarray(frames.transpose(0, 2, 1) @ room @ frames)

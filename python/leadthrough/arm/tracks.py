"""A path of the tip as the core takes it, and the joints along it as the core returns them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from leadthrough import _core, rotations
from leadthrough.arm.options import Axis, ik_options
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
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

    def options(self, *, midrange: float = 0.0) -> _core.IkOptions:
        """The options of inverse kinematics for a single sample."""
        return ik_options(free=self.free, midrange=midrange)

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
    def standing(chain: _core.Chain, path: TipPath, sample: int, q: Float64Array) -> Track:
        """The arm stands still at q (joints,) and misses the given sample of a path."""
        position, orientation = chain.forward_kinematics(q[None])
        wanted = path.only(slice(sample, sample + 1))
        far = float(np.linalg.norm(position - wanted.positions))
        turned = 0.0
        if len(wanted.orientations):
            turned = float(rotations.distance(orientation, wanted.orientations)[0])
        rows = np.repeat(q[None], sample + 1, axis=0)
        errors = np.full(sample + 1, far), np.full(sample + 1, turned)
        return Track(rows, *errors, sample)


def solve_sample(
    chain: _core.Chain, path: TipPath, i: int, seeds: Float64Array, options: _core.IkOptions
) -> tuple[Float64Array, NDArray[np.int32], Float64Array]:
    """Configurations (m, joints), status codes and errors (m,) for one sample from many seeds."""
    sample = path.only(np.full(len(seeds), i))
    q, status, position_errors, orientation_errors, *_ = _core.solve_ik_batch(
        chain, sample.positions, sample.orientations, seeds, options, 1
    )
    return q, status, position_errors + orientation_errors

"""A path of the tip as the core takes it, and joints along it, also such that the arm keeps clear.

For these the path is cut into layers, and a search goes from layer to layer over all that the task
leaves free. Its path is made smooth and roomy as a whole, put back onto the path sample by sample,
and checked between samples with the room that a controller's curve through them takes.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

import leadthrough._core as core
from leadthrough import check, rotations, shapes
from leadthrough.arm.inverse_kinematics import Axis, IkOptions, all_axes, compiled, free_axes
from leadthrough.check import Float64Array, IkFailure, InvalidInput
from leadthrough.motion import PoseTrajectory, Trajectory
from leadthrough.shapes import Scene, SceneLike
from leadthrough.shapes.scene import PLANNING_TOLERANCE

# A hit between samples that is deeper than this isn't missed, m. The other half of the planning
# tolerance is left for the time law.
_TOLERANCE = 0.5 * PLANNING_TOLERANCE
# Bodies nearer by this than their margin are too near by any measure, m.
_TOUCHING = 2e-6
# m: with this margin, no two parts of an arm count as too near.
_ANY_OVERLAP = -10.0
# As in the compiled core.
_MAX_ATTEMPTS = 3
# Bodies that are named where there is no room.
_NAMED = 3


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
        chain, sample.positions, sample.orientations, guesses, options, 1, None, own_restarts=True
    )
    return q, status, position_errors + orientation_errors


def tube_around(path: TipPath, deviation: tuple[ArrayLike, ArrayLike]) -> Float64Array:
    """The room at each sample as the core takes it, (6 n, 6)."""
    if not isinstance(deviation, tuple | list) or len(deviation) != 2:
        raise check.refused("deviation", "the room in m and in rad, (m, rad)", repr(deviation))
    room = np.zeros((len(path), 6, 6))
    room[:, :3, :3] = _in_frames(path, _room(deviation[0], "deviation in m", len(path)))
    room[:, 3:, 3:] = _room(deviation[1], "deviation in rad", len(path))
    room[[0, -1]] = 0.0
    return np.ascontiguousarray(room.reshape(-1, 6))


def _room(value: ArrayLike, name: str, samples: int) -> Float64Array:
    """Squares (3, 3) along the axes, or the matrices (n, 3, 3) as they are."""
    if check.rank(value) == 0:
        return np.diag(np.full(3, check.number(value, name, at_least=0.0) ** 2))
    if check.rank(value) == 1:
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


@dataclass(frozen=True, eq=False)
class CollisionTest:
    """Whether an arm keeps the margins of a scene, at configurations and along motions."""

    model: core.CollisionModel  # the arm's own shapes
    scene: Scene  # with the margins to keep
    max_attempts: int = _MAX_ATTEMPTS

    @staticmethod
    def of(model: core.CollisionModel, scene: SceneLike) -> CollisionTest:
        """The test that planning uses: it keeps the planning tolerance beyond the margins."""
        return CollisionTest(model, shapes.as_scene(scene).for_planning())

    def clear_along(self, q: Float64Array) -> bool:
        """Whether straight motions from row to row of q (n, joints) keep the margins."""
        # Most motions that come too near to an obstacle do so at a row: that is quick to see.
        surely = self.scene.margin - _TOUCHING
        at_rows = core.clear_batch(self.model, self.shapes, q, surely, _ANY_OVERLAP)
        return all(at_rows) and all(
            core.check_motion(pairs, q, margin, _TOLERANCE, 1)[2] is None
            for pairs, margin in self._pairs
        )

    def clear_between(self, q: Float64Array) -> bool:
        """The same without the closest approach; within 0.1 mm of a margin it may fail."""
        return all(self.clear_edges(q))

    def clear_edges(self, q: Float64Array) -> list[bool]:
        """That of each straight motion from row to row of q (n, joints), or of a single row."""
        margins = self.scene.margin, self.scene.self_collision_margin
        starts, ends = q[: max(len(q) - 1, 1)], q[min(1, len(q) - 1) :]
        return core.clear_edges(self.model, self.shapes, starts, ends, *margins, 1)

    def clear_rows(self, q: Float64Array) -> list[bool]:
        """Whether the arm keeps the margins, for each row of q (n, joints)."""
        margins = self.scene.margin, self.scene.self_collision_margin
        return core.clear_batch(self.model, self.shapes, q, *margins)

    @cached_property
    def shapes(self) -> list[core.Shape]:
        return shapes.compiled(self.scene.shapes)

    @cached_property
    def _pairs(self) -> tuple[tuple[core.CollisionScene, float], ...]:
        return (
            (core.against(self.model, self.shapes), self.scene.margin),
            (core.itself(self.model), self.scene.self_collision_margin),
        )


def clear_path(
    chain: core.Chain,
    path: TipPath,
    around: CollisionTest | None,
    *,
    start: Float64Array | None,
    tolerance: core.IkTolerance,
) -> Float64Array:
    """Configurations (n, joints) along the path that keep clear, between samples too."""
    on_path = replace(path, tube=path.tube[:0])
    try:
        return _clear_path(chain, on_path, around, start, tolerance)
    except IkFailure:
        if not len(path.tube):
            raise
    return _clear_path(chain, path, around, start, tolerance)


def _clear_path(
    chain: core.Chain,
    path: TipPath,
    around: CollisionTest | None,
    start: Float64Array | None,
    tolerance: core.IkTolerance,
) -> Float64Array:
    scene = Scene(margin=0.0) if around is None else around.scene
    q, last, sample, pairs, touch = core.clear_path(
        chain,
        None if around is None else around.model,
        shapes.compiled(scene.shapes),
        path.positions,
        path.orientations,
        all_axes(path.free) if len(path.tube) else free_axes(path.free),
        path.postures,
        start,
        scene.margin,
        scene.self_collision_margin,
        tolerance,
        path.tube,
        _MAX_ATTEMPTS if around is None else around.max_attempts,
    )
    if len(q):
        return q
    if touch is not None:
        sample, distance, *bodies = touch
        reason = f"{bodies[0]} and {bodies[1]} stay {1e3 * distance:.1f} mm apart at best"
    elif pairs:
        reason = f"no room between {_bodies(pairs)}"
    else:
        reason = "the tip cannot follow the path from there without a jump"
    time = float(np.interp(sample, np.arange(len(path)), path.times))
    index, status = int(sample), "blocked" if touch or pairs else "jump"
    message = f"sample {index} at {time:.6g} s: {status}, {reason}"
    nearest = path.postures[index] if last is None else last
    known = np.where(np.isnan(nearest), chain.middle, nearest)  # an endless joint prefers nothing
    raise IkFailure(message, index=index, status=status, residual=(0.0, 0.0), q=known)


def _bodies(pairs: list[tuple[str, str, int]]) -> str:
    """The pairs of bodies that were too near most often."""
    counts: Counter[tuple[str, str]] = Counter()
    for a, b, count in pairs:
        counts[a, b] += count
    return ", ".join(f"{a} and {b}" for (a, b), _ in counts.most_common(_NAMED))

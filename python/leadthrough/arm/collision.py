"""Collision of the whole arm with obstacles and with itself.

Every collision shape of every link counts, and what is attached to the tip. What does not move is
not checked against obstacles: a base may stand on a table. Pairs of links that are neighbours, that
never come near each other or that always touch are left out; see `Arm.collision_pairs`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cached_property
from typing import overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from leadthrough import _core, check
from leadthrough.arm.collision_report import Approach, Clearance, CollisionPairs, CollisionReport
from leadthrough.arm.definition import ArmDefinition
from leadthrough.arm.joint_rows import joint_rows
from leadthrough.arm.meshes import hull_vertices
from leadthrough.arm.reachable import look_at_obstacles
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput, InvalidRobot
from leadthrough.motion import JointTrajectory
from leadthrough.shapes import Shape, check_shapes, compiled

_FINEST_TOLERANCE = 1e-6  # m; distances are exact to 1e-7
# Steps of a check between two samples: more would take minutes.
_MOST_STEPS = 1e6

# Of the core: sample, two bodies, distance, two points.
_Found = tuple[float, int, int, float, Float64Array, Float64Array]


class ArmCollision(ArmDefinition):
    """The methods of an `Arm` that tell what it touches."""

    @overload
    def distance(
        self, q: Sequence[float], obstacles: Iterable[Shape], *, threads: int = 1
    ) -> float: ...
    @overload
    def distance(
        self, q: Sequence[Sequence[float]], obstacles: Iterable[Shape], *, threads: int = 1
    ) -> Float64Array: ...
    @overload
    def distance(
        self, q: ArrayLike, obstacles: Iterable[Shape], *, threads: int = 1
    ) -> float | Float64Array: ...
    def distance(
        self, q: ArrayLike, obstacles: Iterable[Shape], *, threads: int = 1
    ) -> float | Float64Array:
        """Smallest distance in m between obstacles and what moves of the arm.

        Where they overlap it is the depth of the overlap, negative; without obstacles it is
        infinite.

        Args:
            q: configuration (joints,) or a batch (m, joints).
            obstacles: shapes in the base frame.
            threads: number of threads, 1 to 256; does not change the answer.

        Returns:
            A number, or (m,) for a batch.

        Raises:
            InvalidInput: if q has another shape or is not finite, or an obstacle is no shape.
            InvalidRobot: if the robot has no collision geometry, or a mesh is missing or flat.
            MissingDependency: if a mesh's format needs a package that is not installed.
        """
        return self._nearest(q, self._against(obstacles), threads)

    @overload
    def self_distance(self, q: Sequence[float], *, threads: int = 1) -> float: ...
    @overload
    def self_distance(self, q: Sequence[Sequence[float]], *, threads: int = 1) -> Float64Array: ...
    @overload
    def self_distance(self, q: ArrayLike, *, threads: int = 1) -> float | Float64Array: ...
    def self_distance(self, q: ArrayLike, *, threads: int = 1) -> float | Float64Array:
        """Smallest distance in m between parts of the arm, or of the robot; see `distance`.

        `collision_pairs` tells which parts are compared.

        Args:
            q: configuration (joints,) or a batch (m, joints).
            threads: number of threads, 1 to 256; does not change the answer.

        Returns:
            A number, or (m,) for a batch.

        Raises:
            InvalidInput: if q has another shape or is not finite.
            InvalidRobot: if the robot has no collision geometry, or a mesh is missing or flat.
            MissingDependency: if a mesh's format needs a package that is not installed.
        """
        return self._nearest(q, _core.itself(self._collision), threads)

    @overload
    def is_clear(
        self,
        q: Sequence[float],
        obstacles: Iterable[Shape] = ...,
        *,
        margin: float = ...,
        self_margin: float = ...,
    ) -> bool: ...
    @overload
    def is_clear(
        self,
        q: ArrayLike,
        obstacles: Iterable[Shape] = ...,
        *,
        margin: float = ...,
        self_margin: float = ...,
    ) -> bool | NDArray[np.bool_]: ...
    def is_clear(
        self,
        q: ArrayLike,
        obstacles: Iterable[Shape] = (),
        *,
        margin: float = 0.0,
        self_margin: float = 0.0,
    ) -> bool | NDArray[np.bool_]:
        """Whether the whole arm keeps clear of obstacles and of itself; quicker than distances.

        Args:
            q: configuration (joints,) or a batch (m, joints).
            obstacles: shapes in the base frame.
            margin: distance to keep from obstacles in m, >= 0.
            self_margin: distance to keep between parts of the arm in m, >= 0.

        Returns:
            One answer, or (m,) for a batch.

        Raises:
            InvalidInput: if q has another shape or is not finite, an obstacle is no shape, or a
                margin is negative.
            InvalidRobot: if the robot has no collision geometry, or a mesh is missing or flat.
            MissingDependency: if a mesh's format needs a package that is not installed.
        """
        batch, (rows,) = joint_rows(self._chain, q=q)
        shapes = compiled(check_shapes(obstacles))
        least = check.number(margin, "margin", at_least=0.0)
        least_itself = check.number(self_margin, "self_margin", at_least=0.0)
        clear = _core.clear_batch(self._collision, shapes, rows, least, least_itself)
        return np.array(clear) if batch else clear[0]

    def check(
        self,
        trajectory: JointTrajectory | ArrayLike,
        obstacles: Iterable[Shape] = (),
        *,
        margin: float = 0.0,
        self_margin: float = 0.0,
        tolerance: float = 1e-3,
        threads: int = 1,
    ) -> CollisionReport:
        """Whether the whole arm keeps clear of obstacles and of itself, between samples as well.

        Between samples the joints move straight, all in proportion. A hit is reported, never
        raised.

        Args:
            trajectory: joints, or configurations (m, joints), m > 0.
            obstacles: shapes in the base frame.
            margin: distance to keep from obstacles in m, >= 0.
            self_margin: distance to keep between parts of the arm in m, >= 0.
            tolerance: in m, >= 1e-6; a hit between samples that is deeper than this isn't missed.
            threads: number of threads, 1 to 256; does not change the answer.

        Raises:
            InvalidInput: if the joints are not the arm's, an obstacle is no shape, a number is out
                of its range, or two samples are too far apart to be checked to the tolerance.
            InvalidRobot: if the robot has no collision geometry, or a mesh is missing or flat.
            MissingDependency: if a mesh's format needs a package that is not installed.

        Source: Mirtich 1996.
        """
        q, times = _configurations(trajectory, self.joint_names)
        scenes = (self._against(obstacles), _core.itself(self._collision))
        exact = check.number(tolerance, "tolerance", at_least=_FINEST_TOLERANCE)
        margins = (
            check.number(margin, "margin", at_least=0.0),
            check.number(self_margin, "self_margin", at_least=0.0),
        )
        count = check.integer(threads, "threads", at_least=1, at_most=256)
        _require_short_steps(scenes, q, exact)
        from_obstacles, from_itself = (
            _clearance(scene, least, times, _core.check_motion(scene, q, least, exact, count))
            for scene, least in zip(scenes, margins, strict=True)
        )
        return CollisionReport(from_obstacles, from_itself, tolerance=exact)

    @property
    def collision_pairs(self) -> CollisionPairs:
        """Which bodies are checked against each other, and why others are not.

        Raises:
            InvalidRobot: if the robot has no collision geometry, or a mesh is missing or flat.
            MissingDependency: if a mesh's format needs a package that is not installed.
        """
        model = self._collision
        return CollisionPairs(tuple(model.pairs), {(a, b): why for a, b, why in model.left_out})

    @cached_property
    def _collision(self) -> _core.CollisionModel:
        """The shapes of the robot and the pairs worth a check; some 10 ms to choose them."""
        meshes = [hull_vertices(*mesh, self.mesh_folders) for mesh in self._robot.meshes]
        model = _core.CollisionModel(
            self._robot, self._chain, self.base, self.tip, meshes, compiled(self.attached)
        )
        if not model.bodies:
            raise InvalidRobot("robot", "no link has collision geometry, so nothing can be checked")
        return model

    def _against(self, obstacles: Iterable[Shape]) -> _core.CollisionScene:
        shapes = check_shapes(obstacles)
        look_at_obstacles(self, shapes)
        return _core.against(self._collision, compiled(shapes))

    def _nearest(
        self, q: ArrayLike, scene: _core.CollisionScene, threads: int
    ) -> float | Float64Array:
        batch, (rows,) = joint_rows(self._chain, q=q)
        count = check.integer(threads, "threads", at_least=1, at_most=256)
        found = _core.nearest_bodies(scene, rows, count)[0]
        return found if batch else float(found[0])


def _configurations(
    trajectory: JointTrajectory | ArrayLike, joint_names: tuple[str, ...]
) -> tuple[Float64Array, Float64Array | None]:
    """Checked configurations (m, joints), m > 0, and their times where they have some."""
    times = None
    values: ArrayLike
    if isinstance(trajectory, JointTrajectory):
        if trajectory.joint_names and trajectory.joint_names != joint_names:
            raise InvalidInput(
                f"trajectory: expected the joints {joint_names}, got {trajectory.joint_names}"
            )
        values, times = trajectory.positions, trajectory.times
    else:
        values = trajectory
    q = check.array(values, "trajectory", shape=("m", len(joint_names)))
    if len(q) == 0:
        raise InvalidInput("trajectory: expected at least one configuration, got none")
    return q, times


def _require_short_steps(
    scenes: Iterable[_core.CollisionScene], q: Float64Array, tolerance: float
) -> None:
    step = max(_core.longest_step(scene, q) for scene in scenes)
    if not step <= tolerance * _MOST_STEPS:
        raise InvalidInput(
            f"trajectory: between two samples the arm may move by {step:.3g} m, too far to be "
            f"checked to {tolerance:g} m; take smaller steps or a larger tolerance"
        )


def _clearance(
    scene: _core.CollisionScene,
    margin: float,
    times: Float64Array | None,
    found: tuple[Float64Array, _Found | None, _Found | None],
) -> Clearance:
    distances, closest, first = found
    return Clearance(
        first=_approach(scene, times, first),
        closest=_approach(scene, times, closest),
        distances=distances,
        margin=margin,
    )


def _approach(
    scene: _core.CollisionScene, times: Float64Array | None, found: _Found | None
) -> Approach | None:
    if found is None or np.isinf(found[3]):
        return None
    sample, a, b, gap, on_a, on_b = found
    time = None if times is None else float(np.interp(sample, np.arange(len(times)), times))
    return Approach(sample, time, (scene.names[a], scene.names[b]), gap, np.stack([on_a, on_b]))

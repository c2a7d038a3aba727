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
from leadthrough.shapes import SceneLike, Shape, as_scene, compiled

_FINEST_TOLERANCE = 1e-6  # m; distances are exact to 1e-7
# Steps of a check between two samples: more would take minutes.
_MOST_STEPS = 1e6

# Of the core: sample, two bodies, distance, two points.
_Found = tuple[float, int, int, float, Float64Array, Float64Array]


class ArmCollision(ArmDefinition):
    """The methods of an `Arm` that tell what it touches."""

    @overload
    def distance(self, q: Sequence[float], scene: SceneLike, *, threads: int = 1) -> float: ...
    @overload
    def distance(
        self, q: Sequence[Sequence[float]], scene: SceneLike, *, threads: int = 1
    ) -> Float64Array: ...
    @overload
    def distance(
        self, q: ArrayLike, scene: SceneLike, *, threads: int = 1
    ) -> float | Float64Array: ...
    def distance(self, q: ArrayLike, scene: SceneLike, *, threads: int = 1) -> float | Float64Array:
        """Minimum distance, m, between obstacles and the arm's moving links.

        Where they overlap it is the depth of the overlap, negative; without obstacles it is
        infinite.

        Args:
            q: configuration (joints,) or a batch (m, joints).
            scene: the obstacles, as a `Scene` or a list of shapes; the margins are not used.
            threads: number of threads, 1 to 256; does not change the answer.

        Returns:
            A number, or (m,) for a batch.

        Raises:
            InvalidInput: if q has another shape or is not finite, or an obstacle is not a shape.
            InvalidRobot: if the robot has no collision geometry, or a mesh is missing or flat.
            MissingDependency: if a mesh's format needs a package that is not installed.
        """
        return self._nearest(q, self._against(as_scene(scene).shapes), threads)

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
    def is_clear(self, q: Sequence[float], scene: SceneLike = ...) -> bool: ...
    @overload
    def is_clear(self, q: ArrayLike, scene: SceneLike = ...) -> bool | NDArray[np.bool_]: ...
    def is_clear(self, q: ArrayLike, scene: SceneLike = ()) -> bool | NDArray[np.bool_]:
        """Whether the whole arm keeps the margins of a scene; quicker than distances.

        Args:
            q: configuration (joints,) or a batch (m, joints).
            scene: the obstacles and margins; a list of shapes has the default margins.

        Returns:
            One answer, or (m,) for a batch.

        Raises:
            InvalidInput: if q has another shape or is not finite, or the scene is malformed.
            InvalidRobot: if the robot has no collision geometry, or a mesh is missing or flat.
            MissingDependency: if a mesh's format needs a package that is not installed.
        """
        batch, (rows,) = joint_rows(self._chain, q=q)
        around = as_scene(scene)
        margins = around.margin, around.self_collision_margin
        clear = _core.clear_batch(self._collision, compiled(around.shapes), rows, *margins)
        return np.array(clear) if batch else clear[0]

    def check(
        self,
        trajectory: JointTrajectory | ArrayLike,
        scene: SceneLike = (),
        *,
        tolerance: float = 1e-3,
        threads: int = 1,
    ) -> CollisionReport:
        """Whether the whole arm keeps the margins of a scene, between samples as well.

        Between samples the joints move straight, all in proportion. A hit is reported, never
        raised.

        Args:
            trajectory: joints, or configurations (m, joints), m > 0.
            scene: the obstacles and margins; a list of shapes has the default margins.
            tolerance: in m, >= 1e-6; a hit between samples that is deeper than this isn't missed.
            threads: number of threads, 1 to 256; does not change the answer.

        Raises:
            InvalidInput: if the joints are not the arm's, the scene is malformed, a number is out
                of its range, or two samples are too far apart to be checked to the tolerance.
            InvalidRobot: if the robot has no collision geometry, or a mesh is missing or flat.
            MissingDependency: if a mesh's format needs a package that is not installed.

        Source: Mirtich 1996.
        """
        q, times = _configurations(trajectory, self.joint_names)
        around = as_scene(scene)
        pairs = (self._against(around.shapes), _core.itself(self._collision))
        exact = check.number(tolerance, "tolerance", at_least=_FINEST_TOLERANCE)
        margins = (around.margin, around.self_collision_margin)
        count = check.integer(threads, "threads", at_least=1, at_most=256)
        _require_short_steps(pairs, q, exact)
        from_obstacles, from_itself = (
            _clearance(each, margin, times, _core.check_motion(each, q, margin, exact, count))
            for each, margin in zip(pairs, margins, strict=True)
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

    def _against(self, shapes: Sequence[Shape]) -> _core.CollisionScene:
        look_at_obstacles(self, shapes)
        return _core.against(self._collision, compiled(shapes))

    def _nearest(
        self, q: ArrayLike, pairs: _core.CollisionScene, threads: int
    ) -> float | Float64Array:
        batch, (rows,) = joint_rows(self._chain, q=q)
        count = check.integer(threads, "threads", at_least=1, at_most=256)
        found = _core.nearest_bodies(pairs, rows, count)[0]
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
    both: Iterable[_core.CollisionScene], q: Float64Array, tolerance: float
) -> None:
    step = max(_core.longest_step(pairs, q) for pairs in both)
    if not step <= tolerance * _MOST_STEPS:
        raise InvalidInput(
            f"trajectory: between two samples the arm may move by {step:.3g} m, too far to be "
            f"checked to {tolerance:g} m; take smaller steps or a larger tolerance"
        )


def _clearance(
    pairs: _core.CollisionScene,
    margin: float,
    times: Float64Array | None,
    found: tuple[Float64Array, _Found | None, _Found | None],
) -> Clearance:
    distances, closest, first = found
    return Clearance(
        first=_approach(pairs, times, first),
        closest=_approach(pairs, times, closest),
        distances=distances,
        margin=margin,
    )


def _approach(
    pairs: _core.CollisionScene, times: Float64Array | None, found: _Found | None
) -> Approach | None:
    if found is None or np.isinf(found[3]):
        return None
    sample, a, b, gap, on_a, on_b = found
    time = None if times is None else float(np.interp(sample, np.arange(len(times)), times))
    return Approach(sample, time, (pairs.names[a], pairs.names[b]), gap, np.stack([on_a, on_b]))

"""Clearance of everything that a command of joints moves: of one arm, or of two side by side."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

import leadthrough._core as core
from leadthrough.arm import collision
from leadthrough.arm.collision import CollisionPairs, CollisionReport
from leadthrough.arm.kinematics import joint_rows
from leadthrough.arm.tip_path import CollisionTest
from leadthrough.check import Float64Array
from leadthrough.motion import JointTrajectory, in_order
from leadthrough.shapes import SceneLike, as_scene


class CollisionQueries(ABC):
    """Distances and checks of a collision model at configurations and along motions."""

    @property
    @abstractmethod
    def _collision(self) -> core.CollisionModel:
        """The collision shapes and the pairs of them to check."""

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

        If they overlap it is the depth of the overlap, negative; without obstacles it is
        infinite. The scene's margins are not used.
        """
        pairs = collision.against(self._collision, as_scene(scene).shapes)
        return collision.nearest(self._collision.chain, q, pairs, threads)

    @overload
    def self_distance(self, q: Sequence[float], *, threads: int = 1) -> float: ...
    @overload
    def self_distance(self, q: Sequence[Sequence[float]], *, threads: int = 1) -> Float64Array: ...
    @overload
    def self_distance(self, q: ArrayLike, *, threads: int = 1) -> float | Float64Array: ...
    def self_distance(self, q: ArrayLike, *, threads: int = 1) -> float | Float64Array:
        """Smallest distance in m between parts of the arm, or of the robot; see `distance`.

        `collision_pairs` lists the parts that are compared.
        """
        return collision.nearest(self._collision.chain, q, core.itself(self._collision), threads)

    @overload
    def is_clear(self, q: Sequence[float] | JointTrajectory, scene: SceneLike = ...) -> bool: ...
    @overload
    def is_clear(self, q: ArrayLike, scene: SceneLike = ...) -> bool | NDArray[np.bool_]: ...
    def is_clear(
        self, q: JointTrajectory | ArrayLike, scene: SceneLike = ()
    ) -> bool | NDArray[np.bool_]:
        """Whether the whole arm keeps the margins of a scene; quicker than distances.

        A motion is certified between its samples too, where the joints move straight; within 0.1 mm
        of a margin it may count as too near.

        Args:
            q: one configuration (joints,), several (m, joints), or a motion.

        Returns:
            One answer, or (m,) for several configurations.
        """
        test = CollisionTest(self._collision, as_scene(scene))
        if isinstance(q, JointTrajectory):
            return test.clear_between(in_order(q, self._collision.chain.joint_names, "q").positions)
        batch, (rows,) = joint_rows(self._collision.chain, q=q)
        clear = test.clear_rows(rows)
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
            tolerance: in m, >= 1e-6; a hit between samples that is deeper than this isn't missed.

        Raises:
            InvalidInput: if the joints are not the arm's, or two samples are too far apart for the
                tolerance.

        Source: Mirtich 1996.
        """
        return collision.check_motion(
            self._collision, trajectory, scene, tolerance=tolerance, threads=threads
        )

    @property
    def collision_pairs(self) -> CollisionPairs:
        """The pairs of bodies that are checked, and why others are left out.

        Raises:
            InvalidRobot: if the robot has no collision geometry, or a mesh is missing or flat.
            MissingDependency: if a mesh's format needs a package that is not installed.
        """
        model = self._collision
        return CollisionPairs(tuple(model.pairs), {(a, b): why for a, b, why in model.left_out})

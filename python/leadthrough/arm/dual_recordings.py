"""Recordings of two arms: their joints, the motions of their tips, and the other arm's base."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence

from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.arm import recorded_joints
from leadthrough.arm.arm import Arm
from leadthrough.arm.base_location import BaseLocation, Carried, located
from leadthrough.arm.collision_queries import CollisionQueries
from leadthrough.arm.dual_demonstration import DualDemonstration
from leadthrough.arm.limits import JointLimits
from leadthrough.arm.rigid_transforms import Transforms
from leadthrough.check import Float64Array
from leadthrough.motion import (
    Demonstration,
    JointTrajectory,
    Motion,
    PoseTrajectory,
    as_demonstration,
)


class DualRecordings(CollisionQueries):
    """Methods of a pair of arms that take recordings, documented where they are public."""

    left: Arm
    right: Arm
    limits: JointLimits

    @property
    @abstractmethod
    def _placement(self) -> Transforms:
        """Pose of the right base in the left base frame."""

    @abstractmethod
    def split(self, q: ArrayLike) -> tuple[Float64Array, Float64Array]:
        """Joints of the left and of the right arm, of one configuration or a batch."""

    @abstractmethod
    def forward_kinematics(self, q: ArrayLike) -> tuple[Float64Array, Float64Array]:
        """Positions and orientations of both tips."""

    def joints_of(self, trajectory: Motion) -> JointTrajectory:
        """The joints of both arms in a recording, selected by name, in the pair's order.

        Args:
            trajectory: joints, as `Arm.joints_of` takes them.

        Raises:
            InvalidInput: for another kind of motion, or if a joint is missing.
        """
        return recorded_joints.joints_of(self.limits, trajectory)

    def demonstration(self, recording: Demonstration | JointTrajectory) -> DualDemonstration:
        """Motions of both tips in a recording of joints, with the joints.

        Args:
            recording: as `joints_of` takes it.
        """
        given = as_demonstration(recording, "recording")
        own = self.joints_of(given.motion)
        positions, orientations = self.forward_kinematics(own.positions)
        left, right = (
            PoseTrajectory(own.times, positions[:, k], orientations[:, k], own.events)
            for k in range(2)
        )
        return DualDemonstration(left, right, own, given.name)

    def located(self, demonstrations: Sequence[Demonstration | JointTrajectory]) -> BaseLocation:
        """The right base, from joints recorded while both arms hold one object.

        The search starts at the pair's own `base`, which need not be nearer than some 0.3 m and
        0.5 rad. In every demonstration the arms may hold the object at other places.

        Args:
            demonstrations: as `joints_of` takes them, at least one.

        Raises:
            FitError: if a standard deviation of the base would exceed 1 mm or 0.1 degrees, as it
                does if the object only turns about one axis.

        Source: Strobl and Hirzinger 2006.
        """
        joints = [
            self.joints_of(as_demonstration(each, f"demonstrations[{i}]").motion).positions
            for i, each in enumerate(demonstrations)
        ]
        if not joints:
            raise check.refused("demonstrations", "at least one", "none")
        arms = self.left, self.right
        return located([Carried.of(arms, self.split(rows)) for rows in joints], self._placement)

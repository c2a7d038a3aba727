"""An object in the hands of two arms, asked as one arm whose tip is the object."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check
from leadthrough.arm.collision_queries import CollisionQueries
from leadthrough.arm.dual_arm import TOLERANCE, DualArm, checked_tolerance
from leadthrough.arm.following import FollowOptions
from leadthrough.arm.inverse_kinematics import IkBatch, IkOptions
from leadthrough.arm.limits import JointLimits
from leadthrough.arm.rigid_transforms import Pose, Transforms, checked_grasps
from leadthrough.check import Float64Array, IkFailure, ShortRepr
from leadthrough.motion import JointTrajectory, PoseTrajectory, Trajectory
from leadthrough.shapes import SceneLike


@dataclass(frozen=True, eq=False)
class HeldObject(CollisionQueries, ShortRepr):
    """An object that a pair of arms holds; `plan_motion` takes it as an arm whose tip it is.

    Attributes:
        pair: the arms.
        grasps: poses of the left and of the right tip in the object's frame.
        tolerance: the most that the tips' relative pose may be off between samples, (m, rad).
    """

    pair: DualArm
    grasps: tuple[Pose, Pose]
    tolerance: tuple[float, float] = TOLERANCE

    def __post_init__(self) -> None:
        if not isinstance(self.pair, DualArm):
            raise check.refused("pair", "a DualArm", repr(self.pair))
        left, right = checked_grasps(self.grasps, Transforms.of)
        object.__setattr__(self, "grasps", (left.single(), right.single()))
        checked_tolerance(self.tolerance)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints of both arms, the left ones first."""
        return self.pair.joint_names

    @property
    def limits(self) -> JointLimits:
        """The limits of those joints."""
        return self.pair.limits

    @property
    def _collision(self) -> core.CollisionModel:
        return self.pair._collision

    def follow(
        self,
        motion: Trajectory | PoseTrajectory,
        *,
        q0: ArrayLike | None = None,
        options: FollowOptions | None = None,
        scene: SceneLike | None = None,
    ) -> JointTrajectory:
        """Joints of both arms along a motion of the object, as by `DualArm.follow`."""
        if not isinstance(motion, PoseTrajectory):
            raise check.refused("motion", "poses of the object", type(motion).__name__)
        try:
            return self.pair.follow(
                motion, self.grasps, scene=scene, q0=q0, tolerance=self.tolerance, options=options
            )
        except IkFailure as error:
            if len(error.q) != len(self.joint_names):  # of one arm alone: the other is anywhere
                arms = self.pair.left, self.pair.right
                error.q = np.hstack([arm._chain.middle for arm in arms])
            raise

    def inverse_kinematics_batch(
        self,
        positions: Float64Array,
        orientations: Float64Array | None,
        *,
        q0: Float64Array,
        options: IkOptions,
    ) -> IkBatch:
        """Configurations (m, joints) of both arms for poses (m, 3), (m, 4) of the object.

        The status, and the joints that limit, are of the first arm that fails.
        """
        assert orientations is not None  # the object's motion has them
        at, arms = Transforms(positions, orientations), (self.pair.left, self.pair.right)
        by_left, by_right = (at @ grasp for grasp in checked_grasps(self.grasps, Transforms.of))
        tips = by_left, self.pair._placement.inverse() @ by_right
        left, right = (
            arm.inverse_kinematics_batch(tip.positions, tip.orientations, q0=start, options=options)
            for arm, start, tip in zip(arms, self.pair.split(q0), tips, strict=True)
        )
        return IkBatch(
            q=np.hstack([left.q, right.q]),
            success=left.success & right.success,
            status=np.where(left.success, right.status, left.status),
            position_error=np.maximum(left.position_error, right.position_error),
            orientation_error=np.maximum(left.orientation_error, right.orientation_error),
            iterations=left.iterations + right.iterations,
            limiting_joints=np.hstack([left.limiting_joints, right.limiting_joints]),
        )

    def poses(self, trajectory: JointTrajectory) -> PoseTrajectory:
        """Motion of the object with joints of both arms, in the middle of where either has it."""
        return self.pair.demonstration(trajectory).object(self.grasps).motion

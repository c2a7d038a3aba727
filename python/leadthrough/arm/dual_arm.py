"""Two arms side by side: kinematics of each, rows of joints and a collision model of both.

An object in their hands is asked as one arm whose tip it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check
from leadthrough.arm import recorded_joints
from leadthrough.arm.arm import Arm, check_arm
from leadthrough.arm.collision import CollisionQueries
from leadthrough.arm.dual_demonstration import BaseLocation, Carried, DualDemonstration, located
from leadthrough.arm.dual_following import SIDES, Carry, Grasp, motions_of, shape_seen_from, tips_of
from leadthrough.arm.following import FollowOptions, checked_options, positive_errors, timed
from leadthrough.arm.inverse_kinematics import IkBatch, IkOptions, IkResult
from leadthrough.arm.limits import COLUMNS, JointLimits
from leadthrough.arm.rigid_transforms import Pose, Transforms, checked_grasps
from leadthrough.check import Float64Array, IkFailure, InvalidInput, ShortRepr, one_line
from leadthrough.motion import (
    Demonstration,
    JointTrajectory,
    Motion,
    PoseTrajectory,
    Trajectory,
    as_demonstration,
    in_order,
)
from leadthrough.shapes import SceneLike, Solid, as_scene, names_of

# m and rad, of the tips' relative pose between samples.
TOLERANCE = (1e-4, 3.5e-4)
_MAX_JOINTS = 16  # of the core


@dataclass(frozen=True, eq=False)
class DualArm(CollisionQueries, ShortRepr):
    """Two arms in one frame, the base frame of the left one.

    A configuration is (joints,), the joints of the left arm first; a batch is (m, joints). The
    frame of poses and obstacles is that of the left base. The limits and the pair are taken as an
    arm's are: by `retime`, `keep_timing`, `check_limits`, `Guard` and `connect`. A pair never
    changes.

    To `distance`, `check` and all that keep a scene's margin, each arm is an obstacle of the other.
    `self_distance` and the self-collision margin are of each arm alone.

    Attributes:
        left: the arm whose base frame is that of the pair.
        right: the other arm.
        base: position (3,) in m and orientation (4,) w, x, y, z of the right base in the left base
            frame. Without it both are arms of one robot: of the same document, with the same base
            link and locked joints, and no joint in common.
        shared_object: whether the right arm holds the objects attached to the left one as well.
        joint_names: of all joints. If the arms share a name, theirs get "left_" and "right_" in
            front.
        limits: of all joints.
    """

    left: Arm
    right: Arm
    base: Pose | None = None
    shared_object: bool = False
    joint_names: tuple[str, ...] = field(init=False, repr=False)
    limits: JointLimits = field(init=False, repr=False)

    def __post_init__(self) -> None:
        for arm in (self.left, self.right):
            check_arm(arm)
        if self.base is None:
            _require_one_robot(self.left, self.right)
        else:
            vars(self)["base"] = Transforms.of(self.base, "base").single()
        limits = _stacked(self.left.limits, self.right.limits)
        vars(self).update(limits=limits, joint_names=limits.joint_names)

    def _repr_parts(self) -> list[str]:
        names = f"{len(self.joint_names)} joints {self.joint_names[0]} ... {self.joint_names[-1]}"
        parts = [f"left={one_line(self.left)}", f"right={one_line(self.right)}", names]
        if self.base is not None:
            parts.append(f"right base at {check.numbers_text(self.base[0])} m")
        return [*parts, "one shared object"] if self.shared_object else parts

    @cached_property
    def _placement(self) -> Transforms:
        return Transforms.identity() if self.base is None else Transforms.of(self.base, "base")

    @cached_property
    def _collision(self) -> core.CollisionModel:
        """The shapes of both arms, and the pairs of them to check."""
        return self.left._collision.beside(
            self.right._collision,
            self._placement.positions[0],
            self._placement.orientations[0],
            self.base is None,
            self.shared_object,
            list(self.joint_names),
        )

    def with_object(self, shape: Solid, grasps: tuple[Pose, Pose], *, mass: float = 0.0) -> DualArm:
        """The pair holding an object with both hands.

        It is attached to the left arm, whose model carries its mass, and not checked against the
        links that move with the tips.

        Args:
            shape: as of `Arm.with_attached`, in the object's frame.
            grasps: poses of the left and of the right tip in the object's frame.
            mass: in kg, >= 0.
        """
        if not isinstance(shape, Solid):
            raise check.refused("shape", names_of(Solid), repr(shape))
        in_tip = shape_seen_from(shape, checked_grasps(grasps, Transforms.of)[0].inverse())
        return replace(self, left=self.left.with_attached(in_tip, mass), shared_object=True)

    def split(self, q: ArrayLike) -> tuple[Float64Array, Float64Array]:
        """Joints of the left and of the right arm, of one configuration or a batch."""
        rows, left = self._checked(q), len(self.left.joint_names)
        return np.ascontiguousarray(rows[..., :left]), np.ascontiguousarray(rows[..., left:])

    def motions(self, trajectory: JointTrajectory) -> tuple[JointTrajectory, JointTrajectory]:
        """Motions of the left and of the right arm, with the names of their own joints.

        Args:
            trajectory: with the joints of the pair.
        """
        own = in_order(trajectory, self.joint_names, "trajectory")
        return motions_of((self.left, self.right), own)

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

    def forward_kinematics(self, q: ArrayLike) -> tuple[Float64Array, Float64Array]:
        """Positions (2, 3) in m and orientations (2, 4) w, x, y, z of the left and the right tip.

        Of a batch they are (m, 2, 3) and (m, 2, 4).
        """
        rows = self._checked(q)
        left, right = self._tips(np.atleast_2d(rows))
        positions = np.stack([left.positions, right.positions], axis=1)
        orientations = np.stack([left.orientations, right.orientations], axis=1)
        return (positions[0], orientations[0]) if rows.ndim == 1 else (positions, orientations)

    def relative_pose(self, q: ArrayLike) -> tuple[Float64Array, Float64Array]:
        """Position (3,) and orientation (4,) w, x, y, z of the right tip in the left tip's frame.

        In m; of a batch they are (m, 3) and (m, 4).
        """
        rows = self._checked(q)
        left, right = self._tips(np.atleast_2d(rows))
        found = (left.inverse() @ right).continuous()
        return found.single() if rows.ndim == 1 else (found.positions, found.orientations)

    def jacobian(self, q: ArrayLike) -> Float64Array:
        """Geometric Jacobian (12, joints) of the left tip, then of the right tip.

        Linear rows come first of either. Of a batch it is (m, 12, joints).
        """
        left, right = self.split(q)
        joints = left.shape[-1]
        to_pair = np.kron(np.eye(2), self._placement.matrices()[0])
        result = np.zeros((*left.shape[:-1], 12, joints + right.shape[-1]))
        result[..., :6, :joints] = self.left.jacobian(left)
        result[..., 6:, joints:] = to_pair @ self.right.jacobian(right)
        return result

    def inverse_kinematics(
        self,
        left: Pose,
        right: Pose,
        *,
        q0: ArrayLike | None = None,
        seed: int = 0,
        options: IkOptions | None = None,
    ) -> tuple[IkResult, IkResult]:
        """Configurations of the left and of the right arm that bring their tips to poses.

        Args:
            left: position (3,) and orientation (4,) of the left tip.
            right: the same of the right tip.
            q0: configuration (joints,) of both where the searches start.
            options: of both arms.
        """
        starts = (None, None) if q0 is None else self.split(q0)
        at_left = Transforms.of(left, "left").single()
        at_right = (self._placement.inverse() @ Transforms.of(right, "right")).single()
        return (
            self.left.inverse_kinematics(*at_left, q0=starts[0], seed=seed, options=options),
            self.right.inverse_kinematics(*at_right, q0=starts[1], seed=seed, options=options),
        )

    def follow(
        self,
        motion: PoseTrajectory,
        grasps: tuple[Pose | PoseTrajectory, Pose | PoseTrajectory],
        *,
        scene: SceneLike | None = None,
        q0: ArrayLike | None = None,
        tolerance: tuple[float, float] = TOLERANCE,
        options: FollowOptions | None = None,
    ) -> JointTrajectory:
        """Joints that carry an object along its motion, held by both arms.

        The times are stretched for both arms alike if a joint would exceed its velocity or
        acceleration limit. Between samples the joints move straight.

        Args:
            motion: poses of the object. Its `joints`, if they are the pair's, are preferred.
            grasps: poses of the left and of the right tip in the object's frame; of one that moves
                there, as a tip that wipes what the other holds, its motion, on the object's clock.
            scene: obstacles that both arms keep clear of, and they of each other, between samples
                too. None checks nothing.
            q0: configuration (joints,) where the searches for the first sample start.
            tolerance: the most that the tips' relative pose may be off between samples, (m, rad),
                both > 0. Samples are added to the motion's until it holds.
            options: of both arms, as of `Arm.follow`; a `posture` is of the pair. Axes that are
                `free` are refused: the object would not be held.

        Raises:
            InvalidInput: if the motion is not of poses, or an option does not fit.
            IkFailure: if an arm misses a sample; the message begins with the arm. With the status
                "blocked" no two postures are clear, and two bodies of the first ones are named.
            InvalidRobot: if there is a scene and a robot has no collision geometry.
            LimitsInfeasible: if a joint has to move whose limits are zero.
        """
        check.instance(motion, "motion", PoseTrajectory)
        around = None if scene is None else as_scene(scene)
        carry = Carry(
            (self.left, self.right),
            self._placement,
            None if around is None else self._collision,
            checked_grasps(grasps, partial(_grasp, motion)),
            (None, None) if q0 is None else self.split(q0),
            self._options(checked_options(options)),
            around,
            checked_tolerance(tolerance),
        )
        path, q = carry.along(replace(motion, joints=self._own(motion.joints)))
        return timed(self.limits, path, q, "slow")

    def _options(self, options: FollowOptions) -> tuple[FollowOptions, FollowOptions]:
        if options.free:
            raise InvalidInput("free: expected none, as both arms hold the object; remove it")
        posture = options.posture
        if posture is None:
            return options, options
        if isinstance(posture, Motion):
            posture = in_order(posture, self.joint_names, "posture")
        own = self.motions(posture) if isinstance(posture, Motion) else self.split(posture)
        return replace(options, posture=own[0]), replace(options, posture=own[1])

    def _own(self, joints: JointTrajectory | None) -> JointTrajectory | None:
        """Recorded joints, if they are the pair's."""
        if joints is None or sorted(joints.joint_names) != sorted(self.joint_names):
            return None
        return in_order(joints, self.joint_names, "motion")

    def _checked(self, q: ArrayLike) -> Float64Array:
        joints = len(self.joint_names)
        return check.array_of_rank(q, "q", shapes=((joints,), ("m", joints)))

    def _tips(self, q: Float64Array) -> tuple[Transforms, Transforms]:
        """Poses of both tips at configurations (m, joints)."""
        return tips_of((self.left, self.right), self._placement, q)


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
        vars(self)["grasps"] = left.single(), right.single()
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


def check_arms(arm: object) -> None:
    """Raises InvalidInput unless `arm` is an Arm or a DualArm."""
    if not isinstance(arm, DualArm):
        check_arm(arm)


def _grasp(motion: PoseTrajectory, grasp: Pose | PoseTrajectory, name: str) -> Grasp:
    """The pose of a tip in the object's frame, or its motion there as long as the object's."""
    if not isinstance(grasp, PoseTrajectory):
        return Transforms.of(grasp, name)
    begin, end = motion.times[[0, -1]]
    if grasp.times[0] > begin or grasp.times[-1] < end:
        raise check.refused(name, f"a motion from {begin:g} to {end:g} s", repr(grasp))
    return grasp


def checked_tolerance(tolerance: tuple[float, float]) -> tuple[float, float]:
    if not isinstance(tolerance, tuple | list) or len(tolerance) != 2:
        raise check.refused("tolerance", "(m, rad)", repr(tolerance))
    return positive_errors(tolerance[0], tolerance[1], "tolerance")


def _require_one_robot(left: Arm, right: Arm) -> None:
    """Refuses arms that are not of one robot, or share a joint."""
    for name in ("document", "base", "locked_joints", "mesh_folders"):
        if getattr(left, name) != getattr(right, name):
            raise InvalidInput(
                "base: expected the pose of the right base in the left base frame, got None, and "
                f"the arms are not of one robot: their {name} differs"
            )
    common = [name for name in left.joint_names if name in right.joint_names]
    if common:
        raise InvalidInput(
            f"right: expected no joint in common with the left arm, got {', '.join(common)}; lock "
            "joints of a common trunk with lock_joints, or give the pose of another robot's base"
        )


def _stacked(left: JointLimits, right: JointLimits) -> JointLimits:
    """Limits of all joints; those that are not known of both arms are not known."""
    names = [*left.joint_names, *right.joint_names]
    if len(names) > _MAX_JOINTS:
        raise check.refused("right", f"at most {_MAX_JOINTS} joints of both arms", len(names))
    if set(left.joint_names) & set(right.joint_names):
        sides = zip(SIDES, (left, right), strict=True)
        names = [f"{side}_{name}" for side, limits in sides for name in limits.joint_names]
    pairs = {key: (getattr(left, key), getattr(right, key)) for key in COLUMNS}
    columns: dict[str, Any] = {
        key: None if any(part is None for part in parts) else np.concatenate(parts)
        for key, parts in pairs.items()
    }
    return JointLimits(names, **columns)

"""From motions of the tip to joint trajectories, and back."""

from __future__ import annotations

from collections.abc import Sequence

from numpy.typing import ArrayLike

from leadthrough.arm import follower, reachable, recorded
from leadthrough.arm.clearing import CollisionTest
from leadthrough.arm.collision import ArmCollision
from leadthrough.arm.follower import TooFast
from leadthrough.arm.options import Axis
from leadthrough.arm.path_report import PathReport, path_report
from leadthrough.arm.tracks import TipPath
from leadthrough.errors import InvalidInput
from leadthrough.motion import JointTrajectory, Motion, PoseTrajectory, Trajectory
from leadthrough.shapes import SceneLike, as_scene


class ArmFollowing(ArmCollision):
    """The methods of an `Arm` that take its tip along a motion."""

    def follow(
        self,
        motion: Trajectory | PoseTrajectory,
        *,
        seed: ArrayLike | None = None,
        too_fast: TooFast = "slow",
        deviation: tuple[ArrayLike, ArrayLike] | None = None,
        max_step: float = 0.5,
        posture: Motion | ArrayLike | None = None,
        midrange: float | None = None,
        free: Sequence[Axis] | None = None,
        position_tolerance: float = 1e-5,
        orientation_tolerance: float = 1e-5,
        scene: SceneLike | None = None,
    ) -> JointTrajectory:
        """Joint positions and velocities that take the tip along a motion without a jump.

        There is one sample for each of the motion's, with its events. Velocities are the time
        differences of the positions (second order). Accelerations are left to the time law.

        Args:
            motion: poses, or points in 3-D that leave the orientation free.
            seed: configuration (joints,) where the search for the first sample's posture starts.
                Without it, and without a posture to stay near to, several postures are followed
                ahead, and the best one is kept.
            too_fast: what to do where the arm's velocity and acceleration limits are too low for
                the motion's pace, as beside a singularity.
                "slow": stretch the times just there; the path is kept.
                "deviate": let the tip fall behind by at most `deviation` and catch up; the times
                are kept.
                "raise": raise IkFailure with the status "too_fast".
                "exceed_limits": keep path and times and exceed the limits, for a time law such as
                `retime` or `scale_to_limits` to slow the motion down.
                Except with "exceed_limits" the arm starts and ends at rest, and acceleration
                limits that are not known don't count. Between samples the joints move straight.
            deviation: the most that the tip may be away from a sample, (m, rad); required with
                "deviate". With obstacles the tip leaves its path by no more than that, but at its
                ends not at all, where the arm has no room otherwise. Then each of the two may be
                0, three numbers along and about the axes of the sample's frame, or matrices
                (n, 3, 3), in m^2 and the base frame and in rad^2 and the sample's, such as four
                times covariances for two standard deviations. It is an ellipsoid: of lengths and
                angles together, the squares of the fractions used add up to 1 at the most.
                `path_report` tells how far the tip is off.
            max_step: the most that a joint may move between two samples, rad or m, > 0; a larger
                step is a jump.
            posture: the configuration (joints,) towards which a redundant arm moves in its null
                space; or a JointTrajectory, taken at the same fraction of its duration. By default
                the motion's own `joints`, those that the arm was shown with, if they are this
                arm's; otherwise the middle of the joints' ranges. Without a seed the search starts
                where a trajectory begins. Only where the motion's own joints lead to a dead end
                does the arm start in another posture.
            midrange: rate in 1/s, >= 0, of the motion towards `posture`; by default 1, and 10
                towards the motion's own joints.
            free: axes of the poses left free, as in `inverse_kinematics`. By default none; an arm
                of fewer than six joints that cannot follow leaves as many rotations free as
                it lacks joints, those about the axes of the tip by which it turns away least.
                `path_report` tells how far. Only with "slow" and "exceed_limits".
            position_tolerance: error in m that counts as reached, > 0. All samples but those
                beside a singularity come ten times closer.
            orientation_tolerance: error in rad that counts as reached, > 0; the same holds.
            scene: obstacles that the whole arm keeps clear of, between samples too, and then of
                itself as well, by the scene's margins and 0.2 mm more, so that the answer passes
                `check` with the same scene. The tip stays on its path, but for `deviation`: what
                the task leaves free, such as the elbow, goes around. Where the arm is clear anyway,
                the answer is the one without a scene. Only with "slow" and "exceed_limits".

        Raises:
            InvalidInput: if an argument is out of its range, or the motion isn't of poses or
                points in 3-D.
            IkFailure: if a sample is not reached. It carries the first such sample's index and a
                status: one of IkResult's; "jump" where the pose can be reached, but not from the
                sample before; "too_fast"; or "blocked" where there is no room for the arm, with
                the bodies that leave none.
            InvalidRobot: if there is a scene and the robot has no collision geometry, or a mesh
                is missing or flat.
            LimitsInfeasible: if a joint has to move whose limits are zero; with "slow" only.

        Source: Nakamura and Hanafusa 1986 for the damped step; Pham and Pham 2018 for the slowing.
        """
        tip = TipPath.of(motion)
        at_start = None if seed is None else self._joints(seed, "seed")
        shown = recorded.shown_joints(self._chain, motion)
        ends = (None, None) if shown is None else tuple(shown.positions[[0, -1]])
        reachable.require_reachable(
            self,
            tip,
            free=free,
            tolerances=(position_tolerance, orientation_tolerance),
            near=(ends[0] if at_start is None else at_start, ends[1]),
        )
        return follower.follow(
            self._chain,
            motion,
            limits=self.limits,
            seed=at_start,
            too_fast=too_fast,
            deviation=deviation,
            max_step=max_step,
            posture=posture,
            midrange=midrange,
            free=free,
            position_tolerance=position_tolerance,
            orientation_tolerance=orientation_tolerance,
            around=self._collision_test(scene, too_fast),
        )

    def _collision_test(self, scene: SceneLike | None, too_fast: TooFast) -> CollisionTest | None:
        """The test of the planning margins; None without a scene."""
        if scene is None:
            return None
        if too_fast in ("deviate", "raise"):
            raise InvalidInput(
                f"scene: not used together with too_fast={too_fast!r}; use 'slow' or "
                "'exceed_limits'"
            )
        return CollisionTest(self._collision, as_scene(scene).for_planning())

    def path_report(
        self,
        trajectory: JointTrajectory,
        motion: Trajectory | PoseTrajectory,
        *,
        position_tolerance: float = 1e-4,
        orientation_tolerance: float = 1e-3,
    ) -> PathReport:
        """How each sample of joints keeps to the motion's sample and to the arm's limits.

        A violation is reported, never raised. The times of the two may differ.

        Args:
            trajectory: the joints, one sample for each of the motion's.
            motion: the poses, or points in 3-D, that the tip was to follow.
            position_tolerance: the largest error in m for the verdict `ok`, > 0.
            orientation_tolerance: the largest error in rad for the verdict `ok`, > 0.

        Raises:
            InvalidInput: if an argument has another type or number of samples, or a tolerance is
                not positive.
        """
        return path_report(
            self._chain,
            self.limits,
            trajectory,
            motion,
            position_tolerance=position_tolerance,
            orientation_tolerance=orientation_tolerance,
        )

    def joints_of(self, trajectory: Motion) -> JointTrajectory:
        """The arm's own joints of a recording, found by name and in the arm's order.

        Args:
            trajectory: a JointTrajectory. It may have other joints as well, such as a gripper's.
                Names may end in ".pos", as LeRobot's do. Without names it has just the arm's
                joints, in the arm's order. Where a joint
                without limits leaps by more than half a turn between two samples, as encoders do
                at a whole turn, it is made continuous.

        Raises:
            InvalidInput: for another kind of motion, or if one of the arm's joints is missing.
        """
        return recorded.joints_of(self._chain, trajectory)

    def poses(self, trajectory: Motion) -> PoseTrajectory:
        """The poses that the tip goes through, with the recording's times, events and joints.

        `follow` is the way back, in the posture of the joints.

        Args:
            trajectory: the joints, as `joints_of` takes them.

        Raises:
            InvalidInput: for another kind of motion, if one of the arm's joints is missing, or if
                one goes so far beyond its limits that it cannot be in rad.
        """
        return recorded.poses(self._chain, trajectory)

"""A robot arm and the queries of its model, from poses of the tip to collision-free motions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from os import PathLike
from types import FunctionType, MappingProxyType
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check
from leadthrough.arm import following, inverse_kinematics as ik, recorded_joints, robot_files
from leadthrough.arm.collision import CollisionQueries
from leadthrough.arm.following import FollowOptions, OnRateLimit
from leadthrough.arm.inverse_kinematics import IkBatch, IkOptions, IkResult, IkSolutions
from leadthrough.arm.limits import JointLimits, checked_values
from leadthrough.arm.model import ArmModel
from leadthrough.arm.path_report import PathReport, path_report
from leadthrough.check import InvalidInput, InvalidRobot
from leadthrough.motion import JointTrajectory, Motion, PoseTrajectory, Trajectory
from leadthrough.shapes import SceneLike

if TYPE_CHECKING:
    from leadthrough.drawing.panels import Panel

_NONE_LOCKED: Mapping[str, float] = MappingProxyType({})


@dataclass(frozen=True, eq=False)
class Arm(ArmModel, CollisionQueries):
    """An arm in the frame of its base link; make one by `Arm.load` or `Arm.from_urdf`.

    Joint values are in rad (m for prismatic joints), in the order of `joint_names`. Poses are
    positions in m and orientations w, x, y, z of the tip in the base frame. An arm never changes:
    `lock_joints`, `with_tool`, `with_payload`, `with_attached` and `with_density` return new ones.

    A configuration `q` is (joints,) and may lie outside the limits; its velocities `qd`, rad/s, and
    accelerations `qdd`, rad/s^2, have its shape. Of a batch, (m, joints) each, the results have a
    first axis m. `threads`, 1 to 256, do not change an answer. A scene is a `Scene`, or a list of
    shapes, which has the default margins. Distances and checks raise InvalidRobot and
    MissingDependency as `collision_pairs` does.

    Attributes:
        document: the URDF as text.
        base: name of the link whose frame is the base frame.
        tip: name of the link whose frame is the tip's, unless a tool moves it.
        limits: of the joints.
        locked_joints: joints that are locked, by name, and their values.
        attachment: tool and loads on the tip link.
        mesh_folders: folders with the files of collision meshes.
        assumed: masses of links whose URDF states none, by `with_density`.
    """

    @staticmethod
    def load(
        name: str,
        *,
        base: str | None = None,
        tip: str | None = None,
        limits: JointLimits | str | PathLike[str] | None = None,
    ) -> Arm:
        """An arm by its name; those that come with the package have all limits and shapes.

        Args:
            name: "panda" (tip: the hand's tool centre point), "ur3" (tip: tool0) or "tiago" (tip:
                the last link of the wrist); or a robot of example-robot-data or
                robot_descriptions, where these are installed, such as "xarm7". The latter
                downloads a robot when it is first used.
            base: name of the first link, as for `from_urdf`.
            tip: name of the last link, as there; many robots of other packages need it.
            limits: as for `from_urdf`; by default those that come with the robot.

        Raises:
            InvalidInput: if there is no such robot, or a name does not fit it.
            InvalidRobot: if a robot of another package is not one that can be used.
        """
        files = robot_files.find_robot(name)
        return Arm.from_urdf(
            files.urdf,
            base=base,
            tip=tip,
            limits=files.limits if limits is None else limits,
            mesh_folders=files.mesh_folders,
        )

    @staticmethod
    def from_urdf(
        path_or_xml: str | PathLike[str],
        *,
        base: str | None = None,
        tip: str | None = None,
        limits: JointLimits | str | PathLike[str] | None = None,
        locked_joints: Mapping[str, float] = _NONE_LOCKED,
        mesh_folders: Sequence[str | PathLike[str]] = (),
    ) -> Arm:
        """The arm from one link of a URDF to another.

        Args:
            path_or_xml: path of the URDF, or the document itself. A file .xacro is expanded with
                the defaults of its arguments, by the package of the extra `xacro`.
            base: name of the link where the arm begins; by default the root.
            tip: name of the link where it ends; by default the only leaf.
            limits: all limits of the joints, or the path of a TOML file that completes the URDF's
                (see `read_limits`); by default the URDF's alone, which has no acceleration or jerk.
            locked_joints: joints to lock, by name, and their values in rad (m), inside the URDF's
                limits. They may lie outside the arm, such as fingers, or a joint that one of the
                arm's joints mimics.
            mesh_folders: folders besides the URDF's own with the files of collision meshes, read
                when they are first needed. A relative name is looked for in them;
                package://name/rest as name/rest in them and in the folders above them, then as
                rest in the robot's own. A mesh that lies elsewhere is not read.

        Raises:
            InvalidInput: if a file cannot be read, or a name or value does not fit the robot.
            InvalidRobot: if the document is not a URDF of an arm that can be used.
            MissingDependency: for a file .xacro, if xacro is not installed.
        """
        locked = checked_values(locked_joints)
        document = robot_files.read(path_or_xml)
        base, tip, complete = robot_files.ends_and_limits(document, (base, tip), locked, limits)
        folders = robot_files.folders(path_or_xml, mesh_folders)
        return Arm(document, base, tip, complete, locked, mesh_folders=folders)

    def with_density(self, density: float = 1000.0) -> Arm:
        """The arm with masses for links whose URDF states none: their shapes, filled.

        Of a link without collision shapes those drawn count. Masses stated stay as they are.

        Args:
            density: kg/m^3, > 0; the default is that of water, as MuJoCo assumes.

        Raises:
            InvalidRobot: if a mesh is not found, or no link that the arm moves has a shape.
        """
        from leadthrough.arm.link_geometry import filled

        each = check.number(density, "density", above=0.0)
        stated = replace(self, assumed={})
        arm = replace(self, assumed=filled(stated.robot, self.mesh_folders, each))
        if arm._chain.mass == 0.0:
            raise InvalidRobot("robot", "no link that the arm moves has a shape to be filled")
        return arm

    def describe(self) -> str:
        """Summary of the robot, its joints with their limits, and its load, as text."""
        from leadthrough.arm import description  # its tables take longer to load than the arm

        return description.describe(self)

    def _panels(self) -> list[Panel]:
        from leadthrough.arm import description

        return description.panels(self)

    def inverse_kinematics(
        self,
        position: ArrayLike,
        orientation: ArrayLike | None = None,
        *,
        q0: ArrayLike | None = None,
        seed: int = 0,
        options: IkOptions | None = None,
    ) -> IkResult:
        """A configuration inside the limits that brings the tip to a pose.

        A target that cannot be reached gives `success` False and the closest configuration.
        The same input gives the same answer. Self-motion is in the exact null space: it moves the
        tip by less than 1e-6 m.

        Args:
            position: (3,) in m, base frame.
            orientation: (4,) w, x, y, z; None leaves it free.
            q0: configuration (joints,) where the search starts, moved inside the limits; by default
                the options' `posture`, else the middle of the joints' ranges.
            seed: seed of the random number generator of the restarts.
            options: tolerances, free axes, preferred posture and budget.

        Raises:
            InvalidInput: if two arguments contradict each other.
        """
        chosen = ik.checked_options(options, self._chain, orientation)
        target = ik.one_pose(position, orientation)
        start = ik.one_start(self._chain, q0, chosen.posture)
        core_options = ik.compiled(chosen, ik.random_seed(seed))
        answer = core.solve_ik(self._chain, *target, start, core_options, self._closed_form)
        return ik.one_result(self.joint_names, answer)

    def inverse_kinematics_batch(
        self,
        positions: ArrayLike,
        orientations: ArrayLike | None = None,
        *,
        q0: ArrayLike | None = None,
        threads: int = 1,
        seed: int = 0,
        options: IkOptions | None = None,
    ) -> IkBatch:
        """Configurations for many poses at once, each as by `inverse_kinematics`.

        Args:
            positions: (m, 3) in m, base frame.
            orientations: (m, 4) w, x, y, z; None leaves them free.
            q0: configurations (m, joints) where the searches start, or (joints,) for all of them;
                by default the options' `posture`, else the middle of the joints' ranges.

        Returns:
            One row per pose.

        Raises:
            InvalidInput: if two arguments contradict each other.
        """
        chosen = ik.checked_options(options, self._chain, orientations)
        targets = ik.many_poses(positions, orientations)
        workers = check.integer(threads, "threads", at_least=1, at_most=256)
        starts = ik.many_starts(self._chain, q0, len(targets[0]), chosen.posture)
        core_options = ik.compiled(chosen, ik.random_seed(seed))
        columns = core.solve_ik_batch(
            self._chain,
            *targets,
            starts,
            core_options,
            workers,
            self._closed_form,
            own_restarts=False,
        )
        return ik.batch_of_results(columns)

    def inverse_kinematics_all(
        self,
        position: ArrayLike,
        orientation: ArrayLike | None = None,
        *,
        count: int = 16,
        separation: float | None = None,
        q0: ArrayLike | None = None,
        seed: int = 0,
        options: IkOptions | None = None,
    ) -> IkSolutions:
        """Distinct configurations that reach a pose, the one nearest to the posture first.

        Arms of six revolute joints have a closed form where axes 2 to 4 are parallel and 5 meets 6,
        or 4 to 6 meet, counted from the base or from the tip: for whole poses all configurations
        are returned, each with the whole turns nearest to the posture inside the limits. Arms
        within 0.01 rad and 0.01 m of such a structure have it too; next to a singularity of theirs
        the result is not `complete`. Of seven joints that are of such a structure without the last
        or the first, or have two groups of three axes that meet, the self-motion is swept.
        Otherwise a search uses its whole budget. Configurations of a redundant arm are moved in
        the null space as near to the options' `posture`, by default `q0`, as the task lets them.

        Args:
            count: number of configurations to return at most, 1 to 64.
            separation: two configurations are distinct if a joint differs by more than this, in
                rad (whole turns left out) or m, > 0; by default all of the closed form are, and
                0.1 tells those of a search apart.
            q0: configuration (joints,) where the search starts; by default the options' `posture`,
                else the middle of the joints' ranges.
            options: tolerances, free axes, posture and budget of the whole search; its `mode` does
                not count.

        Returns:
            One row per configuration, and whether these are all.
        """
        chosen = ik.checked_options(options, self._chain, orientation)
        apart = 0.0 if separation is None else check.number(separation, "separation", above=0.0)
        found = core.solve_ik_all(
            self._chain,
            *ik.one_pose(position, orientation),
            ik.one_start(self._chain, q0, chosen.posture),
            ik.compiled(chosen, ik.random_seed(seed), find_all=True),
            check.integer(count, "count", at_least=1, at_most=64),
            apart,
            self._closed_form,
        )
        return ik.solutions(found)

    def follow(
        self,
        motion: Trajectory | PoseTrajectory,
        *,
        q0: ArrayLike | None = None,
        on_rate_limit: OnRateLimit = "slow",
        deviation: tuple[ArrayLike, ArrayLike] | None = None,
        options: FollowOptions | None = None,
        scene: SceneLike | None = None,
    ) -> JointTrajectory:
        """Joint positions and velocities that take the tip along a motion without a jump.

        There is one sample for each of the motion's, with its events. Velocities are the time
        differences of the positions (second order). Accelerations are left to the time law.

        Args:
            motion: poses, or points in 3-D that leave the orientation free.
            q0: configuration (joints,) where the search for the first sample's posture starts.
                Without it, and without a posture to stay near to, several postures are followed
                ahead, and the best one is chosen.
            on_rate_limit: action where the arm's velocity and acceleration limits are too low for
                the motion's pace, as beside a singularity.
                "slow": stretch the times just there; the path is kept.
                "deviate": let the tip fall behind by at most `deviation` and catch up; the times
                are kept.
                "raise": raise IkFailure with the status "rate_limit".
                "exceed_limits": keep path and times and exceed the limits, for a time law such as
                `retime` to slow the motion down.
                Except with "exceed_limits" the arm starts and ends at rest, and acceleration
                limits that are not known don't count. Between samples the joints move straight.
            deviation: the most that the tip may be away from a sample, (m, rad); required with
                "deviate". With a scene the tip leaves its path by no more than that, but at its
                ends not at all, where the arm has no room otherwise. Then each of the two may be
                0, three numbers along and about the axes of the sample's frame, or matrices
                (n, 3, 3), in m^2 and the base frame and in rad^2 and the sample's, such as four
                times covariances for two standard deviations. It is an ellipsoid: of lengths and
                angles together, the squares of the fractions used add up to 1 at the most.
                `path_report` reports the tip's errors.
            options: preferred posture, free axes, tolerances and the largest step of a joint.
            scene: obstacles that the whole arm keeps clear of, between samples too, and then of
                itself as well, by the scene's margins and 0.2 mm more, so that the answer passes
                `check` with the same scene. The tip stays on its path, but for `deviation`: what
                the task leaves free, such as the elbow, goes around. If the arm is clear anyway,
                the answer is the one without a scene. Only with "slow" and "exceed_limits".

        Raises:
            InvalidInput: if the motion isn't of poses or points in 3-D.
            IkFailure: if a sample is not reached. It carries the first such sample's index and a
                status: one of IkResult's; "jump" where the pose can be reached, but not from the
                sample before; "rate_limit"; or "blocked" where there is no room for the arm, with
                the bodies that leave none.
            InvalidRobot: if there is a scene and the robot has no collision geometry, or a mesh
                is missing or flat.
            LimitsInfeasible: if a joint has to move whose limits are zero; with "slow" only.

        Source: Nakamura and Hanafusa 1986 for the damped step; Pham and Pham 2018 for the slowing.
        """
        test = None if scene is None else self._planning_test(scene)
        chosen = following.checked_options(options)
        return following.follow(
            self,
            motion,
            q0=following.reachable_start(self, motion, q0, chosen),
            on_rate_limit=on_rate_limit,
            deviation=deviation,
            options=chosen,
            around=test,
        )

    def path_report(
        self,
        trajectory: JointTrajectory,
        motion: Trajectory | PoseTrajectory,
        *,
        position_tolerance: float = 1e-4,
        orientation_tolerance: float = 1e-3,
    ) -> PathReport:
        """Deviation of each sample of joints from the motion, and its use of the arm's limits.

        A violation is reported, never raised. The times of the two may differ.

        Args:
            trajectory: the joints, one sample for each of the motion's.
            motion: the poses, or points in 3-D, that the tip was to follow.
            position_tolerance: the largest error in m for the verdict `ok`, > 0.
            orientation_tolerance: the largest error in rad for the verdict `ok`, > 0.
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
        """The arm's own joints of a recording, selected by name, in the arm's order.

        Args:
            trajectory: a JointTrajectory. It may have other joints as well, such as a gripper's.
                Names may end in ".pos", as LeRobot's do. Without names it has just the arm's
                joints, in the arm's order. A joint without limits that leaps by more than half a
                turn between two samples, as encoders do at a whole turn, is made continuous.

        Raises:
            InvalidInput: for another kind of motion, or if one of the arm's joints is missing.
        """
        return recorded_joints.joints_of(self._chain, trajectory)

    def poses(self, trajectory: Motion) -> PoseTrajectory:
        """Poses of the tip, with the recording's times, events and joints.

        `follow` is the way back, in the posture of the joints.

        Args:
            trajectory: the joints, as `joints_of` takes them.

        Raises:
            InvalidInput: for another kind of motion, if one of the arm's joints is missing, or if
                one goes so far beyond its limits that it cannot be in rad.
        """
        return recorded_joints.poses(self._chain, trajectory)


# Python's own errors about arguments name the class that users know.
for _method in (*vars(ArmModel).values(), *vars(CollisionQueries).values()):
    if isinstance(_method, FunctionType):
        _method.__qualname__ = f"Arm.{_method.__name__}"


def check_arm(arm: object) -> None:
    """Raises InvalidInput unless `arm` is an Arm."""
    if not isinstance(arm, Arm):
        raise InvalidInput(f"arm: expected an Arm, got {arm!r}; in Python, lt.Arm.load loads one")

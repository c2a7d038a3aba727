"""A robot arm: the chain of joints from a base link to a tip link of a URDF."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np

from leadthrough import _core, check
from leadthrough.arm import (
    collision,
    description,
    dynamics,
    following,
    holding,
    kinematics,
    loading,
    meshes,
    recorded,
    robots,
    single_pose,
)
from leadthrough.arm.attachment import Attachment, Load
from leadthrough.arm.collision import CollisionPairs, CollisionReport
from leadthrough.arm.limits import JointLimits
from leadthrough.arm.path_report import PathReport, path_report
from leadthrough.arm.results import IkBatch, IkResult
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.motion import JointTrajectory, PoseTrajectory, Trajectory
from leadthrough.shapes import Shape

_NOTHING_HELD: Mapping[str, float] = MappingProxyType({})
_NO_INERTIA = ((0.0, 0.0, 0.0),) * 3


@dataclass(frozen=True, eq=False)
class Arm:
    """An arm in the frame of its base link; make one by `Arm.load` or `Arm.from_urdf`.

    Joint values are rad (m for prismatic joints), in the order of `joint_names`. Poses are
    positions in m and orientations w, x, y, z of the tip in the base frame.
    """

    document: str = field(repr=False)
    base: str
    tip: str
    limits: JointLimits = field(repr=False)
    held: Mapping[str, float] = field(default_factory=dict, repr=False)
    attachment: Attachment = field(default_factory=Attachment, repr=False)
    mesh_folders: tuple[str, ...] = field(default=(), repr=False)
    _robot: _core.Robot = field(init=False, repr=False)
    _chain: _core.Chain = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "held", holding.checked(self.held))
        robot = _core.Robot(self.document).hold(list(self.held.items()))
        chain = _core.Chain(robot, self.base, self.tip)
        if list(self.joint_names) != chain.joint_names:
            raise InvalidInput(
                f"limits: expected the joints {chain.joint_names}, got {list(self.joint_names)}"
            )
        bounded = chain.with_bounds(self.limits.lower, self.limits.upper)
        object.__setattr__(self, "_robot", robot)
        object.__setattr__(self, "_chain", self.attachment.applied_to(bounded))

    def __reduce__(self) -> tuple[Any, ...]:
        stated = (self.document, self.base, self.tip, self.limits)
        return Arm, (*stated, dict(self.held), self.attachment, self.mesh_folders)

    @staticmethod
    def load(name: str) -> Arm:
        """A robot that comes with the package: "panda", "ur3" or "tiago". Raises InvalidInput."""
        folder = robots.find_robot(name)
        return Arm.from_urdf(folder / f"{name}.urdf", limits=folder / "limits.toml")

    @staticmethod
    def from_urdf(
        path_or_xml: Any,
        *,
        base: str | None = None,
        tip: str | None = None,
        limits: Any = None,
        hold: Mapping[str, float] = _NOTHING_HELD,
        mesh_folders: Sequence[Any] = (),
    ) -> Arm:
        """The arm from link `base` (the root) to link `tip` (the only leaf) of a URDF.

        path_or_xml: a path, or the document itself. limits: JointLimits, or the path of a TOML
        file that completes the URDF's. hold: joints that are frozen, and the values inside the
        URDF's limits that they are frozen at; they may lie outside the arm, such as fingers or a
        joint that one of the arm's mimics. mesh_folders: where collision meshes are looked for
        when they are first needed, beside the URDF's own folder; see `meshes.find_mesh`.
        Raises InvalidInput, InvalidRobot.
        """
        held = holding.checked(hold)
        document = loading.read(path_or_xml)
        robot = _core.Robot(document)
        base = robot.links[0] if base is None else check.choice(base, "base", robot.links)
        tip = loading.only_leaf(robot) if tip is None else check.choice(tip, "tip", robot.links)
        stated = loading.stated_limits(_core.Chain(robot.hold(list(held.items())), base, tip))
        folders = meshes.folders(path_or_xml, mesh_folders)
        complete = loading.complete(limits, stated, robot)
        return Arm(document, base, tip, complete, held, mesh_folders=folders)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints to command, from the base to the tip: none that is held or mimics another."""
        return self.limits.joint_names

    @property
    def tool(self) -> tuple[Float64Array, Float64Array]:
        """Position (3,) and orientation (4,) of the tip in the frame of the link `tip`."""
        return self.attachment.position, self.attachment.orientation

    @property
    def attached(self) -> tuple[Shape, ...]:
        """The shapes of the objects that the arm holds, in the frame of the link `tip`."""
        return self.attachment.shapes

    def hold(self, values: Mapping[str, float]) -> Arm:
        """The arm whose joints named here are frozen, at values inside its limits.

        Other joints of the robot may be frozen as well: what they carry then counts as a load.
        Raises InvalidInput.
        """
        wanted = holding.checked(values)
        holding.require_free(wanted, self.held)
        holding.require_inside(wanted, self.limits)
        return replace(self, limits=self.limits.without(wanted), held={**self.held, **wanted})

    def with_tool(self, position: Any, orientation: Any = (1.0, 0.0, 0.0, 0.0)) -> Arm:
        """The arm whose tip is at a pose given in the frame of its present tip; tools compose.

        position: (3,) m. orientation: (4,) w, x, y, z. Raises InvalidInput.
        """
        return replace(self, attachment=self.attachment.with_tool(position, orientation))

    def with_payload(
        self, mass: float, center: Any = (0.0, 0.0, 0.0), inertia: Any = _NO_INERTIA
    ) -> Arm:
        """The arm that carries a rigid body, given in the frame of its present tip; loads add up.

        mass: kg. center: (3,) m. inertia: (3, 3) kg m^2 about the centre. Raises InvalidInput.
        """
        load = Load(mass, center, inertia)
        return replace(self, attachment=self.attachment.with_load(load))

    def with_attached(self, shape: Shape, mass: float = 0.0) -> Arm:
        """The arm that holds an object, whose pose is given in the frame of its present tip.

        shape: Box, Sphere or Capsule; it joins `attached`. mass: kg, of uniform density; it adds
        to the load. Raises InvalidInput.
        """
        return replace(self, attachment=self.attachment.with_shape(shape, mass))

    def describe(self) -> str:
        """The robot, its joints with their limits, and what it carries, as text for people."""
        return description.describe(self)

    def forward_kinematics(self, q: Any) -> tuple[Float64Array, Float64Array]:
        """Position and orientation of the tip.

        q: (joints,), giving (3,) and (4,), or (m, joints), giving (m, 3) and (m, 4); outside the
        limits as well. Raises InvalidInput.
        """
        return kinematics.forward_kinematics(self._chain, q)

    def jacobian(self, q: Any) -> Float64Array:
        """Geometric Jacobian (6, joints) at the tip: linear rows first, base frame.

        q: (joints,), or (m, joints), giving (m, 6, joints). Raises InvalidInput.
        """
        return kinematics.jacobian(self._chain, q)

    def jacobian_derivative(self, q: Any, qd: Any) -> Float64Array:
        """The Jacobian's derivative in time (6, joints) while the joints move at qd, rad/s (m/s).

        The tip's acceleration is J qdd + J' qd. q, qd: (joints,), or (m, joints), giving
        (m, 6, joints). Raises InvalidInput.
        """
        return kinematics.jacobian_derivative(self._chain, q, qd)

    def jacobian_second_derivative(self, q: Any, qd: Any, qdd: Any) -> Float64Array:
        """The Jacobian's second derivative in time (6, joints), qdd in rad/s^2 (m/s^2).

        The tip's jerk is J qddd + 2 J' qdd + J'' qd. q, qd, qdd: (joints,), or (m, joints), giving
        (m, 6, joints). Raises InvalidInput.
        """
        return kinematics.jacobian_second_derivative(self._chain, q, qd, qdd)

    def manipulability(self, q: Any) -> Float64Array:
        """Yoshikawa's measure: sqrt(det(J J^T)), the product of J's singular values.

        0 at a singularity; its unit, products of m and rad, allows no comparison between arms. An
        arm of fewer than six joints is measured in the directions that it has, sqrt(det(J^T J)).
        q: (joints,), or (m, joints), giving (m,). Raises InvalidInput. Source: Yoshikawa 1985.
        """
        return kinematics.manipulability(self._chain, q)

    def condition_number(self, q: Any, *, rotation_weight: float = 0.3) -> Float64Array:
        """The Jacobian's largest singular value over its smallest; infinite at a singularity.

        rotation_weight: m a rad. The Jacobian's rows are m and rad, and the number would change
        with the unit of length; so a rotation counts as the path of a point this far from the tip.
        0.3 is about the reach of an arm's wrist, 1.0 gives the plain SI number.
        q: (joints,), or (m, joints), giving (m,). Raises InvalidInput.
        """
        return kinematics.condition_number(self._chain, q, rotation_weight=rotation_weight)

    def inverse_dynamics(
        self, q: Any, qd: Any, qdd: Any, *, gravity: Any = dynamics.GRAVITY
    ) -> Float64Array:
        """Torques, N m (N), that move the joints at qd with the accelerations qdd.

        Counted are the links that the arm moves, those on branches where they are fixed to it, and
        its loads; not friction, motors, or what hangs from joints outside the arm unless these are
        held. q, qd, qdd: (joints,), or (m, joints), giving (m, joints). gravity: (3,) m/s^2 in the
        base frame. Raises InvalidInput; InvalidRobot where the URDF has no masses.
        """
        return dynamics.inverse_dynamics(self._chain, q, qd, qdd, gravity=gravity)

    def gravity_torques(self, q: Any, *, gravity: Any = dynamics.GRAVITY) -> Float64Array:
        """Torques, N m (N), that hold the arm still, as by `inverse_dynamics`."""
        return dynamics.gravity_torques(self._chain, q, gravity=gravity)

    def mass_matrix(self, q: Any) -> Float64Array:
        """The matrix (joints, joints) that turns accelerations into torques, as counted there.

        q: (joints,), or (m, joints), giving (m, joints, joints). Raises InvalidInput, InvalidRobot.
        """
        return dynamics.mass_matrix(self._chain, q)

    def inverse_kinematics(
        self, position: Any, orientation: Any = None, *, seed: Any = None, **options: Any
    ) -> IkResult:
        """A configuration inside the limits that brings the tip to a pose.

        position: (3,) m. orientation: (4,) w, x, y, z; None leaves it free. seed: (joints,), moved
        inside the limits, the start of the search; the middle of the ranges where there is none.
        options: those of `ik_options`, or method="yang" and those of `yang.solve`, the plain
        method of a paper. A target that cannot be reached gives success False and the closest
        configuration found. The same input gives the same answer. Raises InvalidInput.
        """
        start = None if seed is None else self._joints(seed, "seed")
        return single_pose.solve(self._chain, position, orientation, seed=start, **options)

    def inverse_kinematics_all(
        self, position: Any, orientation: Any = None, *, seed: Any = None, **options: Any
    ) -> IkBatch:
        """Up to `count` (8) distinct configurations that reach a pose, the nearest one first.

        reference: (joints,), to which near is meant; the seed where there is none. Two are distinct
        where a joint differs by more than `separation` (0.1 rad, whole turns left out, or m); those
        of a redundant arm are first moved in the null space as near to the reference as the task
        lets them. The other options are those of `ik_options`; the search goes on until
        max_iterations (20,000) or max_restarts (1000). No row where no solution was found.
        Raises InvalidInput.
        """
        start = None if seed is None else self._joints(seed, "seed")
        return single_pose.solve_all(self._chain, position, orientation, seed=start, **options)

    def inverse_kinematics_batch(
        self,
        positions: Any,
        orientations: Any = None,
        *,
        seeds: Any = None,
        threads: int = 1,
        **options: Any,
    ) -> IkBatch:
        """Configurations for many poses at once, each as by `inverse_kinematics`.

        positions: (m, 3). orientations: (m, 4) or None. seeds: (m, joints), or (joints,) for all.
        threads: do not change the answer. Raises InvalidInput.
        """
        return single_pose.solve_batch(
            self._chain, positions, orientations, seeds=seeds, threads=threads, **options
        )

    def follow(
        self, motion: Trajectory | PoseTrajectory, *, seed: Any = None, **options: Any
    ) -> JointTrajectory:
        """Joint positions and velocities that take the tip along a motion without a jump.

        seed: (joints,), where the search for the first posture starts. options: those of
        `following.follow`; `too_fast` says what gives where the arm's limits of velocity and
        acceleration cannot keep the motion's pace: those limits ("keep", to be slowed down later),
        the times ("slow") or the path ("deviate"), or nothing ("raise").
        Raises InvalidInput, IkFailure, LimitsInfeasible.
        """
        start = None if seed is None else self._joints(seed, "seed")
        return following.follow(self._chain, motion, limits=self.limits, seed=start, **options)

    def joints_of(self, trajectory: JointTrajectory) -> JointTrajectory:
        """The arm's own joints of a recording, by their names, in the arm's order.

        A recording may have others as well, such as a gripper's; one without names has just the
        arm's, in its order. Raises InvalidInput.
        """
        return recorded.joints_of(trajectory, self.joint_names)

    def poses(self, trajectory: JointTrajectory) -> PoseTrajectory:
        """The poses that the tip goes through, with the recording's times and events.

        Of joints as `joints_of` takes them; `follow` is the way back. Raises InvalidInput.
        """
        return recorded.poses(self._chain, trajectory)

    def path_report(
        self,
        trajectory: JointTrajectory,
        motion: Trajectory | PoseTrajectory,
        **tolerances: float,
    ) -> PathReport:
        """How each sample of `trajectory` keeps to the motion's sample and to the arm's limits.

        tolerances: position_tolerance 1e-4 m and orientation_tolerance 1e-3 rad, for the verdict.
        Times may differ; a violation does not raise. Raises InvalidInput.
        """
        return path_report(self._chain, self.limits, trajectory, motion, **tolerances)

    def distance(
        self, q: Any, obstacles: Iterable[Shape], *, threads: int = 1
    ) -> float | Float64Array:
        """Smallest distance between what moves of the arm and obstacles, m.

        q: (joints,), giving a number, or (m, joints), giving (m,). obstacles: in the base frame.
        Below zero it is the depth of what overlaps; without obstacles it is infinite.
        Raises InvalidInput, InvalidRobot, MissingDependency.
        """
        scene = collision.against(self._collision, obstacles)
        rows, is_batch = self._batch(q, "q")
        found = collision.distances(scene, rows, threads=threads)
        return found if is_batch else float(found[0])

    def self_distance(self, q: Any, *, threads: int = 1) -> float | Float64Array:
        """Smallest distance between parts of the arm, or of the robot, m, as by `distance`.

        Which parts are compared: see `collision_pairs`.
        Raises InvalidInput, InvalidRobot, MissingDependency.
        """
        rows, is_batch = self._batch(q, "q")
        found = collision.distances(_core.itself(self._collision), rows, threads=threads)
        return found if is_batch else float(found[0])

    def check(
        self, trajectory: Any, obstacles: Iterable[Shape] = (), **options: Any
    ) -> CollisionReport:
        """Whether the whole arm keeps clear of obstacles and of itself, between samples as well.

        trajectory: a JointTrajectory, or (m, joints); between samples the joints move straight and
        in proportion. obstacles: in the base frame. options: margin and self_margin, m, the
        distances to keep from obstacles and between parts of the arm; tolerance, m, no hit deeper
        than that is missed between samples; threads, which do not change the answer. A hit is
        reported, never raised. Raises InvalidInput, InvalidRobot, MissingDependency.
        """
        q, times = collision.configurations(trajectory, self.joint_names)
        rows = check.array(q, "trajectory", shape=("m", len(self.joint_names)))
        return collision.check_motion(self._collision, rows, obstacles, times=times, **options)

    @property
    def collision_pairs(self) -> CollisionPairs:
        """Which bodies are checked against each other, and why others are not."""
        return collision.pairs(self._collision)

    @cached_property
    def _collision(self) -> _core.CollisionModel:
        return collision.collision_model(
            self._robot,
            self._chain,
            base=self.base,
            tip=self.tip,
            attached=self.attached,
            mesh_folders=self.mesh_folders,
        )

    def _batch(self, value: Any, name: str) -> tuple[Float64Array, bool]:
        joints = len(self.joint_names)
        rows = check.array_of_rank(value, name, shapes=[(joints,), ("m", joints)])
        return np.atleast_2d(rows), rows.ndim == 2

    def _joints(self, value: Any, name: str) -> Float64Array:
        return check.array(value, name, shape=(len(self.joint_names),))

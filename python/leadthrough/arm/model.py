"""The rigid-body model of an arm: a chain of joints of a URDF, its limits and its load."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, reduce
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check
from leadthrough.arm import kinematics
from leadthrough.arm.attachment import Attachment, Load
from leadthrough.arm.collision import collision_model
from leadthrough.arm.limits import JointLimits, checked_values, require_inside, require_unlocked
from leadthrough.check import Float64Array, InvalidRobot
from leadthrough.drawing import Drawn
from leadthrough.shapes import Shape, Solid

# m/s^2, down in a base frame whose z axis points up.
GRAVITY = (0.0, 0.0, -9.81)
_IDENTITY = (1.0, 0.0, 0.0, 0.0)
_NO_INERTIA = ((0.0, 0.0, 0.0),) * 3
_AT_REST = 1e-6  # rad/s (m/s): less is rounding, which dry friction would take for a direction

# Mass of a link, kg, its centre (3,), m, and inertia (3, 3) about it, kg m^2, in the link's frame.
Body = tuple[float, Float64Array, Float64Array]

_WRIST = 0.1  # m, around the axes of a wrist


@dataclass(frozen=True, eq=False)
class ArmModel(Drawn):
    """The chain of joints that an `Arm` is made of: its fields, kinematics and dynamics."""

    document: str = field(repr=False)
    base: str
    tip: str
    limits: JointLimits = field(repr=False)
    locked_joints: Mapping[str, float] = field(default_factory=dict, repr=False)
    attachment: Attachment = field(default_factory=Attachment, repr=False)
    mesh_folders: tuple[str, ...] = field(default=(), repr=False)
    assumed: Mapping[str, Body] = field(default_factory=dict, repr=False)
    _robot: core.Robot = field(init=False, repr=False)
    _chain: core.Chain = field(init=False, repr=False)

    def _repr_parts(self) -> list[str]:
        names = self.joint_names
        parts = [f"{self._robot.name!r}, {self.base} to {self.tip}"]
        parts.append(f"{len(names)} joints {names[0]} ... {names[-1]}")
        parts += [f"{', '.join(self.locked_joints)} locked"] if self.locked_joints else []
        lacking = [name for name in ("acceleration", "jerk") if getattr(self.limits, name) is None]
        parts += [f"without {' and '.join(lacking)} limits"] if lacking else []
        return [*parts, *self.attachment.summary()]

    def __post_init__(self) -> None:
        object.__setattr__(self, "locked_joints", checked_values(self.locked_joints))
        stated = core.Robot(self.document).hold(list(self.locked_joints.items()))
        robot = stated.with_inertias(dict(self.assumed))
        chain = core.Chain(robot, self.base, self.tip)
        if list(self.joint_names) != chain.joint_names:
            raise check.refused("limits", f"the joints {chain.joint_names}", list(self.joint_names))
        bounded = chain.with_bounds(self.limits.lower, self.limits.upper)
        object.__setattr__(self, "_robot", robot)
        object.__setattr__(self, "_chain", self.attachment.applied_to(bounded))

    def __reduce__(self) -> tuple[Any, ...]:
        stated = (self.document, self.base, self.tip, self.limits)
        load = self.attachment, self.mesh_folders, dict(self.assumed)
        return type(self), (*stated, dict(self.locked_joints), *load)

    @cached_property
    def _dynamics(self) -> core.Dynamics:
        return core.Dynamics(self._chain)

    @cached_property
    def _resistance(self) -> Float64Array:
        """Damping, N m s/rad (N s/m), and dry friction, N m (N), of the URDF: rows (2, joints)."""
        joints = {each.name: (each.damping, each.friction) for each in self._robot.tree}
        return np.array([joints[name] for name in self.joint_names]).T

    @cached_property
    def _closed_form(self) -> core.ClosedForm | None:
        """The structure by which all configurations of a pose are enumerated."""
        return core.recognize(self._chain)

    @cached_property
    def _collision(self) -> core.CollisionModel:
        ends = self.base, self.tip
        return collision_model(self._robot, self._chain, ends, self.mesh_folders, self.attached)

    @property
    def levers(self) -> Float64Array:
        """The most, (joints,) m per rad, that a joint moves a point of the arm up to the tip.

        It is the length of all that follows the joint, and at least 0.1 for the links around the
        wrist; 1 for a prismatic joint.
        """
        joints = self._robot.path(self.base, self.tip)
        ranges = np.subtract(self._chain.upper, self._chain.lower)
        limits = dict(zip(self._chain.joint_names, ranges.tolist(), strict=True))
        length, found = float(np.linalg.norm(self.tool[0])), list[float]()
        for joint in reversed(joints):
            if joint.name in limits:
                found.append(1.0 if joint.kind == "prismatic" else max(length, _WRIST))
                length += limits[joint.name] if joint.kind == "prismatic" else 0.0
            length += float(np.linalg.norm(joint.position))
        return np.array(found[::-1])

    @property
    def robot(self) -> core.Robot:
        """The robot that the arm is part of, with the locked joints fixed.

        It has a `name`, its `links`, and its `tree`: every joint, parents first, with the indices
        of its `parent` and `child` link, `kind`, `position`, `rotation`, `axis` and bounds.
        """
        return self._robot

    @cached_property
    def gravity(self) -> Float64Array:
        """Acceleration (3,) of gravity, m/s^2 in the base frame, of a robot whose root is upright.

        If free joints lie between root and base, it is that of an upright base.
        """
        joints = self._robot.path(self._robot.links[self._robot.tree[0].parent], self.base)
        known = all(joint.kind == "fixed" for joint in joints)
        turns = (joint.rotation.T for joint in joints if known)
        return check.freeze(reduce(lambda down, turn: turn @ down, turns, np.array(GRAVITY)))

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints to command, from base to tip; without those locked or mimicking another."""
        return self.limits.joint_names

    @property
    def tool(self) -> tuple[Float64Array, Float64Array]:
        """Position (3,) in m and orientation (4,) w, x, y, z of the tip in the frame of `tip`."""
        return self.attachment.position, self.attachment.orientation

    @property
    def attached(self) -> tuple[Shape, ...]:
        """Shapes of the attached objects, in the frame of link `tip`."""
        return self.attachment.shapes

    def lock_joints(self, values: Mapping[str, float]) -> Self:
        """The arm with some joints locked, which leave `joint_names`.

        Other joints of the robot may be locked as well: the links behind them then count as a load.

        Args:
            values: in rad (m) by the joints' names, inside the limits.

        Raises:
            InvalidInput: if a value is outside the limits, a joint is locked already, or no joint
                of the arm would be left.
        """
        values = checked_values(values)
        require_unlocked(values, self.locked_joints)
        require_inside(values, self.limits)
        locked = {**self.locked_joints, **values}
        return replace(self, limits=self.limits.without(values), locked_joints=locked)

    def with_tool(self, position: ArrayLike, orientation: ArrayLike = _IDENTITY) -> Self:
        """The arm with its tip moved to a pose in the frame of its present tip; tools compose.

        Args:
            position: (3,) in m.
            orientation: (4,) w, x, y, z.
        """
        return replace(self, attachment=self.attachment.with_tool(position, orientation))

    def with_payload(
        self,
        mass: float,
        center: ArrayLike = (0.0, 0.0, 0.0),
        inertia: ArrayLike = _NO_INERTIA,
    ) -> Self:
        """The arm carrying a rigid body, given in the frame of its present tip; payloads add up.

        Args:
            mass: in kg, >= 0.
            center: centre of mass (3,) in m.
            inertia: tensor (3, 3) about the centre of mass in kg m^2.

        Raises:
            InvalidInput: if no body has such an inertia.
        """
        load = Load(mass, center, inertia)
        return replace(self, attachment=self.attachment.with_load(load))

    def with_attached(self, shape: Solid, mass: float = 0.0) -> Self:
        """The arm holding an object, whose pose is given in the frame of its present tip.

        Args:
            shape: any but a PointCloud; it joins `attached` and counts in
                collision checks. Of a mesh the hulls of its parts count, for its mass too.
            mass: in kg, >= 0, of uniform density; it adds to the payload.
        """
        return replace(self, attachment=self.attachment.with_shape(shape, mass))

    def forward_kinematics(self, q: ArrayLike) -> tuple[Float64Array, Float64Array]:
        """Position (3,) in m and orientation (4,) w, x, y, z of the tip in the base frame."""
        pose = self._chain.pose(q)  # one configuration, without the cost of checks
        if pose is not None:
            return pose
        batch, (rows,) = self._rows(q=q)
        positions, orientations = self._chain.forward_kinematics(rows)
        return (positions, orientations) if batch else (positions[0], orientations[0])

    def jacobian(self, q: ArrayLike) -> Float64Array:
        """Geometric Jacobian J, (6, joints), of the tip: linear rows first, in the base frame."""
        return kinematics.jacobian(self._chain, q)

    def jacobian_derivative(self, q: ArrayLike, qd: ArrayLike) -> Float64Array:
        """Time derivative J', (6, joints), of the Jacobian while the joints move.

        The tip's acceleration is J qdd + J' qd.
        """
        return kinematics.matrices(core.jacobian_derivative, self._chain, q=q, qd=qd)

    def jacobian_second_derivative(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike
    ) -> Float64Array:
        """Second time derivative J'', (6, joints), of the Jacobian while the joints move.

        The tip's jerk is J qddd + 2 J' qdd + J'' qd.
        """
        kernel = core.jacobian_second_derivative
        return kinematics.matrices(kernel, self._chain, q=q, qd=qd, qdd=qdd)

    def manipulability(self, q: ArrayLike) -> Float64Array:
        """Yoshikawa's measure sqrt(det(J J^T)), the product of J's singular values.

        It is 0 at a singularity. Its unit is a product of m and rad, so it doesn't compare
        different arms. For an arm of fewer than six joints it is sqrt(det(J^T J)), which measures
        the directions in which the arm can move.

        Source: Yoshikawa 1985.
        """
        return kinematics.manipulability(self.jacobian(q))

    def condition_number(
        self, q: ArrayLike, *, rotation_weight: float = kinematics.ROTATION_WEIGHT
    ) -> Float64Array:
        """Largest singular value of the Jacobian over its smallest; infinite at a singularity.

        Args:
            rotation_weight: weight of the rotation rows in m per rad, > 0. The Jacobian mixes m
                and rad, so without a weight the number would change with the unit of length. A
                rotation counts as the path of a point this far from the tip: 0.3 is about the
                reach of an arm's wrist, 1.0 gives the plain SI number.
        """
        weight = check.number(rotation_weight, "rotation_weight", above=0.0)
        return kinematics.condition_number(self.jacobian(q), weight)

    def inverse_dynamics(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, *, gravity: ArrayLike | None = None
    ) -> Float64Array:
        """Joint torques (joints,) in N m (forces in N for prismatic joints) that produce a motion.

        The model has the links that the arm moves, those on side branches fixed to them, and the
        payloads. It has no friction, no motor inertia and nothing that hangs from joints outside
        the arm, unless these are locked.

        Args:
            gravity: acceleration (3,) of gravity in the base frame, m/s^2; by default `gravity`.

        Raises:
            InvalidRobot: if the URDF states no masses.
        """
        self._require_masses()
        batch, rows = self._rows(q=q, qd=qd, qdd=qdd)
        pull = check.array(self.gravity if gravity is None else gravity, "gravity", shape=(3,))
        torques = kinematics.finite(
            self._dynamics.inverse_dynamics(rows[0], rows[1], rows[2], pull)
        )
        return torques if batch else torques[0]

    def motor_torques(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, *, gravity: ArrayLike | None = None
    ) -> Float64Array:
        """Joint torques as `inverse_dynamics`, and those that friction takes: all of the motors'.

        That is damping qd + friction sign(qd); below 1e-6 rad/s (m/s), at rest, dry friction is 0.
        """
        torques = self.inverse_dynamics(q, qd, qdd, gravity=gravity)
        damping, friction = self._resistance
        speed = np.asarray(qd, dtype=np.float64)
        way = np.sign(speed) * (np.abs(speed) > _AT_REST)
        return np.asarray(torques + damping * speed + friction * way)

    def gravity_torques(self, q: ArrayLike, *, gravity: ArrayLike | None = None) -> Float64Array:
        """Joint torques (joints,) in N m (N) that hold the arm still against gravity.

        They are of the links as in `inverse_dynamics`.

        Args:
            gravity: acceleration (3,) of gravity in the base frame, m/s^2; by default `gravity`.

        Raises:
            InvalidRobot: if the URDF states no masses.
        """
        batch, (rows,) = self._rows(q=q)
        still = np.zeros_like(rows)
        torques = self.inverse_dynamics(rows, still, still, gravity=gravity)
        return torques if batch else torques[0]

    def mass_matrix(self, q: ArrayLike) -> Float64Array:
        """Joint-space mass matrix M (joints, joints): accelerations qdd need the torques M qdd.

        It is of the links as in `inverse_dynamics`.

        Raises:
            InvalidRobot: if the URDF states no masses.
        """
        self._require_masses()
        batch, (rows,) = self._rows(q=q)
        joints = self._chain.joints
        matrices = kinematics.finite(self._dynamics.mass_matrix(rows))
        shaped = matrices.reshape(len(rows), joints, joints)
        return shaped if batch else shaped[0]

    def _rows(self, **values: ArrayLike) -> tuple[bool, list[Float64Array]]:
        return kinematics.joint_rows(self._chain, **values)

    def _require_masses(self) -> None:
        if self._chain.mass == 0.0:
            raise InvalidRobot(
                "robot",
                "no link that the arm moves has a mass: its URDF states no <inertial>; assume a "
                "density (--density); in Python, by arm.with_density",
            )

"""A robot arm: the chain of joints from a base link to a tip link of a URDF."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from os import PathLike
from types import MappingProxyType

from numpy.typing import ArrayLike

from leadthrough import _core, check
from leadthrough.arm import holding, loading, meshes, robots
from leadthrough.arm.attachment import Load
from leadthrough.arm.collision import ArmCollision
from leadthrough.arm.damped_inverse_kinematics import ArmDampedInverseKinematics
from leadthrough.arm.dynamics import ArmDynamics
from leadthrough.arm.following import ArmFollowing
from leadthrough.arm.inverse_kinematics import ArmInverseKinematics
from leadthrough.arm.kinematics import ArmKinematics
from leadthrough.arm.limits import JointLimits
from leadthrough.errors import InvalidInput
from leadthrough.shapes import Solid

_NOTHING_HELD: Mapping[str, float] = MappingProxyType({})
_UNTURNED = (1.0, 0.0, 0.0, 0.0)
_NO_INERTIA = ((0.0, 0.0, 0.0),) * 3


@dataclass(frozen=True, eq=False)
class Arm(
    ArmKinematics,
    ArmDynamics,
    ArmInverseKinematics,
    ArmDampedInverseKinematics,
    ArmFollowing,
    ArmCollision,
):
    """An arm in the frame of its base link; make one by `Arm.load` or `Arm.from_urdf`.

    Joint values are in rad (m for prismatic joints), in the order of `joint_names`. Poses are
    positions in m and orientations w, x, y, z of the tip in the base frame. An arm never changes:
    `hold`, `with_tool`, `with_payload` and `with_attached` return new ones.

    Attributes:
        document: the URDF as text.
        base: name of the link whose frame is the base frame.
        tip: name of the link whose frame is the tip's, unless a tool moves it.
        limits: of the joints.
        held: joints that are frozen, by name, and their values.
        attachment: what the tip link carries.
        mesh_folders: where the files of collision meshes are looked for.
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
        files = robots.find_robot(name)
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
        hold: Mapping[str, float] = _NOTHING_HELD,
        mesh_folders: Sequence[str | PathLike[str]] = (),
    ) -> Arm:
        """The arm from one link of a URDF to another.

        Args:
            path_or_xml: path of the URDF, or the document itself.
            base: name of the link where the arm begins; by default the root.
            tip: name of the link where it ends; by default the only leaf.
            limits: all limits of the joints, or the path of a TOML file that completes the URDF's
                (see `read_limits`); by default the URDF's alone, which has no acceleration or jerk.
            hold: joints to freeze, by name, and the values in rad (m) to freeze them at, inside
                the URDF's limits. They may lie outside the arm, such as fingers, or a joint that
                one of the arm's joints mimics.
            mesh_folders: where the files of collision meshes are looked for when they are first
                needed, besides the URDF's own folder. A relative name is looked for in them;
                package://name/rest as name/rest in them and in the folders above them, then as
                rest in the robot's own. A mesh that lies elsewhere is not read.

        Raises:
            InvalidInput: if a file cannot be read, or a name or value does not fit the robot.
            InvalidRobot: if the document is not a URDF of an arm that can be used.
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

    def hold(self, values: Mapping[str, float]) -> Arm:
        """The arm with some joints frozen, which leave `joint_names`.

        Other joints of the robot may be frozen as well: what they carry then counts as a load.

        Args:
            values: in rad (m) by the joints' names, inside the limits.

        Raises:
            InvalidInput: if a value is outside the limits, a joint is held already, or no joint of
                the arm would be left.
        """
        wanted = holding.checked(values)
        holding.require_free(wanted, self.held)
        holding.require_inside(wanted, self.limits)
        return replace(self, limits=self.limits.without(wanted), held={**self.held, **wanted})

    def with_tool(self, position: ArrayLike, orientation: ArrayLike = _UNTURNED) -> Arm:
        """The arm with its tip moved to a pose in the frame of its present tip; tools compose.

        Args:
            position: (3,) in m.
            orientation: (4,) w, x, y, z.

        Raises:
            InvalidInput: if one has another shape, or the orientation is no unit quaternion.
        """
        return replace(self, attachment=self.attachment.with_tool(position, orientation))

    def with_payload(
        self,
        mass: float,
        center: ArrayLike = (0.0, 0.0, 0.0),
        inertia: ArrayLike = _NO_INERTIA,
    ) -> Arm:
        """The arm carrying a rigid body, given in the frame of its present tip; payloads add up.

        Args:
            mass: in kg, >= 0.
            center: centre of mass (3,) in m.
            inertia: tensor (3, 3) about the centre of mass in kg m^2.

        Raises:
            InvalidInput: if one has another shape, or no body has such an inertia.
        """
        load = Load(mass, center, inertia)
        return replace(self, attachment=self.attachment.with_load(load))

    def with_attached(self, shape: Solid, mass: float = 0.0) -> Arm:
        """The arm holding an object, whose pose is given in the frame of its present tip.

        Args:
            shape: a Box, Sphere, Capsule, Cylinder or Mesh; it joins `attached` and counts in
                collision checks. Of a mesh the hulls of its parts count, for its mass too.
            mass: in kg, >= 0, of uniform density; it adds to the payload.

        Raises:
            InvalidInput: if the shape is something else, or the mass is negative.
        """
        return replace(self, attachment=self.attachment.with_shape(shape, mass))

    def describe(self) -> str:
        """The robot, its joints with their limits, and what it carries, as text to read."""
        from leadthrough.arm import description  # its tables take longer to load than the arm

        return description.describe(self)


def check_arm(arm: object) -> None:
    """Refuses what is no arm, such as the name of one."""
    if not isinstance(arm, Arm):
        raise InvalidInput(f"arm: expected an Arm, got {arm!r}; in Python, lt.Arm.load loads one")

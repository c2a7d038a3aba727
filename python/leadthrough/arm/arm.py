"""A robot arm: the chain of joints from a base link to a tip link of a URDF."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from leadthrough import _core, check
from leadthrough.arm import following, kinematics, robots, single_pose
from leadthrough.arm.limits import JointLimits, read_limits
from leadthrough.arm.results import IkBatch, IkResult
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.motion import JointTrajectory, PoseTrajectory, Trajectory

# Bytes: above the core's own bound, which refuses the document with a reason.
_LARGEST_FILE = 2**25


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
    _chain: _core.Chain = field(init=False, repr=False)

    def __post_init__(self) -> None:
        chain = _core.Chain(_core.Robot(self.document), self.base, self.tip)
        if list(self.joint_names) != chain.joint_names:
            raise InvalidInput(
                f"limits: expected the joints {chain.joint_names}, got {list(self.joint_names)}"
            )
        bounded = chain.with_bounds(self.limits.lower, self.limits.upper)
        object.__setattr__(self, "_chain", bounded)

    def __reduce__(self) -> tuple[Any, ...]:
        return Arm, (self.document, self.base, self.tip, self.limits)

    @staticmethod
    def load(name: str) -> Arm:
        """A robot that comes with the package: "panda", "ur3" or "tiago". Raises InvalidInput."""
        folder = robots.find_robot(name)
        return Arm.from_urdf(folder / f"{name}.urdf", limits=folder / "limits.toml")

    @staticmethod
    def from_urdf(
        path_or_xml: Any, *, base: str | None = None, tip: str | None = None, limits: Any = None
    ) -> Arm:
        """The arm from link `base` (the root) to link `tip` (the only leaf) of a URDF.

        path_or_xml: a path, or the document itself. limits: JointLimits, or the path of a TOML
        file that completes the URDF's. Raises InvalidInput, InvalidRobot.
        """
        document = _read(path_or_xml)
        robot = _core.Robot(document)
        base = robot.links[0] if base is None else check.choice(base, "base", robot.links)
        tip = _only_leaf(robot) if tip is None else check.choice(tip, "tip", robot.links)
        stated = _stated_limits(_core.Chain(robot, base, tip))
        return Arm(document, base, tip, _complete(limits, stated, robot))

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The moving joints, from the base to the tip."""
        return self.limits.joint_names

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

    def inverse_kinematics(
        self, position: Any, orientation: Any = None, *, seed: Any = None, **options: Any
    ) -> IkResult:
        """A configuration inside the limits that brings the tip to a pose.

        position: (3,) m. orientation: (4,) w, x, y, z; None leaves it free. seed: (joints,), moved
        inside the limits, the start of the search; the middle of the ranges where there is none.
        options: those of `ik_options`. A target that cannot be reached gives success False and the
        closest configuration found. The same input gives the same answer. Raises InvalidInput.
        """
        start = None if seed is None else self._joints(seed, "seed")
        return single_pose.solve(self._chain, position, orientation, seed=start, **options)

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

        See `following.follow` for the options. Raises InvalidInput, IkFailure.
        """
        start = None if seed is None else self._joints(seed, "seed")
        return following.follow(
            self._chain, motion, velocity=self.limits.velocity, seed=start, **options
        )

    def _joints(self, value: Any, name: str) -> Float64Array:
        return check.array(value, name, shape=(len(self.joint_names),))


def _read(path_or_xml: Any) -> str:
    is_document = isinstance(path_or_xml, str) and path_or_xml.lstrip("\ufeff \t\r\n")[:1] == "<"
    try:
        if is_document:
            return str(path_or_xml.encode("utf-8"), "utf-8")
        with Path(path_or_xml).open("rb") as file:
            return str(file.read(_LARGEST_FILE), "utf-8")
    except (OSError, ValueError, TypeError) as error:
        raise InvalidInput(f"path_or_xml: expected a URDF or its path: {error}") from None


def _only_leaf(robot: _core.Robot) -> str:
    if len(robot.leaves) > 1:
        raise InvalidInput(f"tip: the robot ends in several links; name one of {robot.leaves}")
    return robot.leaves[0]


def _stated_limits(chain: _core.Chain) -> JointLimits:
    return JointLimits(
        tuple(chain.joint_names), chain.lower, chain.upper, chain.velocity, effort=chain.effort
    )


def _complete(limits: Any, stated: JointLimits, robot: _core.Robot) -> JointLimits:
    if limits is None:
        return stated
    if isinstance(limits, JointLimits):
        return limits
    return read_limits(limits, stated, other_joints=robot.joints)

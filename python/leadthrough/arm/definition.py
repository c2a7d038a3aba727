"""What defines an arm: a chain of joints of a URDF, with its limits and what the tip carries."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import FunctionType
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from leadthrough import _core, check
from leadthrough.arm import holding, picture
from leadthrough.arm.attachment import Attachment
from leadthrough.arm.limits import JointLimits
from leadthrough.check import Float64Array
from leadthrough.drawing.drawn import Drawn
from leadthrough.errors import InvalidInput
from leadthrough.shapes import Shape

if TYPE_CHECKING:
    from leadthrough.drawing.panels import Panel

_ARM = "leadthrough.arm.arm"  # module of the class that users see


@dataclass(frozen=True, eq=False)
class ArmDefinition(Drawn):
    """The fields of an `Arm`, from which each group of its methods derives.

    The groups are one file each: kinematics, dynamics, inverse kinematics, following, collision.
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

    def __init_subclass__(cls) -> None:
        """Names each group's methods as users call them: errors of a call say `Arm.follow()`."""
        super().__init_subclass__()
        if cls.__module__.partition(".arm.")[0] != "leadthrough":
            return  # a class that derives from Arm
        for name, function in vars(cls).items():
            if isinstance(function, FunctionType) and not name.startswith("_"):
                function.__module__, function.__qualname__ = _ARM, f"Arm.{name}"

    def _repr_parts(self) -> list[str]:
        names = self.joint_names
        parts = [f"{self._robot.name!r}, {self.base} to {self.tip}"]
        parts.append(f"{len(names)} joints {names[0]} ... {names[-1]}")
        parts += [f"holds {', '.join(self.held)} still"] if self.held else []
        lacking = [name for name in ("acceleration", "jerk") if getattr(self.limits, name) is None]
        parts += [f"without {' and '.join(lacking)} limits"] if lacking else []
        return [*parts, *self.attachment.told()]

    def _panels(self) -> list[Panel]:
        return picture.panels(self)

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
        return type(self), (*stated, dict(self.held), self.attachment, self.mesh_folders)

    @property
    def robot(self) -> _core.Robot:
        """The robot that the arm is part of, with the held joints fixed.

        It has a `name`, its `links`, and its `tree`: every joint, parents first, with the indices
        of its `parent` and `child` link, `kind`, `position`, `rotation`, `axis` and bounds.
        """
        return self._robot

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints to command, from base to tip; without those held or mimicking another."""
        return self.limits.joint_names

    @property
    def tool(self) -> tuple[Float64Array, Float64Array]:
        """Position (3,) in m and orientation (4,) w, x, y, z of the tip in the frame of `tip`."""
        return self.attachment.position, self.attachment.orientation

    @property
    def attached(self) -> tuple[Shape, ...]:
        """The shapes of the objects that the arm holds, in the frame of link `tip`."""
        return self.attachment.shapes

    def _joints(self, value: ArrayLike, name: str) -> Float64Array:
        """One checked configuration (joints,)."""
        return check.array(value, name, shape=(len(self.joint_names),))

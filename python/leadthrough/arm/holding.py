"""Joints that are frozen at a value and leave the arm's joints."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from types import MappingProxyType

from leadthrough import check
from leadthrough.arm.limits import JointLimits
from leadthrough.errors import InvalidInput


def checked(values: Mapping[str, float]) -> Mapping[str, float]:
    """A read-only copy of values by the joints' names."""
    if not isinstance(values, Mapping):
        raise InvalidInput(f"hold: expected a mapping from joints' names to values, got {values!r}")
    for name in values:
        if not isinstance(name, str):
            raise InvalidInput(f"hold: expected a joint's name, got {name!r}")
    return MappingProxyType(
        {name: check.number(value, f"hold: {name}") for name, value in values.items()}
    )


def require_inside(values: Mapping[str, float], limits: JointLimits) -> None:
    """Check values against the limits of an arm."""
    bounds = zip(limits.joint_names, limits.lower, limits.upper, strict=True)
    for name, lower, upper in bounds:
        if name in values and not lower <= values[name] <= upper:
            raise InvalidInput(
                f"hold: {name}: expected a value inside its limits {lower:.6g} to {upper:.6g}, "
                f"got {values[name]:.6g}"
            )
    if set(limits.joint_names) <= set(values):
        raise InvalidInput("hold: expected at least one joint of the arm not to be held")


def require_free(values: Collection[str], held: Mapping[str, float]) -> None:
    """Check that none of the joints is held already."""
    for name in values:
        if name in held:
            raise InvalidInput(
                f"hold: {name}: expected a joint that is not held, but it is held at {held[name]}"
            )

"""Regions from which targets of queries are drawn at random."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check, rotations
from leadthrough.check import Float64Array, InvalidInput, ShortRepr
from leadthrough.motion import Target

__all__ = ["Target", "TargetRegion"]

_ROUNDING = 1e-9  # m or rad, by which a target may lie outside
_ROUNDED_ANGLE = 1e-6  # rad; the cosine of an angle near 0 has half of its digits


@dataclass(frozen=True, eq=False)
class TargetRegion(ShortRepr):
    """All positions between two corners, for poses with all orientations near one.

    Attributes:
        lower: (d,), smallest coordinates in m (rad).
        upper: (d,), largest coordinates, >= lower.
        turn: largest angle of a pose's orientation from the middle one, rad, in [0, pi].
        orientation: (4,) w, x, y, z, the middle one; None for the demonstrated one.
    """

    lower: Float64Array
    upper: Float64Array
    turn: float = 0.0
    orientation: Float64Array | None = None

    def __post_init__(self) -> None:
        lower = check.frozen(self.lower, "lower", shape=("d",))
        upper = check.frozen(self.upper, "upper", shape=lower.shape)
        if (upper < lower).any():
            raise InvalidInput(f"upper: expected at least lower {lower}, got {upper}")
        turn = check.number(self.turn, "turn", at_least=0.0, at_most=np.pi)
        object.__setattr__(self, "lower", lower)
        object.__setattr__(self, "upper", upper)
        object.__setattr__(self, "turn", turn)
        if self.orientation is not None:
            middle = check.quaternions(self.orientation, "orientation", shape=(4,))
            object.__setattr__(self, "orientation", check.freeze(middle))

    @staticmethod
    def around(position: ArrayLike, reach: ArrayLike, *, turn: float = 0.0) -> TargetRegion:
        """The region that extends from a position by the same distance to both sides.

        Args:
            position: (d,) its middle, m (rad).
            reach: (d,) or one number, its extent to each side along each axis, m (rad), >= 0.
            turn: as the attribute.
        """
        middle = check.array(position, "position", shape=("d",))
        given = np.broadcast_to(np.asarray(reach, dtype=np.float64), middle.shape)
        half = check.array(given, "reach", shape=middle.shape)
        if (half < 0.0).any():
            raise InvalidInput(f"reach: expected distances >= 0, got {half}")
        return TargetRegion(middle - half, middle + half, turn)

    @property
    def middle(self) -> Float64Array:
        """The position in its middle, (d,)."""
        return 0.5 * (self.lower + self.upper)

    def draw(self, rng: np.random.Generator) -> Target:
        """A target at random: uniform in the box, its rotation in a ball of rotation vectors.

        Args:
            rng: source of the random numbers.
        """
        position = rng.uniform(self.lower, self.upper)
        if self.orientation is None:
            return position
        axis = rng.normal(size=3)
        angle = self.turn * rng.uniform() ** (1.0 / 3.0)
        rotation = rotations.exp((angle * axis / np.linalg.norm(axis))[None])
        return position, rotations.compose(rotation, self.orientation[None])[0]

    def contains(self, target: Target) -> bool:
        """Whether a target, with its orientation if it has one, lies in the region.

        Args:
            target: as skills take it.
        """
        pair = target if isinstance(target, tuple) and len(target) == 2 else (target, None)
        point, quaternion = pair
        position = np.asarray(point, dtype=np.float64)
        inside = position.shape == self.lower.shape and bool(
            (position >= self.lower - _ROUNDING).all()
            and (position <= self.upper + _ROUNDING).all()
        )
        if not inside or quaternion is None or self.orientation is None:
            return inside
        given = np.asarray(quaternion, dtype=np.float64)[None]
        angle = rotations.distance(given, self.orientation[None])[0]
        return bool(angle <= self.turn + _ROUNDED_ANGLE)

    def shrunk(self, factor: float) -> TargetRegion:
        """The region about the same middle, each side times a factor; the turn stays.

        Args:
            factor: in [0, 1].
        """
        half = 0.5 * factor * (self.upper - self.lower)
        return TargetRegion(self.middle - half, self.middle + half, self.turn, self.orientation)

    def to_settings(self) -> dict[str, Any]:
        """Plain values, as JSON knows them."""
        middle = None if self.orientation is None else self.orientation.tolist()
        return {
            "lower": self.lower.tolist(),
            "upper": self.upper.tolist(),
            "turn": self.turn,
            "orientation": middle,
        }

    @staticmethod
    def from_settings(settings: Mapping[str, Any]) -> TargetRegion:
        """The region with these plain values.

        Args:
            settings: as `to_settings` made them.

        Raises:
            KeyError: if one is missing.
        """
        names = ("lower", "upper", "turn", "orientation")
        return TargetRegion(**{name: settings[name] for name in names})

    def __str__(self) -> str:
        sides = (
            f"{low:.4g} to {high:.4g}" for low, high in zip(self.lower, self.upper, strict=True)
        )
        rotated = f", rotated by up to {self.turn:.3g} rad" if self.turn else ""
        return f"{', '.join(sides)}{rotated}"

"""Boxes of places, from which queries are drawn at random."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check, rotations
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.repr import ShortRepr

_ROUNDING = 1e-9  # m or rad, by which a place may lie outside
_ROUNDED_ANGLE = 1e-6  # rad; the cosine of an angle near 0 has half of its digits


@dataclass(frozen=True, eq=False)
class Places(ShortRepr):
    """All places between two corners, for poses with all orientations near one.

    Attributes:
        lower: (d,), smallest coordinates in m (rad).
        upper: (d,), largest coordinates, >= lower.
        turn: rad, in [0, pi]: how far an orientation of a pose is from the middle one at most.
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
            object.__setattr__(self, "orientation", middle)

    @staticmethod
    def around(position: ArrayLike, reach: ArrayLike, *, turn: float = 0.0) -> Places:
        """The region that extends from a place by the same distance to both sides.

        Args:
            position: (d,) its middle, m (rad).
            reach: (d,) or one number, how far it extends along each axis, m (rad), >= 0.
            turn: as the attribute.

        Raises:
            InvalidInput: if an argument is malformed.
        """
        middle = check.array(position, "position", shape=("d",))
        given = np.broadcast_to(np.asarray(reach, dtype=np.float64), middle.shape)
        half = check.array(given, "reach", shape=middle.shape)
        if (half < 0.0).any():
            raise InvalidInput(f"reach: expected distances >= 0, got {half}")
        return Places(middle - half, middle + half, turn)

    @property
    def middle(self) -> Float64Array:
        """The position in its middle, (d,)."""
        return 0.5 * (self.lower + self.upper)

    def draw(self, rng: np.random.Generator) -> Place:
        """A place at random: evenly in the box, the turn evenly in the ball of rotation vectors.

        Args:
            rng: source of the random numbers.
        """
        position = rng.uniform(self.lower, self.upper)
        if self.orientation is None:
            return position
        axis = rng.normal(size=3)
        angle = self.turn * rng.uniform() ** (1.0 / 3.0)
        turned = rotations.exp((angle * axis / np.linalg.norm(axis))[None])[0]
        return position, rotations.compose(turned[None], self.orientation[None])[0]

    def contains(self, place: Place) -> bool:
        """Whether a place, with its orientation if it has one, lies in the region.

        Args:
            place: as skills take it.
        """
        where, quaternion = place if isinstance(place, tuple) and len(place) == 2 else (place, None)
        position = np.asarray(where, dtype=np.float64)
        inside = position.shape == self.lower.shape and bool(
            (position >= self.lower - _ROUNDING).all()
            and (position <= self.upper + _ROUNDING).all()
        )
        if not inside or quaternion is None or self.orientation is None:
            return inside
        given = np.asarray(quaternion, dtype=np.float64)[None]
        angle = rotations.distance(given, self.orientation[None])[0]
        return bool(angle <= self.turn + _ROUNDED_ANGLE)

    def shrunk(self, factor: float) -> Places:
        """The region about the same middle, each side times a factor; the turn stays.

        Args:
            factor: in [0, 1].
        """
        half = 0.5 * factor * (self.upper - self.lower)
        return Places(self.middle - half, self.middle + half, self.turn, self.orientation)

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
    def from_settings(settings: Mapping[str, Any]) -> Places:
        """The region with these plain values.

        Args:
            settings: as `to_settings` made them.

        Raises:
            KeyError: if one is missing.
            InvalidInput: if one is wrong.
        """
        names = ("lower", "upper", "turn", "orientation")
        return Places(**{name: settings[name] for name in names})

    def __str__(self) -> str:
        sides = (
            f"{low:.4g} to {high:.4g}" for low, high in zip(self.lower, self.upper, strict=True)
        )
        turned = f", turned by up to {self.turn:.3g} rad" if self.turn else ""
        return f"{', '.join(sides)}{turned}"


# A point or joints (d,); of poses a position (3,), or (position (3,), orientation (4,) w, x, y, z).
Place: TypeAlias = ArrayLike | tuple[ArrayLike, ArrayLike]

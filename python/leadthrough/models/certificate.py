"""The result of a skill's validation, saved in its file: regions, runs and successes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check, rotations
from leadthrough.check import Float64Array, InvalidInput, ShortRepr
from leadthrough.motion import Target
from leadthrough.shapes import MovingObstacle, Obstacle, RandomObstacle, Scene, Shape

__all__ = ["Certificate", "ConfidenceInterval", "Target", "TargetRegion"]

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
        half = check.row(reach, "reach", width=len(middle))
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


@dataclass(frozen=True)
class ValidatedObstacle:
    """An obstacle of a validation: its form and its possible positions."""

    form: str  # a text that only shapes of this kind, size and orientation have
    lower: tuple[float, ...]  # (3,) smallest coordinates of its position, m
    upper: tuple[float, ...]  # (3,) largest ones

    @staticmethod
    def of(obstacle: Obstacle) -> ValidatedObstacle:
        """An obstacle at its present position, or at those that may be drawn."""
        if isinstance(obstacle, RandomObstacle):
            corners = obstacle.lower.tolist(), obstacle.upper.tolist()
            return ValidatedObstacle(obstacle.shape.form(), *map(tuple, corners))
        shape = obstacle.shape if isinstance(obstacle, MovingObstacle) else obstacle
        here = tuple(shape.position.tolist())
        return ValidatedObstacle(shape.form(), here, here)

    def covers(self, shape: Shape) -> bool:
        """Whether a shape is this obstacle at one of its positions."""
        here = shape.position
        inside = (here >= np.subtract(self.lower, 1e-9)) & (here <= np.add(self.upper, 1e-9))
        return bool(inside.all()) and shape.form() == self.form


@dataclass(frozen=True, eq=False)
class ValidatedScene(ShortRepr):
    """An arm and its scene, as the certificate knows them.

    Attributes:
        robot: the arm: its name, base and tip.
        obstacles: of every query, with their kind, size and place.
        margin: distance that the arm kept from obstacles, m.
    """

    robot: str
    obstacles: tuple[ValidatedObstacle, ...]
    margin: float

    @staticmethod
    def of(scene: Scene, robot: str) -> ValidatedScene:
        """A scene around an arm of this name."""
        return ValidatedScene(
            robot, tuple(map(ValidatedObstacle.of, scene.obstacles)), scene.margin
        )


@dataclass(frozen=True, eq=False)
class ConfidenceInterval(ShortRepr):
    """Bounds of a fraction.

    Attributes:
        lower: of the fraction.
        upper: of the fraction.
        confidence: probability with which the bounds hold at least.
        method: by which they were computed.
    """

    lower: float
    upper: float
    confidence: float
    method: str


@dataclass(frozen=True, eq=False)
class Certificate(ShortRepr):
    """Success rate of a skill's motions, for queries drawn at random from stated regions.

    Attributes:
        goals: region of the queries' goals.
        starts: region of their starts.
        scene: the arm, its obstacles and the margin.
        runs: number of queries.
        causes: number of failures by their cause.
        interval: bounds of the fraction that succeeds.
        required: fraction that `holds` promises.
        holds: the largest part of `goals` in which at least the required fraction succeeds, with
            the same confidence; None if there is none.
        seed: of the random number generator.
    """

    goals: TargetRegion
    starts: TargetRegion
    scene: ValidatedScene
    runs: int
    causes: Mapping[str, int]
    interval: ConfidenceInterval
    required: float
    holds: TargetRegion | None
    seed: int

    @property
    def successes(self) -> int:
        """Number of queries whose motion the arm can run."""
        return self.runs - sum(self.causes.values())

    @property
    def fraction(self) -> float:
        """The fraction of the queries that succeeded."""
        return self.successes / self.runs

    def outside(
        self, *, start: Target, goal: Target, obstacles: Sequence[Shape] = (), robot: str = ""
    ) -> tuple[str, ...]:
        """Reasons why the certificate does not cover a query; empty if it does.

        Args:
            start: start of the motion.
            goal: its end.
            obstacles: of the query.
            robot: the arm, as `scene.robot` names it; empty if none is known.
        """
        reasons = [
            f"{name} outside {region}"
            for name, region, target in (("start", self.starts, start), ("goal", self.goals, goal))
            if not region.contains(target)
        ]
        if not _matched(list(obstacles), list(self.scene.obstacles)):
            reasons.append("other obstacles")
        if robot and robot != self.scene.robot:
            reasons.append(f"another arm than {self.scene.robot}")
        return tuple(reasons)

    def to_settings(self) -> dict[str, Any]:
        """Plain values, as JSON knows them."""
        return {
            "goals": self.goals.to_settings(),
            "starts": self.starts.to_settings(),
            "obstacles": [asdict(each) for each in self.scene.obstacles],
            "robot": self.scene.robot,
            "margin": self.scene.margin,
            "runs": self.runs,
            "successes": self.successes,
            "causes": dict(self.causes),
            "interval": [self.interval.lower, self.interval.upper],
            "confidence": self.interval.confidence,
            "method": self.interval.method,
            "required": self.required,
            "holds": None if self.holds is None else self.holds.to_settings(),
            "seed": self.seed,
        }

    @staticmethod
    def from_settings(settings: Mapping[str, Any]) -> Certificate:
        """The certificate with these plain values.

        Args:
            settings: as `to_settings` made them.
        """
        try:
            holds = settings["holds"]
            low, high = settings["interval"]
            obstacles = tuple(
                ValidatedObstacle(each["form"], tuple(each["lower"]), tuple(each["upper"]))
                for each in settings["obstacles"]
            )
            return Certificate(
                TargetRegion.from_settings(settings["goals"]),
                TargetRegion.from_settings(settings["starts"]),
                ValidatedScene(settings["robot"], obstacles, settings["margin"]),
                settings["runs"],
                settings["causes"],
                ConfidenceInterval(
                    float(low), float(high), settings["confidence"], settings["method"]
                ),
                settings["required"],
                None if holds is None else TargetRegion.from_settings(holds),
                settings["seed"],
            )
        except (KeyError, TypeError, ValueError) as error:
            raise InvalidInput(f"certificate: damaged ({error})") from None

    def __str__(self) -> str:
        low, high = self.interval.lower, self.interval.upper
        return (
            f"{self.successes} of {self.runs} queries succeed, {self.fraction:.2%}; with "
            f"{self.interval.confidence:.0%} confidence {low:.2%} to {high:.2%}"
        )


def _matched(shapes: list[Shape], known: list[ValidatedObstacle]) -> bool:
    """Whether each shape is one of the known obstacles, and each of these is there once."""
    for shape in shapes:
        match = next((each for each in known if each.covers(shape)), None)
        if match is None:
            return False
        known.remove(match)
    return not known

"""The scene around an arm: obstacles that stand, move or are drawn at random, and the margins.

Checks judge the margins as stated. Planning keeps `PLANNING_TOLERANCE` more, so that a planned
motion passes a check with the same scene: a check may miss a hit of this depth between samples,
and the time law replaces the samples by nearby ones.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.repr import ShortRepr
from leadthrough.shapes.kinds import check_shapes
from leadthrough.shapes.shape import Shape

PLANNING_TOLERANCE = 1e-3  # m beyond the margins


@dataclass(frozen=True, eq=False)
class MovingObstacle(ShortRepr):
    """An obstacle with a bound on its speed.

    The guard takes it to be anywhere that it may have moved to. For all else it is at its present
    pose.

    Attributes:
        shape: the obstacle at its present pose, in the base frame.
        speed: upper bound of the speed of all of its points, m/s, >= 0.

    Raises:
        InvalidInput: if the shape is not a shape, or the speed is negative or not finite.
    """

    shape: Shape
    speed: float

    def __post_init__(self) -> None:
        check_shapes([self.shape])
        object.__setattr__(self, "speed", check.number(self.speed, "speed", at_least=0.0))


@dataclass(frozen=True, eq=False, init=False)
class RandomObstacle(ShortRepr):
    """An obstacle whose position is drawn at random for each query of a validation.

    Attributes:
        shape: the obstacle; its own position is not used.
        lower: smallest coordinates of its position (3,), m in the base frame.
        upper: largest coordinates (3,), >= lower.

    Raises:
        InvalidInput: if the shape is not a shape, or a corner is malformed.
    """

    shape: Shape
    lower: Float64Array
    upper: Float64Array

    def __init__(self, shape: Shape, lower: ArrayLike, upper: ArrayLike) -> None:
        check_shapes([shape])
        low = check.frozen(lower, "lower", shape=(3,))
        high = check.frozen(upper, "upper", shape=(3,))
        if (high < low).any():
            raise InvalidInput(f"upper: expected at least lower {low}, got {high}")
        vars(self).update(shape=shape, lower=low, upper=high)

    def draw(self, rng: np.random.Generator) -> Shape:
        """The shape at a random position.

        Args:
            rng: source of the random numbers.
        """
        return self.shape.at(rng.uniform(self.lower, self.upper))


Obstacle = Shape | MovingObstacle | RandomObstacle


@dataclass(frozen=True, eq=False, init=False)
class Scene(ShortRepr):
    """The obstacles around an arm, and the distances to keep from them.

    Taken wherever an arm is asked; a plain list of obstacles is a scene with the default margins.

    Attributes:
        obstacles: shapes, `MovingObstacle` and `RandomObstacle`, in the base frame.
        margin: distance to keep from obstacles, m, >= 0.
        self_collision_margin: distance to keep between parts of the arm, m, >= 0.

    Raises:
        InvalidInput: if an obstacle is none of these, or a margin is negative or not finite.
    """

    obstacles: tuple[Obstacle, ...]
    margin: float
    self_collision_margin: float

    def __init__(
        self,
        obstacles: Iterable[Obstacle] = (),
        margin: float = 0.005,
        self_collision_margin: float = 0.0,
    ) -> None:
        things = tuple(obstacles) if isinstance(obstacles, Iterable) else obstacles
        check_shapes(map(_shape, things) if isinstance(things, tuple) else things)
        vars(self).update(
            obstacles=things,
            margin=check.number(margin, "margin", at_least=0.0),
            self_collision_margin=check.number(
                self_collision_margin, "self_collision_margin", at_least=0.0
            ),
        )

    @property
    def shapes(self) -> tuple[Shape, ...]:
        """The obstacles at their present poses.

        Raises:
            InvalidInput: if the position of one has yet to be drawn.
        """
        if any(isinstance(each, RandomObstacle) for each in self.obstacles):
            raise InvalidInput(
                "scene: a RandomObstacle has no position yet; use scene.draw(rng), or "
                "leadthrough.validate"
            )
        return tuple(map(_shape, self.obstacles))

    @property
    def speeds(self) -> tuple[float, ...]:
        """Upper bound of each obstacle's speed, m/s."""
        return tuple(
            each.speed if isinstance(each, MovingObstacle) else 0.0 for each in self.obstacles
        )

    def draw(self, rng: np.random.Generator) -> Scene:
        """The scene with a position drawn for each `RandomObstacle`, in their order.

        Args:
            rng: source of the random numbers.
        """
        drawn = (
            each.draw(rng) if isinstance(each, RandomObstacle) else each for each in self.obstacles
        )
        return replace(self, obstacles=tuple(drawn))

    def for_planning(self) -> Scene:
        """The scene with the planning tolerance added to both margins."""
        return replace(
            self,
            margin=self.margin + PLANNING_TOLERANCE,
            self_collision_margin=self.self_collision_margin + PLANNING_TOLERANCE,
        )


SceneLike = Scene | Iterable[Obstacle]


def as_scene(scene: SceneLike) -> Scene:
    """The scene itself, or one of the given obstacles with the default margins."""
    return scene if isinstance(scene, Scene) else Scene(scene)


def _shape(obstacle: Obstacle) -> Shape:
    """The obstacle's shape at its present pose."""
    return obstacle.shape if isinstance(obstacle, MovingObstacle | RandomObstacle) else obstacle

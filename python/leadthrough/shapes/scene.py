"""All shapes, and the scene around an arm: obstacles and the margins.

Obstacles stand, move or are drawn at random. Checks judge the margins as stated. Planning keeps
`PLANNING_TOLERANCE` more, so that a planned motion passes a check with the same scene, also after
the time law has replaced its samples by nearby ones.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput, ShortRepr
from leadthrough.shapes.mesh import Mesh, PointCloud
from leadthrough.shapes.primitives import PRIMITIVES
from leadthrough.shapes.shape import Shape

PLANNING_TOLERANCE = 2e-4  # m beyond the margins


# The command line, the messages and the tests read this list.
SHAPES: tuple[type[Shape], ...] = (*PRIMITIVES.values(), Mesh, PointCloud)


def names_of(kind: type[Shape]) -> str:
    """The names of the shapes of a kind, as in "Box, Sphere or Mesh"."""
    *others, last = (shape.__name__ for shape in SHAPES if issubclass(shape, kind))
    return f"{', '.join(others)} or {last}"


_Item = TypeVar("_Item")


def _items(obstacles: Iterable[_Item]) -> tuple[_Item, ...]:
    try:
        return tuple(obstacles)
    except TypeError:  # also of arrays without axes, which say that they can be iterated
        raise check.refused("obstacles", "a sequence", type(obstacles).__name__) from None


def check_shapes(obstacles: Iterable[Shape]) -> tuple[Shape, ...]:
    """The obstacles, if all are shapes."""
    shapes = _items(obstacles)
    for shape in shapes:
        if not isinstance(shape, Shape):
            raise InvalidInput(f"obstacles: expected {names_of(Shape)}, got {type(shape).__name__}")
    return shapes


def compiled(shapes: Sequence[Shape]) -> list[core.Shape]:
    """The shapes as the compiled core takes them."""
    return [shape._compiled for shape in shapes]


@dataclass(frozen=True, eq=False)
class MovingObstacle(ShortRepr):
    """An obstacle with a bound on its speed.

    The guard takes it to be anywhere that it may have moved to. For all else it is at its present
    pose.

    Attributes:
        shape: the obstacle at its present pose, in the base frame.
        speed: upper bound of the speed of all of its points, m/s, >= 0.
    """

    shape: Shape
    speed: float

    def __post_init__(self) -> None:
        check_shapes([self.shape])
        object.__setattr__(self, "speed", check.number(self.speed, "speed", at_least=0.0))


@dataclass(frozen=True, eq=False)
class RandomObstacle(ShortRepr):
    """An obstacle whose position is drawn at random for each query of a validation.

    Attributes:
        shape: the obstacle, at the middle of its positions.
        reach: largest distance from there along each axis of the base frame, (3,) or one number,
            m, >= 0.
    """

    shape: Shape
    reach: ArrayLike

    def __post_init__(self) -> None:
        check_shapes([self.shape])
        reach = np.asarray(self.reach)
        reach = check.frozen(np.full(3, reach) if reach.ndim == 0 else reach, "reach", shape=(3,))
        if (reach < 0.0).any():
            raise InvalidInput(f"reach: expected distances >= 0, got {reach}")
        object.__setattr__(self, "reach", reach)

    @property
    def lower(self) -> Float64Array:
        """Smallest coordinates of its position (3,), m."""
        return np.asarray(self.shape.position - np.asarray(self.reach))

    @property
    def upper(self) -> Float64Array:
        """Largest coordinates of its position (3,), m."""
        return np.asarray(self.shape.position + np.asarray(self.reach))

    def draw(self, rng: np.random.Generator) -> Shape:
        """The shape at a random position."""
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
        things = _items(obstacles)
        check_shapes(map(_shape, things))
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
        """The scene with a position drawn for each `RandomObstacle`, in their order."""
        drawn = (
            each.draw(rng) if isinstance(each, RandomObstacle) else each for each in self.obstacles
        )
        return replace(self, obstacles=tuple(drawn))

    def for_planning(self) -> Scene:
        """The scene with the planning tolerance added to the margins.

        A self-collision margin of 0 stays 0: some arms have parts that touch by design.
        """
        itself = self.self_collision_margin
        return replace(
            self,
            margin=self.margin + PLANNING_TOLERANCE,
            self_collision_margin=itself + PLANNING_TOLERANCE if itself else 0.0,
        )


SceneLike = Scene | Iterable[Obstacle]


def as_scene(scene: SceneLike) -> Scene:
    """The scene itself, or one of the given obstacles with the default margins."""
    return scene if isinstance(scene, Scene) else Scene(scene)


def _shape(obstacle: Obstacle) -> Shape:
    return obstacle.shape if isinstance(obstacle, MovingObstacle | RandomObstacle) else obstacle

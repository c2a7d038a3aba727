"""The result of a skill's validation, saved in its file: regions, runs and successes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from typing import Any

import numpy as np

from leadthrough.errors import InvalidInput
from leadthrough.models.targets import Target, TargetRegion
from leadthrough.repr import ShortRepr
from leadthrough.shapes import MovingObstacle, Obstacle, RandomObstacle, Shape


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
class Certificate(ShortRepr):
    """Success rate of a skill's motions, for queries drawn at random from stated regions.

    Attributes:
        goals: region of the queries' goals.
        starts: region of their starts.
        obstacles: of every query.
        robot: the arm: its name, base and tip.
        margin: distance that the arm kept from obstacles, m.
        runs: number of queries.
        successes: of them, whose motion the arm can run.
        causes: number of failures by their cause.
        interval: lower and upper bound of the fraction that succeeds.
        confidence: with which the interval holds it.
        method: of the interval.
        required: fraction that `holds` promises.
        holds: the largest part of `goals` in which at least the required fraction succeeds, with
            the same confidence; None if there is none.
        seed: of the random number generator.
    """

    goals: TargetRegion
    starts: TargetRegion
    obstacles: tuple[ValidatedObstacle, ...]
    robot: str
    margin: float
    runs: int
    successes: int
    causes: Mapping[str, int]
    interval: tuple[float, float]
    confidence: float
    method: str
    required: float
    holds: TargetRegion | None
    seed: int

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
            robot: the arm, as `robot` names it; empty if none is known.
        """
        reasons = [
            f"{name} outside {region}"
            for name, region, target in (("start", self.starts, start), ("goal", self.goals, goal))
            if not region.contains(target)
        ]
        if not _matched(list(obstacles), list(self.obstacles)):
            reasons.append("other obstacles")
        if robot and robot != self.robot:
            reasons.append(f"another arm than {self.robot}")
        return tuple(reasons)

    def to_settings(self) -> dict[str, Any]:
        """Plain values, as JSON knows them."""
        plain = {each.name: getattr(self, each.name) for each in fields(self)}
        holds = None if self.holds is None else self.holds.to_settings()
        return plain | {
            "goals": self.goals.to_settings(),
            "starts": self.starts.to_settings(),
            "obstacles": [asdict(each) for each in self.obstacles],
            "causes": dict(self.causes),
            "interval": list(self.interval),
            "holds": holds,
        }

    @staticmethod
    def from_settings(settings: Mapping[str, Any]) -> Certificate:
        """The certificate with these plain values.

        Args:
            settings: as `to_settings` made them.

        Raises:
            InvalidInput: if one is missing or wrong.
        """
        try:
            holds = settings["holds"]
            low, high = settings["interval"]
            obstacles = tuple(
                ValidatedObstacle(each["form"], tuple(each["lower"]), tuple(each["upper"]))
                for each in settings["obstacles"]
            )
            made = {
                "goals": TargetRegion.from_settings(settings["goals"]),
                "starts": TargetRegion.from_settings(settings["starts"]),
                "obstacles": obstacles,
                "interval": (float(low), float(high)),
                "holds": None if holds is None else TargetRegion.from_settings(holds),
            }
            plain = {each.name: settings[each.name] for each in fields(Certificate)}
            return Certificate(**{**plain, **made})
        except (KeyError, TypeError, ValueError) as error:
            raise InvalidInput(f"certificate: damaged ({error})") from None

    def __str__(self) -> str:
        low, high = self.interval
        return (
            f"{self.successes} of {self.runs} queries succeed, {self.fraction:.2%}; with "
            f"{self.confidence:.0%} confidence {low:.2%} to {high:.2%}"
        )


def _matched(shapes: list[Shape], known: list[ValidatedObstacle]) -> bool:
    """Whether each shape is one of the known obstacles, and each of these is there once."""
    for shape in shapes:
        match = next((each for each in known if each.covers(shape)), None)
        if match is None:
            return False
        known.remove(match)
    return not known

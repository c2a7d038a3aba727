"""What a collision check found: nearest approaches, first hits and distances."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.drawing import palette
from leadthrough.drawing.drawn import Drawn
from leadthrough.drawing.panels import Line, Panel
from leadthrough.errors import InvalidInput
from leadthrough.repr import ShortRepr


@dataclass(frozen=True, eq=False)
class Approach(ShortRepr):
    """Two bodies where they are nearest.

    Attributes:
        sample: index of a sample; with a fraction, between it and the next.
        time: in s; None where the motion has no times.
        bodies: links by name, "attached", or "obstacle" with its index.
        distance: in m; the depth of the overlap, negative, where the bodies overlap.
        points: (2, 3) in m, one point on each body, in the base frame.
    """

    sample: float
    time: float | None
    bodies: tuple[str, str]
    distance: float
    points: Float64Array

    def __str__(self) -> str:
        a, b = self.bodies
        when = f"sample {self.sample:g}" if self.time is None else f"{self.time:.3f} s"
        return f"{1e3 * self.distance:.1f} mm, {a} and {b} at {when}"


@dataclass(frozen=True, eq=False)
class Clearance(ShortRepr):
    """How near the arm comes to obstacles, or to itself.

    Attributes:
        first: where something first comes nearer than `margin`; None where nothing does.
        closest: the nearest approach of the whole motion, between samples as well; None where
            nothing is checked.
        distances: (m,) at the samples in m, infinite where nothing is checked.
        margin: the distance to keep in m.
    """

    first: Approach | None
    closest: Approach | None
    distances: Float64Array
    margin: float

    @property
    def minimum_distance(self) -> float:
        """Distance of the closest approach in m; infinite where nothing is checked."""
        return np.inf if self.closest is None else self.closest.distance


@dataclass(frozen=True, eq=False)
class CollisionReport(Drawn):
    """What a check found; a motion that hits something is a finding, not an error.

    The two clearances are apart because parts of an arm are near each other by design.

    Attributes:
        obstacles: clearance from obstacles.
        itself: clearance between parts of the arm.
        tolerance: in m. Anything nearer than the closest approach, or hit before the first hit, is
            so by less than this.
    """

    obstacles: Clearance
    itself: Clearance
    tolerance: float

    @property
    def ok(self) -> bool:
        """Whether nothing comes nearer than its margin; bodies that just touch are not nearer."""
        return self.first is None

    @property
    def first(self) -> Approach | None:
        """The first hit of both kinds; None where there is none."""
        hits = [hit for hit in (self.obstacles.first, self.itself.first) if hit is not None]
        return min(hits, key=lambda hit: hit.sample, default=None)

    @property
    def closest(self) -> Approach | None:
        """The nearest approach of both kinds; None where nothing is checked."""
        both = (self.obstacles, self.itself)
        return min(both, key=lambda clearance: clearance.minimum_distance).closest

    @property
    def minimum_distance(self) -> float:
        """Distance of the closest approach in m; infinite where nothing is checked."""
        return min(self.obstacles.minimum_distance, self.itself.minimum_distance)

    @property
    def distances(self) -> Float64Array:
        """The smaller distance (m,) of both kinds at the samples in m."""
        return np.minimum(self.obstacles.distances, self.itself.distances)

    def _repr_parts(self) -> list[str]:
        return [f"ok={self.ok}", str(self)]

    def _panels(self) -> list[Panel]:
        lines = []
        for name, each in (("obstacles", self.obstacles), ("itself", self.itself)):
            if each.closest is not None:
                samples = np.arange(len(each.distances), dtype=np.float64)
                lines.append(Line(samples, each.distances, name))
                margin = np.full(2, each.margin)
                ends = samples[[0, -1]]
                lines.append(Line(ends, margin, colour=palette.VERMILION, dashed=True))
        if not lines:
            raise InvalidInput("report: there was nothing to hit, so there is nothing to draw")
        return [Panel("distance in m, margins dashed", lines, "sample")]

    def __str__(self) -> str:
        if self.closest is None:
            return "clear: there is nothing to hit"
        if self.first is None:
            return f"clear by {self.closest}"
        return f"hit: {self.first}; nearest: {self.closest}"


@dataclass(frozen=True, eq=False)
class CollisionPairs(ShortRepr):
    """Which bodies of an arm are checked against each other, and why the others are not.

    Attributes:
        checked: pairs of names.
        left_out: reason by pair: "adjacent", neighbours along the chain; "never", not within 5 cm
            in 4000 configurations spread over the joints' ranges; "always", touching in all of
            them.
    """

    checked: tuple[tuple[str, str], ...]
    left_out: dict[tuple[str, str], str]

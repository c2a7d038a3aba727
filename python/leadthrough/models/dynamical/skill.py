"""A skill that is a dynamical system: generated, asked for its velocity anywhere, checked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, ClassVar, Generic

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput, UnsupportedQuery
from leadthrough.models.archive import Archived, Arrays
from leadthrough.models.chart import Chart
from leadthrough.models.demonstrated import Demonstrations
from leadthrough.models.dynamical.arrival import way
from leadthrough.models.dynamical.field import Field
from leadthrough.models.dynamical.situation import Situation, sheets, situation, twist
from leadthrough.models.dynamical.stability import StabilityReport, examined
from leadthrough.models.even_times import even_times
from leadthrough.models.judged import judged
from leadthrough.models.parameters import Parameter, fitted_again
from leadthrough.models.place import Place
from leadthrough.motion import Motion, MotionT_co, normalised_times
from leadthrough.shapes import Shape


@dataclass(frozen=True, eq=False)
class DynamicalSkill(Archived, Generic[MotionT_co]):
    """A system x' = f(x) whose trajectories all end at the goal; made by `fit` of its model.

    It has no clock: wherever a tool is pushed to, `policy` leads it on from there.

    Attributes:
        model: the settings that it was fitted with.
        chart: what the d columns are: the coordinates of points, the joints, or for poses the
            position and a rotation vector from the goal's orientation.
        field: the system, in normalised columns about the goal and durations.
        scale: what columns (d,) are divided by.
        ends: mean start and goal (2, d) of the demonstrations.
        shown_duration: median duration of the demonstrations, s.
        pace: by how much the system's own speed is multiplied, so that it takes as long from the
            demonstrations' starts as they took.
        positions: normalised positions (n, d) of the demonstrations, about the goal.
    """

    model: Any  # one of the models of this family, whose settings differ
    chart: Chart[MotionT_co]
    field: Field
    scale: Float64Array
    ends: Float64Array
    shown_duration: float
    pace: float
    positions: Float64Array

    kind: ClassVar[str] = "dynamical"
    supports: ClassVar[frozenset[str]] = frozenset({"start", "goal", "duration"})

    def policy(self, position: ArrayLike, *, goal: Place | None = None) -> Float64Array:
        """The velocity that leads from a place to the goal.

        Args:
            position: position or joints (d,), or rows (n, d) of them; for poses (position (3,),
                orientation (4,) as w, x, y, z).
            goal: where to; by default the demonstrations' mean goal.

        Returns:
            Velocity (d,), or (n, d), per second; of a pose (6,): linear and angular, in the base
            frame, m/s and rad/s.

        Raises:
            InvalidInput: if an argument is of another shape.
        """
        if self.chart.kind == "poses":
            here = self._situation(self._pose(position), goal)
            x = self._as_shown(here.start)[None]
            columns = self._velocities(x)
            turned = x[:, 3:] * self.scale[3:]
            return np.concatenate([columns[0, :3], twist(here.chart, turned, columns[:, 3:])[0]])
        there = self._situation(None, goal).goal
        size = self.chart.size
        given = check.array_of_rank(position, "position", shapes=((size,), ("n", size)))
        rows = (np.atleast_2d(given) - there) / self.scale
        return self._velocities(rows).reshape(given.shape)

    @judged
    def generate(
        self,
        *,
        start: Place | None = None,
        goal: Place | None = None,
        duration: float | None = None,
        dt: float = 0.01,
        obstacles: Sequence[Shape] = (),
    ) -> MotionT_co:
        """The system's trajectory from a start, continued to rest at the goal over the last 5 %.

        Args:
            start: columns (d,) at the start; for poses (position (3,), orientation (4,) as
                w, x, y, z) or the position alone. By default the demonstrations' mean.
            goal: the same at the end; the whole system moves with it.
            duration: duration, s, > 0; by default as long as the system takes.
            dt: largest time between samples, s, > 0.
            obstacles: must be empty.

        Returns:
            A motion of the type that was demonstrated.

        Raises:
            InvalidInput: if an argument is wrong.
            UnsupportedQuery: for obstacles.
            NoPath: if the goal is not reached in 100 times the demonstrations' duration.
        """
        if len(obstacles) > 0:
            raise UnsupportedQuery(
                "obstacles: a dynamical system cannot avoid them; leave them out or use "
                "FastMarching"
            )
        check.number(dt, "dt", above=0.0)
        if duration is not None:
            check.number(duration, "duration", above=0.0)
        here = self._situation(start, goal)
        found = way(self.field, here.start)
        total = found.duration * self.shown_duration / self.pace if duration is None else duration
        times = even_times(total, dt)
        phases = normalised_times(times)
        columns = here.columns(found.at(phases))
        return here.chart.motion(times, phases, columns)

    @property
    def duration(self) -> float:
        """Duration of its own motion, s."""
        return way(self.field, self._situation(None, None).start).duration * (
            self.shown_duration / self.pace
        )

    def stability(
        self, starts: int = 10_000, *, around: float = 1.0, seed: int = 0
    ) -> StabilityReport:
        """Whether trajectories from many starts arrive, and the energy falls on the way.

        Args:
            starts: number of starts, >= 1: half drawn evenly in a box around the demonstrations,
                half about their samples.
            around: by how much of the demonstrations' extent the box is larger on each side.
            seed: seed of the random number generator that draws the starts.

        Raises:
            InvalidInput: if an argument is out of range.
        """
        check.affordable_count(starts, "starts", each=8 * self.chart.width)
        check.number(around, "around", at_least=0.0)
        rng = np.random.default_rng(check.integer(seed, "seed", at_least=0))
        return examined(self.field, self.positions, starts, around, rng)

    def parameters(
        self, demonstrations: Demonstrations[Motion] = ()
    ) -> Sequence[Parameter[MotionT_co]]:
        """The number of its parts, if there are demonstrations to fit again.

        Args:
            demonstrations: the demonstrations that the skill was fitted to.
        """
        setting, least, most = self.model.slider
        return fitted_again(self, setting, demonstrations, least=least, most=most)

    # Any: settings are whatever JSON holds.
    def to_archive(self) -> tuple[dict[str, Any], Arrays]:
        """Settings and arrays that `archive.from_archive` turns into the skill again."""
        settings = {
            "name": type(self.model).__name__,
            "model": asdict(self.model),
            "field": self.field.name,
            "duration": self.shown_duration,
            "pace": self.pace,
            **self.chart.settings(),
        }
        own = {f"field_{name}": value for name, value in self.field.arrays().items()}
        arrays = {"scale": self.scale, "ends": self.ends, "positions": self.positions}
        return settings, {**arrays, **own, **self.chart.arrays()}

    def _velocities(self, x: Float64Array) -> Float64Array:
        """Velocities (n, d) of the columns, per second, at normalised positions (n, d)."""
        return self.field.velocity(x) * self.scale * (self.pace / self.shown_duration)

    def _situation(self, start: Place | None, goal: Place | None) -> Situation[MotionT_co]:
        return situation(self.chart, self.ends, self.scale, start, goal)

    def _as_shown(self, x: Float64Array) -> Float64Array:
        """The same pose (6,), its rotation vector on the sheet nearest to a demonstration."""
        turns = sheets(x[3:] * self.scale[3:], self.ends[0, 3:])
        places = [np.concatenate([x[:3], turn / self.scale[3:]]) for turn in turns]
        return min(places, key=lambda each: float(((self.positions - each) ** 2).sum(axis=1).min()))

    def _pose(self, place: Any) -> Place:
        if not isinstance(place, tuple | list) or len(place) != 2:
            raise InvalidInput(
                "position: expected (position (3,), orientation (4,)) of a skill of poses"
            )
        return place[0], place[1]

"""What discrete primitives of points and of poses have in common: how their states go on."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import _core, check, events
from leadthrough.check import Float64Array
from leadthrough.events import Event, Events
from leadthrough.models.archive import Archived, Arrays
from leadthrough.models.dmp import springs
from leadthrough.models.dmp.constraints import Constraints, roll, step_within
from leadthrough.models.dmp.pace import COARSE_PHASES, PHASES
from leadthrough.models.dmp.progress import Progress, corrected_until
from leadthrough.models.dmp.query import Via, check_duration, check_step, course_through
from leadthrough.models.dmp.springs import Ends, Springs
from leadthrough.models.even_times import even_phases
from leadthrough.models.place import Place
from leadthrough.models.posture import Posture, arrays_of, settings_of
from leadthrough.models.protocol import Model, Skill
from leadthrough.motion import JointTrajectory, Motion
from leadthrough.shapes import Shape

ModelT = TypeVar("ModelT", bound=Model)
# A goal nearer than this fraction of the motion's size to the one before is the same.
_SAME_GOAL = 1e-13

StateT = TypeVar("StateT", _core.PointState, _core.PoseState)


@dataclass(frozen=True, eq=False)
class Primitive(Archived, Generic[ModelT, StateT]):
    """A learned discrete primitive; its attributes are documented where they are public."""

    model: ModelT
    springs: Springs
    duration: float
    size: float
    events: tuple[Event, ...]
    posture: Posture | None = field(default=None, kw_only=True)

    @property
    @abstractmethod
    def progress(self) -> Progress:
        """How far each channel has come at each phase, in replay."""

    @abstractmethod
    def begin(
        self,
        *,
        start: Place | None = None,
        goal: Place | None = None,
        duration: float | None = None,
    ) -> StateT:
        """The state at the start, for `step`."""

    @abstractmethod
    def generate(self, *, dt: float = 0.01) -> Motion:
        """The motion from start to goal."""

    def replay(self, samples: int) -> Motion:
        """The demonstrated motion, evenly sampled.

        Args:
            samples: their number, 2 or more.
        """
        return self.generate(dt=self.duration / (samples - 1))

    def relearned(self, motion: Motion) -> Skill:
        """The skill of another motion, learned with the same settings.

        Args:
            motion: of the type that was shown.

        Raises:
            InvalidInput: for a motion of another type.
            FitError: for one that does not move.
        """
        return self.model.fit([motion])

    def default_duration(self, *, start: Place | None = None, goal: Place | None = None) -> float:
        """How long a motion takes by default, s: as demonstrated, or longer.

        A start or goal that is moved along the motion's own way makes the motion quicker. It then
        takes as much longer as keeps the highest linear, angular or joint speed within 1.3 times
        the demonstrated one. Speeds up to 0.05 m/s and 0.25 rad/s are never held back, and a tool
        that was shown to move by less than 2 mm, or to turn by less than 0.05 rad, sets no pace
        for that. The forms of the literature keep the demonstrated duration.

        Args:
            start: as in `generate`.
            goal: as in `generate`.

        Raises:
            InvalidInput: if one is of another shape or range.
        """
        if (start is None and goal is None) or self.springs.form != "blended":
            return self.duration
        state = self.begin(start=start, goal=goal, duration=self.duration)
        return self.duration * self._lengthening(state)

    def _supported(self, *, obstacles: bool) -> frozenset[str]:
        """What a query may ask for; a final velocity only with the form "blended"."""
        known = {"start", "goal", "duration", "via", "start_velocity"}
        known |= {"final_velocity"} if self.springs.form == "blended" else set()
        return frozenset(known | {"obstacles"} if obstacles else known)

    def _looked_at(self, state: StateT) -> tuple[Float64Array, Float64Array]:
        """Values and slopes (n, channels) of the motion from a state on, at COARSE_PHASES."""
        return _core.dmp_rollout(
            self.springs.forces, state.course, state.value, state.slope, COARSE_PHASES
        )

    def _duration(self, duration: float | None, start: Place | None, goal: Place | None) -> float:
        """The duration of a query, s."""
        if duration is None:
            return self.default_duration(start=start, goal=goal)
        return check_duration(duration, self.duration)

    def _course(self, ends: Ends, via: Via, *, count: int) -> _core.DmpCourse:
        """The course between ends and through via points, of the first `count` channels."""
        learned = self.springs
        if ends.equal(learned.ends):
            direct = learned.shown_course
        elif learned.form != "blended":
            direct = springs.course(learned.form, ends)
        else:
            direct = self._moved_course(ends)
        return course_through(learned, direct, ends, via, count=count)

    def _moved_course(self, ends: Ends) -> _core.DmpCourse:
        """The course of the form "blended" between ends."""
        known = self.springs.ends
        if ends.start_slope is known.start_slope and ends.goal_slope is known.goal_slope:
            plain = self._shown_reference
        else:
            jerk = springs.minimum_jerk(ends.moved(known.start, known.goal))
            plain = self.progress.expanded(jerk)
        start, goal = ends.start - known.start, ends.goal - known.goal
        return springs.moved_course(plain, self.progress, start=start, goal=goal)

    @cached_property
    def _shown_reference(self) -> Float64Array:
        """The minimum-jerk motion between the ends as shown, about each break of the progress."""
        return self.progress.expanded(springs.minimum_jerk(self.springs.ends))

    def _course_to(
        self,
        state: StateT,
        goal: Float64Array,
        value: Float64Array | None = None,
        slope: Float64Array | None = None,
    ) -> _core.DmpCourse:
        """The course of a state on its way to another goal (channels,)."""
        before, form = state.course, self.springs.form
        if form != "blended":
            return springs.redirected(form, before, goal)
        shift = goal - springs.end_of(before)
        if value is None or slope is None:
            if np.abs(shift).max() <= _SAME_GOAL * max(self.size, float(np.abs(goal).max())):
                return before
            if state.phase == 0.0:
                return springs.shifted(before, self.progress, shift)
            value = slope = np.zeros(len(shift))
        until = corrected_until(state.phase, self.progress.end)
        return before.superposed(state.phase, until, value, slope, shift)

    def _replayed(self) -> tuple[Float64Array, Float64Array]:
        """Values and slopes (n, channels) at PHASES, as demonstrated."""
        learned, ends = self.springs, self.springs.ends
        course = learned.shown_course
        return _core.dmp_rollout(learned.forces, course, ends.start, ends.start_slope, PHASES)

    def _advanced(
        self,
        state: StateT,
        dt: float,
        *,
        goal: Place | None,
        coupling: ArrayLike | None,
        lag: float,
        measured: Place | None,
        obstacles: Sequence[Shape],
        limits: tuple[ArrayLike, ArrayLike] | None = None,
    ) -> StateT:
        """The state dt s later; arguments and errors are those of the public `step`."""
        span = check_step(dt, lag, state.duration)
        if goal is not None:
            state = self._redirected(state, goal)
        if measured is not None:
            state = self._moved(state, measured)
        if coupling is None and limits is None and not obstacles:
            return state.coast(self.springs.forces, span)
        push = np.zeros(len(state.value)) if coupling is None else self._acceleration(coupling)
        kept = self._constraints(obstacles, limits)
        return step_within(self.springs, state, span, push, constraints=kept, size=self.size)

    def _rolled(
        self, state: StateT, dt: float, constraints: Constraints
    ) -> tuple[Float64Array, Float64Array, Float64Array]:
        """Phases (n,), values and slopes (n, channels) from a state at the start to the end."""
        phases = even_phases(state.duration, dt)
        values, slopes = roll(self.springs, state, phases, constraints=constraints, size=self.size)
        return phases, values, slopes

    def _events(self, duration: float) -> Events:
        """Its events in a motion of a duration, s."""
        return events.moved(self.events, (0.0, 1.0), (0.0, duration))

    def _joints(self, duration: float, phases: Float64Array) -> JointTrajectory | None:
        """The arm's joints at phases (n,) of a motion of a duration, s, if they were shown."""
        return None if self.posture is None else self.posture.along(duration * phases, phases)

    def _settings(self) -> dict[str, Any]:
        """Its plain values beside those of the model, for a file."""
        return {
            "duration": self.duration,
            "size": self.size,
            "events": events.to_plain(self.events),
            **settings_of(self.posture),
        }

    def _arrays(self) -> Arrays:
        """Its arrays beside those of the orientation, for a file."""
        return {**self.springs.arrays(), **arrays_of(self.posture)}

    @abstractmethod
    def _lengthening(self, state: StateT) -> float:
        """The factor >= 1 by which the motion from a state at the start on must take longer."""

    @abstractmethod
    def _redirected(self, state: StateT, goal: Place) -> StateT:
        """The state on its way to another goal."""

    @abstractmethod
    def _moved(self, state: StateT, measured: Place) -> StateT:
        """The state at another place."""

    @abstractmethod
    def _acceleration(self, coupling: ArrayLike) -> Float64Array:
        """A coupling as an acceleration (channels,)."""

    @abstractmethod
    def _constraints(
        self, obstacles: Sequence[Shape], limits: tuple[ArrayLike, ArrayLike] | None
    ) -> Constraints:
        """What a motion keeps to."""


def take_settings(
    settings: dict[str, Any], arrays: Arrays
) -> tuple[float, float, Events, Posture | None]:
    """Duration, size, events and posture of a file; its settings then are the model's alone."""
    duration = check.number(settings.pop("duration"), "duration", above=0.0)
    size = check.number(settings.pop("size"), "size", at_least=0.0)
    happening = events.from_plain(settings.pop("events", ()))
    return duration, size, happening, Posture.from_archive(settings, arrays)

"""What discrete primitives of points and of poses have in common: how their states go on."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import _core, check, events
from leadthrough.check import Float64Array
from leadthrough.events import Event, Events
from leadthrough.models.archive import Archived
from leadthrough.models.dmp.constraints import Constraints, roll, step_within
from leadthrough.models.dmp.query import check_step
from leadthrough.models.dmp.springs import Springs
from leadthrough.models.even_times import even_phases
from leadthrough.models.place import Place
from leadthrough.models.protocol import Model
from leadthrough.shapes import Shape

ModelT = TypeVar("ModelT", bound=Model)
StateT = TypeVar("StateT", _core.PointState, _core.PoseState)


@dataclass(frozen=True, eq=False)
class Primitive(Archived, Generic[ModelT, StateT]):
    """A learned discrete primitive; its attributes are documented where they are public."""

    model: ModelT
    springs: Springs
    duration: float
    size: float
    events: tuple[Event, ...]

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
        changed = goal is not None or measured is not None or coupling is not None
        unconstrained = limits is None and not obstacles
        if not changed and unconstrained and type(dt) is float and lag == 0.0:
            # The quick way: control loops ask a thousand times a second.
            after = state.tick(self.springs.forces, dt)
            if after is not None:
                return after
        span = check_step(dt, lag, state.duration)
        if goal is not None:
            state = self._redirected(state, goal)
        if measured is not None:
            state = self._moved(state, measured)
        if coupling is None and unconstrained:
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

    def _settings(self) -> dict[str, Any]:
        """Its plain values beside those of the model, for a file."""
        return {
            "duration": self.duration,
            "size": self.size,
            "events": events.to_plain(self.events),
        }

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


def take_settings(settings: dict[str, Any]) -> tuple[float, float, Events]:
    """Duration, size and events, taken out of the settings in a file; the model's are left.

    Raises:
        KeyError: if one is missing.
        TypeError, InvalidInput: if one is not what it should be.
    """
    duration = check.number(settings.pop("duration"), "duration", above=0.0)
    size = check.number(settings.pop("size"), "size", at_least=0.0)
    return duration, size, events.from_plain(settings.pop("events", ()))

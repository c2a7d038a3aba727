"""What rhythmic primitives of points and of poses have in common.

The force is made of von Mises kernels of a phase that counts periods, and the springs pull to the
centre of the motion. Source: Ijspeert et al. 2013, section 2.1.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any, ClassVar, Generic, TypeVar

from numpy.typing import ArrayLike

from leadthrough import _core, check, events
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput, UnsupportedQuery
from leadthrough.events import Event, Events
from leadthrough.models.archive import Archived, Arrays
from leadthrough.models.dmp.kernels import MOST_WEIGHTS
from leadthrough.models.dmp.query import check_duration, check_step, ends_of
from leadthrough.models.dmp.springs import RHYTHMIC, Ends, Springs
from leadthrough.models.even_times import even_times
from leadthrough.models.place import Place
from leadthrough.models.posture import Posture, arrays_of, settings_of
from leadthrough.models.unfitted import Unfitted
from leadthrough.motion import JointTrajectory
from leadthrough.shapes import Shape, check_shapes

SettingsT = TypeVar("SettingsT", bound="Settings")
StateT = TypeVar("StateT", _core.PointState, _core.PoseState)

_MOST_PERIODS = 10_000  # in one query; more come from a wrong unit


@dataclass(frozen=True)
class Settings(Unfitted):
    """Settings of rhythmic primitives; they are documented where they are public."""

    weights: int = 25
    period: float | None = None

    def __post_init__(self) -> None:
        check.integer(self.weights, "weights", at_least=3, at_most=MOST_WEIGHTS)
        if self.period is not None:
            check.number(self.period, "period", above=0.0)


@dataclass(frozen=True, eq=False)
class Rhythm(Archived, Generic[SettingsT, StateT]):
    """A learned rhythm; its attributes are documented where they are public."""

    model: SettingsT
    springs: Springs
    period: float
    events: tuple[Event, ...]
    posture: Posture | None = field(default=None, kw_only=True)

    supports: ClassVar[frozenset[str]] = frozenset({"start", "goal", "duration"})

    def _rolled(
        self, state: StateT, duration: float | None, dt: float
    ) -> tuple[Float64Array, Float64Array, Float64Array]:
        """Times (n,), values and slopes (n, channels) from a state on; by default one period."""
        step = check.number(dt, "dt", above=0.0)
        total = check_duration(duration, state.duration)
        if not total / state.duration <= _MOST_PERIODS:
            raise InvalidInput(
                f"period: expected at most {_MOST_PERIODS} periods in {total:.6g} s, "
                f"got a period of {state.duration:.6g} s; check the units"
            )
        times = even_times(total, step)
        values, slopes = _core.dmp_rollout(
            self.springs.forces, state.course, state.value, state.slope, times / state.duration
        )
        return times, values, slopes

    def _advanced(
        self, state: StateT, dt: float, *, goal: ArrayLike | None, coupling: ArrayLike | None
    ) -> StateT:
        """The state dt s later; arguments and errors are those of the public `step`."""
        span = check_step(dt, 0.0, state.duration)
        if goal is not None:
            state = self._redirected(state, goal)
        if coupling is None:
            return state.coast(self.springs.forces, span)
        return state.pushed(self.springs.forces, span, self._acceleration(coupling))

    def _events(self, times: Float64Array, period: float) -> Events:
        """Its events in every period of a motion at times (n,), s."""
        happening = events.every_round(self.events, float(times[-1]) / period)
        return events.moved(happening, times / period, times)

    def _joints(self, times: Float64Array, period: float) -> JointTrajectory | None:
        """The arm's joints in every period of a motion at times (n,), s, if they were shown."""
        return None if self.posture is None else self.posture.every_round(times, times / period)

    def _settings(self) -> dict[str, Any]:
        """Its plain values, for a file."""
        return {
            "model": asdict(self.model),
            "period": self.period,
            "events": events.to_plain(self.events),
            **settings_of(self.posture),
        }

    def _arrays(self) -> Arrays:
        """Its arrays beside those of the orientation, for a file."""
        return {**self.springs.arrays(), **arrays_of(self.posture)}

    @abstractmethod
    def _redirected(self, state: StateT, goal: ArrayLike) -> StateT:
        """The state on its way to another centre."""

    @abstractmethod
    def _acceleration(self, coupling: ArrayLike) -> Float64Array:
        """A coupling as an acceleration (channels,)."""


def cycle_ends(learned: Ends, start: Place | None, centre: Place | None, amplitude: float) -> Ends:
    """Start and centre that a query asks for; left out, the start lies on the cycle."""
    asked = ends_of(learned, start=start, goal=centre)
    on_cycle: Float64Array = asked.goal + amplitude * (learned.start - learned.goal)
    first = on_cycle if start is None else asked.start
    return replace(asked, start=first, start_slope=amplitude * learned.start_slope)


def check_cycle(usual: float, period: float | None, amplitude: float) -> tuple[float, float]:
    """The period, s, and the amplitude of a query."""
    return (
        check_duration(period, usual, "period"),
        check.number(amplitude, "amplitude", at_least=0.0),
    )


def refuse_obstacles(obstacles: Sequence[Shape]) -> None:
    """Refuses obstacles, which rhythms do not keep clear of."""
    if check_shapes(obstacles):
        raise UnsupportedQuery("obstacles: a rhythm keeps clear of none; use step with a coupling")


def take_settings(
    settings: dict[str, Any], arrays: Arrays
) -> tuple[Springs, float, Events, Posture | None]:
    """Springs, period, events and posture of a rhythm in a file."""
    period = check.number(settings["period"], "period", above=0.0)
    learned = Springs.from_arrays(RHYTHMIC, settings["model"]["weights"], arrays)
    happening = events.from_plain(settings.get("events", ()))
    return learned, period, happening, Posture.from_archive(settings, arrays)

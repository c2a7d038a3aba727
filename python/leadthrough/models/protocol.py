"""What every fitted skill offers, and what some can do beyond it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

from numpy.typing import ArrayLike

from leadthrough.check import Float64Array
from leadthrough.io.atomic import StrPath
from leadthrough.models.certificate import Certificate
from leadthrough.models.demonstrated import Demonstrations
from leadthrough.models.parameters import Parameter
from leadthrough.models.place import Place
from leadthrough.motion import Motion, MotionT_co
from leadthrough.shapes import Shape

if TYPE_CHECKING:
    from leadthrough.models.chart import Chart

__all__ = [
    "Conditioned",
    "Distributed",
    "Generator",
    "Guided",
    "Limited",
    "Mapped",
    "Model",
    "Place",
    "Previewed",
    "Relearned",
    "Skill",
    "State",
    "Stepped",
]


class Model(Protocol):
    """The settings of a kind of skill: a frozen dataclass of plain values."""

    def fit(self, demonstrations: Demonstrations[Motion]) -> Skill:
        """A skill from demonstrations."""


class Generator(Protocol[MotionT_co]):
    """What answers queries with motions."""

    def generate(
        self,
        *,
        start: Place | None = None,
        goal: Place | None = None,
        duration: float | None = None,
        dt: float = 0.01,
        obstacles: Sequence[Shape] = (),
    ) -> MotionT_co:
        """A motion of the type that was shown; what is left out is taken from the demonstrations.

        Args:
            start: where it starts.
            goal: where it ends; of a rhythm, its centre.
            duration: s, > 0.
            dt: s, > 0, upper bound of the sampling step.
            obstacles: shapes to keep clear of, in the demonstrations' frame.

        Raises:
            InvalidInput: if an argument is wrong.
            UnsupportedQuery: for a part that it does not support.
            NoPath: where obstacles leave no way.
        """


class Skill(Generator[MotionT_co], Protocol[MotionT_co]):
    """A fitted model: frozen, safe to share between threads.

    What it generates is of the type of motion that was shown: a `Skill[JointTrajectory]` generates
    joint trajectories.
    """

    @property
    def model(self) -> Model:
        """The settings that it was fitted with, all of them."""

    @property
    def supports(self) -> frozenset[str]:
        """Parts of a query that it honours.

        Of "start", "goal", "duration" and "obstacles"; of a `Stepped` skill also of "via",
        "start_velocity" and "final_velocity", and of a `Limited` one of "limits".
        """

    @property
    def kind(self) -> str:
        """The name of this kind of skill in files."""

    @property
    def certificate(self) -> Certificate | None:
        """What a validation found of it; None if it was not validated, or changed since."""

    def certified(self, certificate: Certificate | None) -> Skill[MotionT_co]:
        """The same skill with a certificate, which its file keeps too.

        Args:
            certificate: of a validation; None takes away what there is.
        """

    def parameters(
        self, demonstrations: Demonstrations[Motion] = ()
    ) -> Sequence[Parameter[MotionT_co]]:
        """The few numbers of its model that a person may drag.

        Args:
            demonstrations: those that it was fitted to; without them there are only the parameters
                that need no new fit.
        """

    def save(self, path: StrPath) -> None:
        """Writes the skill to a .npz file that `load_skill` reads.

        Raises:
            InvalidInput: if the file cannot be written.
        """

    def to_archive(self) -> tuple[dict[str, Any], Mapping[str, Any]]:
        """Settings and arrays, for a file."""


@runtime_checkable
class Distributed(Protocol):
    """A skill that knows how its demonstrations spread about the mean motion."""

    @property
    def chart(self) -> Chart:
        """What its columns are."""

    @property
    def duration(self) -> float:
        """Of the motion, s."""

    def distribution(self, times: ArrayLike) -> tuple[Float64Array, Float64Array]:
        """Mean (n, d) and covariance (n, d, d) of the columns at times (n,), s."""


@runtime_checkable
class State(Protocol):
    """Where a motion is that goes on step by step; poses also have .orientation and its rate."""

    @property
    def phase(self) -> float:
        """From 0 at the start on; 1 is the end."""

    @property
    def position(self) -> Float64Array:
        """Of shape (d,)."""

    @property
    def velocity(self) -> Float64Array:
        """Of shape (d,), per second."""


@runtime_checkable
class Stepped(Protocol):
    """A skill whose motions pass via points, and go on step by step in a control loop."""

    def begin(
        self,
        *,
        start: Place | None = None,
        goal: Place | None = None,
        duration: float | None = None,
        via: Sequence[tuple[float, ArrayLike]] = (),
        start_velocity: ArrayLike | None = None,
        final_velocity: ArrayLike | None = None,
    ) -> Any:
        """The state at the start, for `step`."""

    def step(
        self,
        state: Any,
        dt: float,
        *,
        goal: Place | None = None,
        coupling: ArrayLike | None = None,
        lag: float = 0.0,
        measured: Place | None = None,
        obstacles: Sequence[Shape] = (),
    ) -> Any:
        """The state dt s later."""

    def generate(
        self,
        *,
        start: Place | None = None,
        goal: Place | None = None,
        duration: float | None = None,
        dt: float = 0.01,
        obstacles: Sequence[Shape] = (),
        via: Sequence[tuple[float, ArrayLike]] = (),
        start_velocity: ArrayLike | None = None,
        final_velocity: ArrayLike | None = None,
    ) -> Motion:
        """A motion, as by any skill, through via points and with velocities at its ends."""


class Limited(Stepped, Protocol):
    """A skill whose motions can be kept inside limits (lower (d,), upper (d,))."""

    def step(
        self,
        state: Any,
        dt: float,
        *,
        goal: Place | None = None,
        coupling: ArrayLike | None = None,
        lag: float = 0.0,
        measured: Place | None = None,
        obstacles: Sequence[Shape] = (),
        limits: tuple[ArrayLike, ArrayLike] = ...,
    ) -> Any:
        """The state dt s later, inside the limits."""

    def generate(
        self,
        *,
        start: Place | None = None,
        goal: Place | None = None,
        duration: float | None = None,
        dt: float = 0.01,
        obstacles: Sequence[Shape] = (),
        via: Sequence[tuple[float, ArrayLike]] = (),
        start_velocity: ArrayLike | None = None,
        final_velocity: ArrayLike | None = None,
        limits: tuple[ArrayLike, ArrayLike] = ...,
    ) -> Motion:
        """A motion, as by any stepped skill, inside the limits."""


@runtime_checkable
class Guided(Protocol):
    """A skill that leads a tool from wherever it is."""

    def policy(self, position: ArrayLike) -> Float64Array:
        """The velocity (d,) that leads from a position (d,) to the goal."""


@runtime_checkable
class Mapped(Protocol):
    """A skill that plans in a map of speeds, around whatever is closed in it."""

    def map_with(self, obstacles: Sequence[Shape]) -> Float64Array:
        """The map of speeds with obstacles in it."""


@runtime_checkable
class Previewed(Protocol):
    """A skill with quick, coarse answers for a goal and obstacles that are dragged."""

    def preview(self) -> Generator:
        """What gives them; it keeps from one answer to the next what helps the next one."""


@runtime_checkable
class Conditioned(Protocol):
    """A skill that can be conditioned on passing a place at a time."""

    @property
    def duration(self) -> float:
        """Of the motion, s."""

    def condition(
        self, time: ArrayLike, position: Place, *, covariance: ArrayLike | None = None
    ) -> Skill:
        """The skill that passes a position at a time, s."""


@runtime_checkable
class Relearned(Protocol):
    """A skill of one motion, which can be learned anew from a mean of it and of others."""

    def replay(self, samples: int) -> Motion:
        """Its own motion, evenly sampled."""

    def relearned(self, motion: Motion) -> Skill:
        """The skill of another motion of the same type, learned with the same settings."""

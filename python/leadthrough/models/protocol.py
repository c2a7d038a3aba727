"""Models and skills: the methods of all, those of some, and the parameters a person may drag."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import (
    TYPE_CHECKING,
    Any,
    Generic,
    Literal,
    NoReturn,
    Protocol,
    TypeAlias,
    get_args,
    runtime_checkable,
)

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check, sanity
from leadthrough.check import MAX_NUMBER, FitError, Float64Array, InvalidInput, NotFitted, ShortRepr
from leadthrough.io.files import StrPath
from leadthrough.models.certificate import Certificate
from leadthrough.models.contradictions import at_one_turn, contradictions
from leadthrough.motion import (
    Demonstration,
    JointTrajectory,
    Motion,
    MotionT,
    MotionT_co,
    PoseTrajectory,
    Target,
    Trajectory,
    alike,
)
from leadthrough.preprocess.align import lateness
from leadthrough.shapes import Shape

if TYPE_CHECKING:
    from leadthrough.models.coordinates import Coordinates

# Argument of every `fit`: demonstrations, or the motions alone.
Demonstrations: TypeAlias = Sequence[Demonstration[MotionT] | MotionT]

# Treatment of a demonstration that contradicts all others.
Outliers: TypeAlias = Literal["refuse", "drop", "keep"]

KINDS = (Trajectory, PoseTrajectory, JointTrajectory)
# Demonstrations that are late by this fraction of the latest one are named.
_NAMED = 0.6
# Names of skills that are asked of models by mistake.
_OF_SKILLS = frozenset(
    {
        "begin", "condition", "distribution", "duration", "generate", "plan", "plot", "policy",
        "preview", "sample", "save", "step", "supports",
    }
)  # fmt: skip


class Model(Protocol):
    """The settings of a kind of skill: a frozen dataclass of plain values."""

    def fit(self, demonstrations: Demonstrations[Motion]) -> Skill:
        """A skill from demonstrations."""


class Generator(Protocol[MotionT_co]):
    """An object that answers queries with motions."""

    def generate(
        self,
        *,
        start: Target | None = None,
        goal: Target | None = None,
        duration: float | None = None,
        dt: float = 0.01,
        obstacles: Sequence[Shape] = (),
    ) -> MotionT_co:
        """A motion of the demonstrated type, as by `FittedSkill.generate`."""


class Skill(Generator[MotionT_co], Protocol[MotionT_co]):
    """A fitted model: frozen, safe to share between threads.

    A `Skill[JointTrajectory]` generates joint trajectories, as it was demonstrated.
    """

    @property
    def model(self) -> Model:
        """The settings that it was fitted with, all of them."""

    @property
    def supports(self) -> frozenset[str]:
        """Parts of a query that it honours.

        Of "start", "goal", "duration" and "obstacles"; of a `SteppedSkill` also of "via",
        "start_velocity", "final_velocity" and "limits".
        """

    @property
    def kind(self) -> str:
        """The name of this kind of skill in files."""

    @property
    def certificate(self) -> Certificate | None:
        """The result of its validation; None before one, and after a change."""

    def certified(self, certificate: Certificate | None) -> Skill[MotionT_co]:
        """The same skill with a certificate, also saved in its file; None removes it."""

    def parameters(
        self, demonstrations: Demonstrations[Motion] = ()
    ) -> Sequence[Parameter[MotionT_co]]:
        """Adjustable parameters of its model, as `FittedSkill.parameters`."""

    def corrected(
        self,
        at: float | ArrayLike,
        position: Target,
        *,
        start: Target | None = None,
        goal: Target | None = None,
        duration: float | None = None,
        obstacles: Sequence[Shape] = (),
        mode: int | None = None,
    ) -> Corrected[MotionT_co]:
        """A skill whose motion passes a position, as by `FittedSkill.corrected`."""

    def save(self, path: StrPath) -> None:
        """Writes the skill to a .npz file that `load_skill` reads."""

    def to_archive(self) -> tuple[dict[str, Any], Mapping[str, Any]]:
        """Settings and arrays, for a file."""


class Corrected(Skill[MotionT_co], Protocol[MotionT_co]):
    """A skill of which points of the motion were moved."""

    def undone(self) -> Corrected[MotionT_co]:
        """The skill without the last correction."""


@runtime_checkable
class Distributed(Protocol):
    """A skill that knows how its demonstrations spread about the mean motion."""

    @property
    def coordinates(self) -> Coordinates:
        """Coordinates of its columns."""

    @property
    def duration(self) -> float:
        """Of the motion, s."""

    def distribution(self, times: ArrayLike) -> tuple[Float64Array, Float64Array]:
        """Mean (n, d) and covariance (n, d, d) of the columns at times (n,), s."""


@runtime_checkable
class Guided(Protocol):
    """A skill that leads a tool to the goal from any position."""

    def policy(self, position: ArrayLike) -> Float64Array:
        """The velocity (d,) that leads from a position (d,) to the goal; likewise of rows."""


@runtime_checkable
class Mapped(Protocol):
    """A skill that plans in a map of speeds, around its closed cells."""

    def map_with(self, obstacles: Sequence[Shape]) -> Float64Array:
        """The map of speeds with obstacles in it."""


@runtime_checkable
class Previewed(Protocol):
    """A skill with quick, coarse answers for a goal and obstacles that are dragged."""

    def preview(self) -> Generator:
        """The generator of these answers, which reuses parts of the one before."""


@runtime_checkable
class Conditioned(Protocol):
    """A skill that can be conditioned on passing a position or pose at a time."""

    @property
    def duration(self) -> float:
        """Of the motion, s."""

    def condition(
        self, time: ArrayLike, position: Target, *, covariance: ArrayLike | None = None
    ) -> Skill:
        """The skill that passes a position at a time, s."""


@runtime_checkable
class Relearned(Protocol):
    """A skill of one motion, which can be learned anew from a mean of it and of others."""

    def replay(self, samples: int) -> Motion:
        """Its own motion, evenly sampled."""

    def relearned(self, motion: Motion) -> Skill:
        """The skill of another motion of the same type, learned with the same settings."""


@dataclass(frozen=True, eq=False)
class Parameter(ShortRepr, Generic[MotionT_co]):
    """A number of a skill's model that may be changed.

    Attributes:
        label: its name, with the unit where it has one.
        value: the present value.
        lower: the least value worth trying.
        upper: the largest value worth trying.
        step: the smallest change worth making.
        apply: takes another value and returns the skill with it; the skill itself stays as it is.
    """

    label: str
    value: float
    lower: float
    upper: float
    step: float
    apply: Callable[[float], Skill[MotionT_co]]


@dataclass(frozen=True)
class Choice:
    """The families that were compared, and what left-out demonstrations told.

    Attributes:
        chosen: name of the family that was chosen.
        errors: for each family its mean distance from left-out demonstrations along the motion, as
            a fraction of the extent; infinite for one that cannot learn or reproduce them.
        left_out: number of demonstrations that were left out, one at a time.
    """

    chosen: str
    errors: dict[str, float]
    left_out: int

    def __str__(self) -> str:
        if not self.left_out:
            return f"{self.chosen}: the default, as a single demonstration cannot be left out"
        nearest = self.errors[self.chosen] == min(self.errors.values())
        why = "nearest" if nearest else "no other is twice as near"
        return f"{self.chosen}: {why} to {self.left_out} left-out demonstrations ({self.table})"

    @property
    def table(self) -> str:
        """The families and their errors in %, the best first; none of a single demonstration."""
        ranked = sorted(self.errors.items(), key=lambda each: each[1])
        return ", ".join(f"{name} {error:.2%}" for name, error in ranked) if self.left_out else ""


class Unfitted:
    """Base of models: `generate` raises NotFitted, with the call of `fit` that comes first."""

    if not TYPE_CHECKING:  # type checkers shall refuse it

        def __getattr__(self, name: str) -> NoReturn:
            kind = type(self).__name__
            if name in _OF_SKILLS:
                raise NotFitted(
                    f"{name}: {kind} holds the settings of a model; fit it first: "
                    f"skill = {kind}().fit(demonstrations), then skill.{name}"
                )
            raise AttributeError(f"{kind!r} object has no attribute {name!r}")


class MisalignmentWarning(UserWarning):
    """Demonstrations are misaligned in time: the message names them and the remedy."""


def check_skill(skill: object) -> None:
    """Refuses what is no skill, such as its class; a model refuses by itself."""
    if not callable(getattr(skill, "generate", None)) or isinstance(skill, type):
        raise check.refused("skill", "a skill, as `fit` returns", type(skill).__name__)


def motions_of(
    demonstrations: Demonstrations[MotionT],
    *,
    kinds: tuple[type[Motion], ...] = KINDS,
    at_least: int = 1,
    outliers: Outliers = "keep",
) -> list[MotionT]:
    """The motions of demonstrations, all of one type and size, each of which moves."""
    check.choice(outliers, "outliers", get_args(Outliers))
    if not isinstance(demonstrations, Sequence):
        raise InvalidInput(
            "demonstrations: expected a sequence of demonstrations, got one "
            f"{type(demonstrations).__name__}; put a single one in a list"
        )
    if len(demonstrations) < at_least:
        raise FitError(
            f"demonstrations: expected at least {at_least}, got {len(demonstrations) or 'none'}"
        )
    motions: list[Any] = [_motion(each, i, kinds) for i, each in enumerate(demonstrations)]
    _refuse_mixed(motions)
    motions = alike(motions, "demonstrations")
    for i, motion in enumerate(motions):
        _refuse_unfit(motion, f"demonstrations[{i}]")
        sanity.clock(motion.times, f"demonstrations[{i}]")
    motions = at_one_turn(motions)
    return motions if outliers == "keep" else _agreeing(motions, outliers)


def contradicting(motions: Sequence[Motion]) -> dict[int, str]:
    """The motions that contradict all others, by their index, and why they do."""
    return {each.index: each.text for each in contradictions(motions)}


def _agreeing(motions: list[Any], outliers: Outliers) -> list[Any]:
    """The motions without those that contradict all others, which are refused or dropped."""
    found = contradicting(motions)
    if found and outliers == "refuse":
        texts = (f"demonstrations[{i}]: {text}" for i, text in found.items())
        raise FitError(
            f"{'; '.join(texts)}; leave out, or set outliers to 'drop', or to 'keep' if meant"
        )
    return [each for i, each in enumerate(motions) if i not in found]


def fit_all(model: Model, demonstrations: Demonstrations[Motion]) -> Skill:
    """A skill of all demonstrations, of those that contradict the others too."""
    if isinstance(model, Unfitted):  # one of ours
        ours: Any = model
        skill: Skill = ours.fit(demonstrations, outliers="keep")
        return skill
    return model.fit(demonstrations)


def _motion(demonstration: object, index: int, kinds: tuple[type[Motion], ...]) -> object:
    motion = demonstration.motion if isinstance(demonstration, Demonstration) else demonstration
    if not isinstance(motion, kinds):
        names = " or ".join(kind.__name__ for kind in kinds)
        convertible = isinstance(motion, JointTrajectory) and PoseTrajectory in kinds
        advice = "; arm.poses(motion) makes poses of joints" if convertible else ""
        raise InvalidInput(
            f"demonstrations[{index}]: expected a Demonstration of a {names}, "
            f"got {type(motion).__name__}{advice}"
        )
    return motion


def _refuse_mixed(motions: Sequence[Motion]) -> None:
    for what, values in (
        ("one type of motion", {type(motion).__name__ for motion in motions}),
        ("the same number of columns", {motion.positions.shape[1] for motion in motions}),
    ):
        if len(values) > 1:
            got = " and ".join(str(value) for value in sorted(values))
            raise InvalidInput(f"demonstrations: expected {what} in all, got {got}")


def _refuse_unfit(motion: Motion, name: str) -> None:
    if len(motion.times) < 2:
        raise FitError(f"{name}: has a single sample, needs at least two; leave it out")
    turns = isinstance(motion, PoseTrajectory) and not _is_still(motion.orientations)
    if _is_still(motion.positions) and not turns:
        raise FitError(f"{name}: does not move; leave it out")
    if isinstance(motion, JointTrajectory) and sanity.whole_turns(motion.positions).any():
        raise FitError(
            f"{name}: a joint leaps by a whole turn between samples; name its arm by --robot; in "
            "Python, arm.joints_of makes it continuous"
        )
    if np.abs(motion.positions).max() > MAX_NUMBER:
        raise FitError(f"{name}: has numbers beyond {MAX_NUMBER:.0e}; use another unit")
    if not turns and _extent_is_below(motion.positions, 1.0 / MAX_NUMBER):
        raise FitError(f"{name}: moves by less than {1.0 / MAX_NUMBER:.0e}; use another unit")


def _extent_is_below(rows: Float64Array, least: float) -> bool:
    if np.abs(rows[-1] - rows[0]).max() >= least:
        return False  # quick answer for most motions
    return bool(np.ptp(rows, axis=0).max() < least)


def _is_still(rows: Float64Array) -> bool:
    return bool((rows == rows[0]).all())


def warn_of_misalignment(motions: Sequence[Motion]) -> None:
    """Warns of demonstrations with the same path at different times, which a mean blurs."""
    late = lateness(motions)
    if not late.any():
        return
    named = [i for i, each in enumerate(late) if each >= _NAMED * late.max()]
    sanity.warn(
        f"demonstrations {named}: misaligned, up to {late.max():.0%} of the duration ahead of or "
        "behind the mean timing of all, so that the fit blurs them; align them with "
        "preprocess.align_by_time_warping, or leave them out",
        MisalignmentWarning,
    )

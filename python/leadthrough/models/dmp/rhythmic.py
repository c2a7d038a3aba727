"""Rhythmic movement primitives: motions that go round, of points, of joints and of poses.

Source: Ijspeert et al. 2013, section 2.1: the force is made of von Mises kernels of a phase that
turns, and the springs pull to the centre of the motion.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, Generic, cast

import numpy as np

from leadthrough import _core, check, events
from leadthrough.errors import InvalidInput, UnsupportedQuery
from leadthrough.models import archive
from leadthrough.models.dmp import springs
from leadthrough.models.dmp.cycle import mean_round
from leadthrough.models.dmp.kernels import MOST_WEIGHTS
from leadthrough.models.dmp.pose import as_pose, as_push
from leadthrough.models.dmp.query import check_channels, check_duration, check_step, ends_of
from leadthrough.models.dmp.refit import weights_of
from leadthrough.models.dmp.regression import fit_rhythm
from leadthrough.models.dmp.springs import RHYTHMIC, Ends, Springs
from leadthrough.models.dmp.turning import Turning, learn_closed
from leadthrough.models.even_times import even_times
from leadthrough.models.parameters import Parameter
from leadthrough.motion import (
    JointTrajectory,
    Motion,
    MotionT,
    MotionT_co,
    PoseTrajectory,
    Trajectory,
)
from leadthrough.shapes import check_shapes

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike

    from leadthrough.check import Float64Array
    from leadthrough.events import Event, Events
    from leadthrough.io.atomic import StrPath
    from leadthrough.models.demonstrated import Demonstrations
    from leadthrough.models.place import Place
    from leadthrough.shapes import Shape

_MOST_ROUNDS = 10_000  # in one query; more are a slip of a unit


@dataclass(frozen=True)
class RhythmicDMP:
    """Rhythmic primitives of points in any number of dimensions, or of joints.

    weights: kernels a channel, 3 to 1000. period: s, > 0, of the demonstrated motion; left out,
    each demonstration is one round.
    """

    weights: int = 25
    period: float | None = None

    def __post_init__(self) -> None:
        check.integer(self.weights, "weights", at_least=3, at_most=MOST_WEIGHTS)
        if self.period is not None:
            check.number(self.period, "period", above=0.0)

    def fit(self, demonstrations: Demonstrations[MotionT]) -> RhythmicDMPSkill[MotionT]:
        """A skill from demonstrations; all whole rounds in them are averaged.

        Raises InvalidInput for other motions, FitError for one that does not move or is shorter
        than a period.
        """
        shown = mean_round(demonstrations, (Trajectory, JointTrajectory), self.period)
        learned = fit_rhythm(shown.phases, shown.positions, weights=self.weights)
        return RhythmicDMPSkill(self, learned, shown.duration, shown.joint_names, shown.events)


@dataclass(frozen=True, eq=False)
class RhythmicDMPSkill(Generic[MotionT_co]):
    """A learned rhythm; made by `RhythmicDMP.fit`.

    model: its parameters. springs: what was learned. period: s, as demonstrated. joint_names: None
    where points were shown. events: at shares of the period, in every round.
    """

    model: RhythmicDMP
    springs: Springs
    period: float
    joint_names: tuple[str, ...] | None
    events: tuple[Event, ...] = ()

    kind: ClassVar[str] = "rhythmic_dmp"
    supports: ClassVar[frozenset[str]] = frozenset({"start", "goal", "duration"})

    def generate(
        self,
        *,
        start: Place | None = None,
        goal: Place | None = None,
        duration: float | None = None,
        dt: float = 0.01,
        obstacles: Sequence[Shape] = (),
        period: float | None = None,
        amplitude: float = 1.0,
    ) -> MotionT_co:
        """A Trajectory, or a JointTrajectory where joints were shown.

        start: (d,), by default on the round; from elsewhere the motion swings in. goal: (d,), its
        centre, by default as demonstrated. duration: s, > 0, by default one period. dt: s, upper
        bound of the sampling step. period: s, > 0, by default as demonstrated. amplitude: >= 0,
        multiplies the distance from the centre. Raises InvalidInput, UnsupportedQuery.
        """
        step = check.number(dt, "dt", above=0.0)
        _refuse(obstacles)
        state = self.begin(start=start, goal=goal, period=period, amplitude=amplitude)
        times = _times(duration, state.duration, step)
        positions, slopes = _core.dmp_rollout(
            self.springs.forces, state.course, state.value, state.slope, times / state.duration
        )
        made = self._motion(times, positions, slopes / state.duration, state.duration)
        return cast(MotionT_co, made)  # joints where joints were shown

    def begin(
        self,
        *,
        start: Place | None = None,
        goal: Place | None = None,
        period: float | None = None,
        amplitude: float = 1.0,
    ) -> _core.PointState:
        """The state at phase 0, for `step`; arguments as in `generate`. Raises InvalidInput."""
        total = check_duration(period, self.period, "period")
        scale = check.number(amplitude, "amplitude", at_least=0.0)
        ends = _around(self.springs.ends, start, goal, scale)
        course = springs.course(RHYTHMIC, ends, amplitude=scale)
        return _core.PointState(course, ends.start, ends.start_slope, 0.0, total)

    def step(
        self,
        state: _core.PointState,
        dt: float,
        *,
        goal: ArrayLike | None = None,
        coupling: ArrayLike | None = None,
    ) -> _core.PointState:
        """The state dt s later; its phase counts the rounds.

        goal: (d,), moves the centre. coupling: (d,), acceleration that acts meanwhile.
        Raises InvalidInput.
        """
        span = check_step(dt, 0.0, state.duration)
        if goal is not None:
            centre = check_channels(goal, "goal", len(self.springs.ends.goal))
            course = springs.redirected(RHYTHMIC, state.course, centre)
            state = _core.PointState(course, state.value, state.slope, state.phase, state.duration)
        if coupling is None:
            return state.coast(self.springs.forces, span)
        push = check_channels(coupling, "coupling", len(self.springs.ends.goal))
        return state.pushed(self.springs.forces, span, push)

    def parameters(
        self, demonstrations: Demonstrations[Motion] = ()
    ) -> Sequence[Parameter[MotionT_co]]:
        """Its number of weights, where there are demonstrations to fit again."""
        return weights_of(self, demonstrations)

    def save(self, path: StrPath) -> None:
        """Writes the skill to a .npz file that `load_skill` reads. Raises InvalidInput."""
        archive.write(path, self.kind, *self.to_archive())

    def to_archive(self) -> tuple[dict[str, Any], archive.Arrays]:
        """Settings and arrays that `from_archive` puts together again."""
        names = None if self.joint_names is None else list(self.joint_names)
        settings = {
            "model": asdict(self.model),
            "period": self.period,
            "joint_names": names,
            "events": events.to_plain(self.events),
        }
        return settings, self.springs.arrays()

    @classmethod
    def from_archive(cls, settings: dict[str, Any], arrays: archive.Arrays) -> RhythmicDMPSkill:
        """The skill that `save` took apart. Raises KeyError, TypeError, ValueError."""
        names, model = settings["joint_names"], RhythmicDMP(**settings["model"])
        period = check.number(settings["period"], "period", above=0.0)
        learned = Springs.from_arrays(RHYTHMIC, model.weights, arrays)
        happening = events.from_plain(settings.get("events", ()))
        return cls(model, learned, period, None if names is None else tuple(names), happening)

    def _motion(
        self, times: Float64Array, positions: Float64Array, velocities: Float64Array, period: float
    ) -> Trajectory | JointTrajectory:
        happening = _in_every_round(self.events, times, period)
        if self.joint_names is None:
            return Trajectory(times, positions, happening)
        return JointTrajectory(times, positions, velocities, None, self.joint_names, happening)


@dataclass(frozen=True)
class RhythmicPoseDMP:
    """Rhythmic primitives of poses. weights, period: as in `RhythmicDMP`.

    The orientation is anchored, as in `PoseDMP`, on a curve that closes: the tool may come back to
    its orientation, or turn about whole turns in a round.
    """

    weights: int = 25
    period: float | None = None

    def __post_init__(self) -> None:
        RhythmicDMP(self.weights, self.period)  # checks

    def fit(self, demonstrations: Demonstrations[Motion]) -> RhythmicPoseDMPSkill:
        """A skill from demonstrations of poses; all whole rounds in them are averaged.

        Raises InvalidInput for other motions, FitError as `RhythmicDMP.fit`.
        """
        shown = mean_round(demonstrations, (PoseTrajectory,), self.period)
        assert shown.orientations is not None
        turned, coordinates = learn_closed(shown.phases, shown.orientations)
        values = np.hstack([shown.positions, coordinates])
        learned = fit_rhythm(shown.phases, values, weights=self.weights)
        first = turned.orientations(np.zeros(1), learned.ends.start[None, 3:].copy())[0]
        turned = replace(turned, start=first, goal=first)
        return RhythmicPoseDMPSkill(self, learned, turned, shown.duration, shown.events)


@dataclass(frozen=True, eq=False)
class RhythmicPoseDMPSkill:
    """A learned rhythm of poses; made by `RhythmicPoseDMP.fit`.

    Parts as in `PoseDMPSkill` and `RhythmicDMPSkill`.
    """

    model: RhythmicPoseDMP
    springs: Springs
    turning: Turning
    period: float
    events: tuple[Event, ...] = ()

    kind: ClassVar[str] = "rhythmic_pose_dmp"
    supports: ClassVar[frozenset[str]] = frozenset({"start", "goal", "duration"})

    def generate(
        self,
        *,
        start: Place | None = None,
        goal: Place | None = None,
        duration: float | None = None,
        dt: float = 0.01,
        obstacles: Sequence[Shape] = (),
        period: float | None = None,
        amplitude: float = 1.0,
    ) -> PoseTrajectory:
        """A motion that goes round; arguments as in `RhythmicDMPSkill.generate`.

        start, goal: a position (3,), or (position (3,), orientation (4,)). The orientation of the
        goal is the one in which a round begins; start's is turned into it during the first round.
        amplitude: of the positions. Raises InvalidInput, UnsupportedQuery.
        """
        step = check.number(dt, "dt", above=0.0)
        _refuse(obstacles)
        state = self.begin(start=start, goal=goal, period=period, amplitude=amplitude)
        times = _times(duration, state.duration, step)
        phases = times / state.duration
        values, _ = _core.dmp_rollout(
            self.springs.forces, state.course, state.value, state.slope, phases
        )
        offsets = state.start_offset, state.goal_offset
        turned = self.turning.orientations(phases, values, offsets)
        happening = _in_every_round(self.events, times, state.duration)
        return PoseTrajectory(times, values[:, :3], turned, happening)

    def begin(
        self,
        *,
        start: Place | None = None,
        goal: Place | None = None,
        period: float | None = None,
        amplitude: float = 1.0,
    ) -> _core.PoseState:
        """The state at phase 0, for `step`; arguments as in `generate`. Raises InvalidInput."""
        total = check_duration(period, self.period, "period")
        scale = check.number(amplitude, "amplitude", at_least=0.0)
        first, first_turned = as_pose(start, "start")
        centre, centre_turned = as_pose(goal, "goal")
        ends = _around(self.springs.ends.part(slice(3)), first, centre, scale).joined(
            self.springs.ends.part(slice(3, 6))
        )
        turned = self.turning.goal if centre_turned is None else centre_turned
        offsets = self.turning.offsets(turned if first_turned is None else first_turned, turned)
        gain = np.repeat([scale, 1.0], 3)
        plain = springs.course(RHYTHMIC, ends)
        course = _core.DmpCourse(plain.breaks, plain.coefficients, gain, plain.drive)
        return _core.PoseState(
            course, ends.start, ends.start_slope, 0.0, total, self.turning.curve, *offsets
        )

    def step(
        self,
        state: _core.PoseState,
        dt: float,
        *,
        goal: ArrayLike | None = None,
        coupling: ArrayLike | None = None,
    ) -> _core.PoseState:
        """The state dt s later; its phase counts the rounds.

        goal: (3,), moves the centre. coupling: (3,) or (6,) acceleration, as in
        `PoseDMPSkill.step`. Raises InvalidInput.
        """
        span = check_step(dt, 0.0, state.duration)
        if goal is not None:
            centre = np.append(check_channels(goal, "goal", 3), self.springs.ends.goal[3:])
            state = _core.PoseState(
                springs.redirected(RHYTHMIC, state.course, centre),
                *(state.value, state.slope, state.phase, state.duration),
                *(state.curve, state.start_offset, state.goal_offset),
            )
        if coupling is None:
            return state.coast(self.springs.forces, span)
        return state.pushed(self.springs.forces, span, as_push(coupling))

    def parameters(
        self, demonstrations: Demonstrations[Motion] = ()
    ) -> Sequence[Parameter[PoseTrajectory]]:
        """Its number of weights, where there are demonstrations to fit again."""
        return weights_of(self, demonstrations)

    def save(self, path: StrPath) -> None:
        """Writes the skill to a .npz file that `load_skill` reads. Raises InvalidInput."""
        archive.write(path, self.kind, *self.to_archive())

    def to_archive(self) -> tuple[dict[str, Any], archive.Arrays]:
        """Settings and arrays that `from_archive` puts together again."""
        settings = {
            "model": asdict(self.model),
            "period": self.period,
            "events": events.to_plain(self.events),
        }
        arrays = {**self.springs.arrays(), **self.turning.arrays()}
        return settings, arrays

    @classmethod
    def from_archive(cls, settings: dict[str, Any], arrays: archive.Arrays) -> RhythmicPoseDMPSkill:
        """The skill that `save` took apart. Raises KeyError, TypeError, ValueError."""
        model = RhythmicPoseDMP(**settings["model"])
        period = check.number(settings["period"], "period", above=0.0)
        learned = Springs.from_arrays(RHYTHMIC, model.weights, arrays)
        turned = Turning.from_arrays("anchored", arrays, rhythmic=True)
        return cls(model, learned, turned, period, events.from_plain(settings.get("events", ())))


def _around(learned: Ends, start: Any, goal: Any, amplitude: float) -> Ends:
    """Start and centre asked for; left out, the start lies on the round about the centre."""
    asked = ends_of(
        learned, start=start, goal=goal, start_velocity=None, final_velocity=None, duration=1.0
    )
    on_round: Float64Array = asked.goal + amplitude * (learned.start - learned.goal)
    first = on_round if start is None else asked.start
    return replace(asked, start=first, start_slope=amplitude * learned.start_slope)


def _times(duration: float | None, period: float, dt: float) -> Float64Array:
    total = check_duration(duration, period)
    if not total / period <= _MOST_ROUNDS:
        raise InvalidInput(
            f"period: expected at most {_MOST_ROUNDS} rounds in {total:.6g} s, got {period:.6g} s"
        )
    return even_times(total, dt)


def _in_every_round(shares: Events, times: Float64Array, period: float) -> Events:
    happening = events.every_round(shares, float(times[-1]) / period)
    return events.moved(happening, times / period, times)


def _refuse(obstacles: Sequence[Shape]) -> None:
    if check_shapes(obstacles):
        raise UnsupportedQuery("obstacles: a rhythm knows none; use step with a coupling")

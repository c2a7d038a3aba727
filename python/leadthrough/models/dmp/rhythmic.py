"""Rhythmic movement primitives of points, joints and poses.

The force is made of von Mises kernels of a phase that counts periods, and the springs pull to the
centre of the motion. The orientation of poses is anchored on a curve that closes: the tool may
come back to its orientation, or rotate by whole turns in a period.
Source: Ijspeert et al. 2013, section 2.1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, ClassVar, cast

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput, UnsupportedQuery
from leadthrough.models.archive import Arrays
from leadthrough.models.dmp import transformation
from leadthrough.models.dmp.learning import Primitive, learn_rhythm, take_parts
from leadthrough.models.dmp.query import (
    as_pose,
    check_channels,
    check_state,
    check_step,
    moved_ends,
    pose_acceleration,
)
from leadthrough.models.dmp.transformation import MAX_WEIGHTS, RHYTHMIC, Ends
from leadthrough.models.protocol import Demonstrations, Outliers, Unfitted, motions_of
from leadthrough.models.queries import CheckedQuery, checked_query, even_times
from leadthrough.motion import (
    Event,
    Events,
    JointTrajectory,
    MotionT,
    MotionT_co,
    PoseTrajectory,
    Target,
    Trajectory,
    moved_events,
    with_derivatives,
)
from leadthrough.shapes import Shape

_MAX_PERIODS = 10_000  # in one query; more come from a wrong unit


@dataclass(frozen=True)
class RhythmicDMP(Unfitted):
    """Rhythmic primitives of points in any number of dimensions, of joints, or of poses.

    Attributes:
        weights: number of kernels per channel, 3 to 1000.
        period: s, > 0, of the demonstrated motion; None: each demonstration is one period.
    """

    weights: int = 25
    period: float | None = None

    slider: ClassVar[tuple[str, int, int]] = ("weights", 5, 100)

    def __post_init__(self) -> None:
        check.integer(self.weights, "weights", at_least=3, at_most=MAX_WEIGHTS)
        if self.period is not None:
            check.number(self.period, "period", above=0.0)

    def fit(
        self, demonstrations: Demonstrations[MotionT], *, outliers: Outliers = "refuse"
    ) -> RhythmicDMPSkill[MotionT]:
        """A skill from demonstrations; all whole periods in them are averaged.

        Args:
            demonstrations: all of points, all of joints or all of poses.
            outliers: without a period, treatment of one that contradicts all others, as for
                `learn`: "refuse", "drop", "keep". With a period none is compared.

        Raises:
            FitError: for one that does not move, contradicts all others or is shorter than a
                period.
        """
        kept: Outliers = outliers if self.period is None else "keep"
        motions = motions_of(demonstrations, outliers=kept)
        mean, parts = learn_rhythm(motions, self.weights, self.period)
        return RhythmicDMPSkill(model=self, period=mean.duration, **parts)


@dataclass(frozen=True, eq=False, kw_only=True)
class RhythmicDMPSkill(Primitive[MotionT_co]):
    """A learned rhythm; made by `RhythmicDMP.fit`.

    Attributes:
        model: the settings that it was fitted with.
        system: the learned transformation system; of poses with three channels of the position
            and three of the orientation.
        period: s, as demonstrated.
        events: at fractions of the period, 0 to 1, in every period.
        joint_names: of joints; None for points and poses.
        orientation: coordinates of the orientation; None for points and joints.
        posture: the arm's joints at fractions of the period, if demonstrated beside the motion.
    """

    model: RhythmicDMP
    period: float

    kind: ClassVar[str] = "rhythmic_dmp"
    supports: ClassVar[frozenset[str]] = frozenset({"start", "goal", "duration"})

    @checked_query
    def generate(  # type: ignore[override]  # one mode
        self,
        *,
        start: Target | None = None,
        goal: Target | None = None,
        duration: float | None = None,
        dt: float = 0.01,
        obstacles: Sequence[Shape] = (),
        period: float | None = None,
        amplitude: float = 1.0,
    ) -> MotionT_co:
        """A motion of the demonstrated type that repeats.

        Args:
            start: (d,), or of poses a position (3,) or (position (3,), orientation (4,)), by
                default on the cycle; from elsewhere the motion swings in, and the orientation joins
                the cycle's during the first period.
            goal: as start: the centre of the positions, and the orientation at which a period
                begins, by default as demonstrated.
            duration: s, > 0, by default one period.
            dt: s, > 0, upper bound of the sampling step.
            obstacles: expected none; rhythmic DMPs do not avoid obstacles.
            period: s, > 0, by default as demonstrated.
            amplitude: >= 0, multiplies the positions' distance from the centre.

        Raises:
            UnsupportedQuery: for obstacles.
        """
        query = CheckedQuery(start, goal, duration, dt, obstacles)
        if query.obstacles:
            raise UnsupportedQuery(
                "obstacles: rhythmic DMPs do not avoid obstacles; in Python, pass a coupling term "
                "to step()"
            )
        return self._answer(query, period, amplitude)

    def _answer(
        self, query: CheckedQuery, period: float | None = None, amplitude: float = 1.0
    ) -> MotionT_co:
        state = self.begin(start=query.start, goal=query.goal, period=period, amplitude=amplitude)
        total = query.end(state.duration)
        if not total / state.duration <= _MAX_PERIODS:
            raise InvalidInput(
                f"period: expected at most {_MAX_PERIODS} periods in {total:.6g} s, "
                f"got a period of {state.duration:.6g} s; check the units"
            )
        return cast(MotionT_co, self._motion(state, even_times(total, query.dt)))

    def begin(
        self,
        *,
        start: Target | None = None,
        goal: Target | None = None,
        period: float | None = None,
        amplitude: float = 1.0,
    ) -> Any:
        """The state at phase 0, for `step`; arguments and errors as in `generate`."""
        total = self.period if period is None else check.number(period, "period", above=0.0)
        scale = check.number(amplitude, "amplitude", at_least=0.0)
        learned, known = self.system.ends, self.orientation
        if known is None:
            ends = _cycle_ends(learned, start, goal, scale)
            course = transformation.course(RHYTHMIC, ends, amplitude=scale)
            return core.PointState(course, ends.start, ends.start_slope, 0.0, total)
        first, first_q = as_pose(start, "start")
        centre, centre_q = as_pose(goal, "goal")
        position = _cycle_ends(learned.part(slice(3)), first, centre, scale)
        ends = position.joined(learned.part(slice(3, 6)))
        course = transformation.scaled_by(
            transformation.course(RHYTHMIC, ends), slice(3), np.full(3, scale)
        )
        q = known.goal if centre_q is None else centre_q
        offsets = known.offsets(q if first_q is None else first_q, q)
        offset = core.DmpPath(np.array([0.0, 1.0]), transformation.between(*offsets))
        return core.PoseState(course, ends.start, ends.start_slope, 0.0, total, known.curve, offset)

    def step(
        self,
        state: Any,
        dt: float,
        *,
        goal: ArrayLike | None = None,
        coupling: ArrayLike | None = None,
    ) -> Any:
        """The state dt s later; its phase counts the periods.

        Args:
            state: from `begin` or the last step.
            dt: s, > 0.
            goal: (d,), of poses (3,), moves the centre.
            coupling: as in `DMPSkill.step`.
        """
        check_state(state)
        span = check_step(dt, 0.0, state.duration)
        if goal is not None:
            state = self._redirected(state, goal)
        if coupling is None:
            return state.coast(self.system.forces, span)
        push = (
            check_channels(coupling, "coupling", len(self.system.ends.goal))
            if self.orientation is None
            else pose_acceleration(coupling)
        )
        return state.pushed(self.system.forces, span, push)

    def to_archive(self) -> tuple[dict[str, Any], Arrays]:
        settings, arrays = super().to_archive()
        return {"model": asdict(self.model), "period": self.period, **settings}, arrays

    def _motion(
        self, state: Any, times: Float64Array
    ) -> Trajectory | PoseTrajectory | JointTrajectory:
        """The motion from a state on, at times (n,), with the events of every period."""
        phases = times / state.duration
        values, slopes = core.dmp_rollout(
            self.system.forces, state.course, state.value, state.slope, phases
        )
        rounds = events_of_rounds(self.events, float(times[-1]) / state.duration)
        happening = moved_events(rounds, phases, times)
        joints = None if self.posture is None else self.posture.every_round(times, phases)
        if self.orientation is not None:
            q = self.orientation.orientations(phases, values, state.offset)
            return PoseTrajectory(times, values[:, :3], q, happening, joints)
        if self.joint_names is None:
            return Trajectory(times, values, happening, joints)
        velocities = slopes / state.duration
        return with_derivatives(
            JointTrajectory(times, values, velocities, None, self.joint_names, happening)
        )

    def _redirected(self, state: Any, goal: ArrayLike) -> Any:
        """The state on its way to another centre."""
        if self.orientation is None:
            centre = check_channels(goal, "goal", len(self.system.ends.goal))
            course = transformation.redirected(RHYTHMIC, state.course, centre)
            return core.PointState(course, state.value, state.slope, state.phase, state.duration)
        centre = np.append(check_channels(goal, "goal", 3), self.system.ends.goal[3:])
        return core.PoseState(
            transformation.redirected(RHYTHMIC, state.course, centre),
            *(state.value, state.slope, state.phase, state.duration),
            *(state.curve, state.offset),
        )


def from_archive(settings: dict[str, Any], arrays: Arrays) -> RhythmicDMPSkill:
    model = RhythmicDMP(**settings["model"])
    period = check.number(settings["period"], "period", above=0.0)
    parts = take_parts(
        settings, arrays, form=RHYTHMIC, weights=model.weights, representation="anchored"
    )
    return RhythmicDMPSkill(model=model, period=period, **parts)


def _cycle_ends(
    learned: Ends, start: Target | None, centre: Target | None, amplitude: float
) -> Ends:
    """Start and centre that a query asks for; left out, the start lies on the cycle."""
    asked = moved_ends(learned, start, centre)
    on_cycle: Float64Array = asked.goal + amplitude * (learned.start - learned.goal)
    first = on_cycle if start is None else asked.start
    return replace(asked, start=first, start_slope=amplitude * learned.start_slope)


def events_of_rounds(events: Events, rounds: float) -> Events:
    """The events of one round, repeated in every round; a round lasts 1."""
    return tuple(
        Event(event.time + k, event.name)
        for k in range(int(np.ceil(rounds)))
        for event in events
        if event.time + k <= rounds
    )

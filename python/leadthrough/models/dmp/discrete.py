"""Movement primitives of points and of joints.

Sources: Ijspeert et al. 2013, "Dynamical movement primitives", Neural Computation 25; Hoffmann et
al. 2009, "Biologically-inspired dynamical systems for movement generation". The equations of the
forms stand in `springs`, those of the fits in `regression`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, ClassVar, Generic, cast

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import _core, check, events
from leadthrough.check import Float64Array
from leadthrough.errors import UnsupportedQuery
from leadthrough.events import Event
from leadthrough.io.atomic import StrPath
from leadthrough.models import archive
from leadthrough.models.demonstrated import Demonstrations
from leadthrough.models.dmp import springs
from leadthrough.models.dmp.coupling import Around, check_around, roll, step_around
from leadthrough.models.dmp.kernels import MOST_WEIGHTS, enough_weights
from leadthrough.models.dmp.mean_motion import mean_motion
from leadthrough.models.dmp.query import (
    check_channels,
    check_duration,
    check_step,
    course_through,
    ends_of,
)
from leadthrough.models.dmp.refit import weights_of
from leadthrough.models.dmp.regression import REGRESSIONS, fit
from leadthrough.models.dmp.springs import FORMS, Springs
from leadthrough.models.even_times import even_phases
from leadthrough.models.parameters import Parameter
from leadthrough.models.place import Place
from leadthrough.motion import JointTrajectory, Motion, MotionT, MotionT_co, Trajectory, computed
from leadthrough.shapes import Shape


@dataclass(frozen=True)
class DMP:
    """Dynamic movement primitives of points in any number of dimensions, or of joints.

    weights: kernels a channel, 2 to 1000; None: 4 a second and at least 50, as long motions with
    much to them need. form: "blended", which meets start, goal and velocities exactly; "hoffmann"
    (Hoffmann et al. 2009, Pastor et al. 2009), whose force is not scaled by the goal either;
    "ijspeert" (Ijspeert et al. 2002, 2013), whose force is. At the end of a motion the last two
    are only near a new goal: "hoffmann" lacks 2.5 % of what start and goal were moved by (0.03 %
    after half as long again, in `step`), "ijspeert" its error in replay, scaled.
    regression: "replay" minimises the error of the replayed motion; "ridge" and "lwr" fit the force
    that finite differences ask for, together or kernel by kernel.
    """

    weights: int | None = 50
    form: str = "blended"
    regression: str = "replay"

    def __post_init__(self) -> None:
        if self.weights is not None:
            check.integer(self.weights, "weights", at_least=2, at_most=MOST_WEIGHTS)
        check.choice(self.form, "form", FORMS)
        check.choice(self.regression, "regression", REGRESSIONS)

    def fit(self, demonstrations: Demonstrations[MotionT]) -> DMPSkill[MotionT]:
        """A skill from demonstrations, all of points or all of joints.

        Several are averaged over normalised time first. Raises InvalidInput for other motions,
        FitError for one that does not move, and with the form "ijspeert" for one that ends where it
        began.
        """
        shown = mean_motion(demonstrations, (Trajectory, JointTrajectory))
        count = self.weights or enough_weights(shown.duration)
        learned = fit(
            shown.phases,
            shown.positions,
            weights=count,
            form=self.form,
            regression=self.regression,
        )
        model = replace(self, weights=count)
        return DMPSkill(model, learned, shown.duration, shown.size, shown.joint_names, shown.events)


@dataclass(frozen=True, eq=False)
class DMPSkill(Generic[MotionT_co]):
    """A learned primitive; made by `DMP.fit`.

    model: its parameters. springs: what was learned. duration: s, as demonstrated. size: diagonal
    of the box around the demonstration. joint_names: None where points were shown. events: at
    shares of the duration.
    """

    model: DMP
    springs: Springs
    duration: float
    size: float
    joint_names: tuple[str, ...] | None
    events: tuple[Event, ...] = ()

    kind: ClassVar[str] = "dmp"

    @property
    def supports(self) -> frozenset[str]:
        """What a query may ask for; obstacles only in two or three dimensions."""
        known = {"start", "goal", "duration"}
        return frozenset(known if self._dimensions is None else {*known, "obstacles"})

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
        limits: tuple[ArrayLike, ArrayLike] | None = None,
    ) -> MotionT_co:
        """A Trajectory, or a JointTrajectory where joints were shown.

        start, goal: (d,), by default as demonstrated. duration: s, > 0, by default the
        demonstrations'. dt: s, upper bound of the sampling step; the motion does not depend on it.
        via: (share of the duration inside (0, 1), point (d,)), in order. start_velocity,
        final_velocity: (d,) a second, by default as demonstrated at that duration.
        final_velocity has no meaning but with the form "blended". obstacles: in the demonstrations'
        frame; drawings of two dimensions lie in the plane z = 0. limits: (lower (d,), upper (d,)),
        which the motion does not leave.
        Raises InvalidInput, UnsupportedQuery; NoPath where steering does not clear the obstacles.
        """
        step = check.number(dt, "dt", above=0.0)
        around = self._around(obstacles, limits)
        state = self.begin(
            start=start,
            goal=goal,
            duration=duration,
            via=via,
            start_velocity=start_velocity,
            final_velocity=final_velocity,
        )
        phases = even_phases(state.duration, step)
        positions, slopes = roll(self.springs, state, phases, around=around, size=self.size)
        made = self._motion(state.duration, phases, positions, slopes)
        return cast(MotionT_co, made)  # joints where joints were shown

    def begin(
        self,
        *,
        start: Place | None = None,
        goal: Place | None = None,
        duration: float | None = None,
        via: Sequence[tuple[float, ArrayLike]] = (),
        start_velocity: ArrayLike | None = None,
        final_velocity: ArrayLike | None = None,
    ) -> _core.PointState:
        """The state at the start, for `step`; arguments as in `generate`. Raises InvalidInput."""
        if final_velocity is not None and self.model.form != "blended":
            raise UnsupportedQuery(f"final_velocity: the form {self.model.form!r} ends at rest")
        total = check_duration(duration, self.duration)
        ends = ends_of(
            self.springs.ends,
            start=start,
            goal=goal,
            start_velocity=start_velocity,
            final_velocity=final_velocity,
            duration=total,
        )
        course = course_through(self.springs, ends, via, count=len(ends.start))
        return _core.PointState(course, ends.start, ends.start_slope, 0.0, total)

    def step(
        self,
        state: _core.PointState,
        dt: float,
        *,
        goal: ArrayLike | None = None,
        coupling: ArrayLike | None = None,
        lag: float = 0.0,
        measured: ArrayLike | None = None,
        obstacles: Sequence[Shape] = (),
        limits: tuple[ArrayLike, ArrayLike] | None = None,
    ) -> _core.PointState:
        """The state dt s later: .position, .velocity (d,), .phase; exact for any dt > 0.

        state: from `begin` or the last step. goal: (d,), moves the goal. coupling: (d,), an
        acceleration, unit per s^2, that acts meanwhile. measured: (d,), where the motion goes on
        from instead of the state's position. lag: >= 0; in this step the motion, phase and springs
        alike, runs 1 / (1 + lag) as fast, as with a larger tau. For phase stopping, take a gain
        times the squared distance between the arm and the state: while the arm is held, the motion
        waits; once it follows, the motion goes on as fast as before. (An arm that always trails
        behind slows it always: the gain must make little of its usual error.) obstacles, limits: as
        in `generate`, of this step. Raises InvalidInput.
        """
        changed = goal is not None or measured is not None or coupling is not None
        around_nothing = limits is None and not obstacles
        if not changed and around_nothing and type(dt) is float and lag == 0.0:
            # The quick way: control loops ask a thousand times a second.
            after = state.tick(self.springs.forces, dt)
            if after is not None:
                return after
        span = check_step(dt, lag, state.duration)
        if goal is not None:
            state = self._redirected(state, goal)
        if measured is not None:
            state = self._moved(state, measured)
        if coupling is None and around_nothing:
            return state.coast(self.springs.forces, span)
        push = np.zeros(len(state.value))
        if coupling is not None:
            push = check_channels(coupling, "coupling", len(push))
        around = self._around(obstacles, limits)
        return step_around(self.springs, state, span, push, around=around, size=self.size)

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
            **asdict(self.model),
            "duration": self.duration,
            "joint_names": names,
            "size": self.size,
            "events": events.to_plain(self.events),
        }
        return settings, self.springs.arrays()

    @classmethod
    def from_archive(cls, settings: dict[str, Any], arrays: archive.Arrays) -> DMPSkill:
        """The skill that `save` took apart. Raises KeyError, TypeError, ValueError."""
        names = settings.pop("joint_names")
        duration = check.number(settings.pop("duration"), "duration", above=0.0)
        size = check.number(settings.pop("size"), "size", at_least=0.0)
        happening = events.from_plain(settings.pop("events", ()))
        model = DMP(**settings)
        learned = Springs.from_arrays(model.form, settings["weights"], arrays)
        joints = None if names is None else tuple(names)
        return cls(model, learned, duration, size, joints, happening)

    def _motion(
        self, duration: float, phases: Float64Array, positions: Float64Array, slopes: Float64Array
    ) -> Trajectory | JointTrajectory:
        times = duration * phases
        happening = events.moved(self.events, (0.0, 1.0), (0.0, duration))
        if self.joint_names is None:
            return computed(Trajectory, times=times, positions=positions, events=happening)
        velocities = slopes / duration
        return JointTrajectory(times, positions, velocities, None, self.joint_names, happening)

    @property
    def _dimensions(self) -> int | None:
        """Of the space that the motion runs in, if there may be obstacles."""
        count = len(self.springs.ends.start)
        return count if self.joint_names is None and count in (2, 3) else None

    def _around(self, obstacles: Sequence[Shape], limits: Any) -> Around:
        count = len(self.springs.ends.start)
        return check_around(obstacles, limits, dimensions=self._dimensions, channels=count)

    def _redirected(self, state: _core.PointState, goal: Any) -> _core.PointState:
        wanted = check_channels(goal, "goal", len(self.springs.ends.goal))
        course = springs.redirected(self.model.form, state.course, wanted)
        return _core.PointState(course, state.value, state.slope, state.phase, state.duration)

    def _moved(self, state: _core.PointState, measured: Any) -> _core.PointState:
        value = check_channels(measured, "measured", len(self.springs.ends.goal))
        return _core.PointState(state.course, value, state.slope, state.phase, state.duration)

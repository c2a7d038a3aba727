"""Movement primitives of points and of joints.

The equations of the forms stand in `springs`, those of the fits in `regression`. Sources: Ijspeert
et al. 2013, "Dynamical movement primitives", Neural Computation 25; Hoffmann et al. 2009,
"Biologically-inspired dynamical systems for movement generation".
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, Generic, cast

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import _core, check
from leadthrough.check import Float64Array
from leadthrough.models import archive
from leadthrough.models.demonstrated import Demonstrations
from leadthrough.models.dmp.constraints import Constraints, check_constraints
from leadthrough.models.dmp.kernels import MOST_WEIGHTS, enough_weights
from leadthrough.models.dmp.mean_motion import mean_motion
from leadthrough.models.dmp.pace import JOINTS, MOVING, Part
from leadthrough.models.dmp.primitive import Primitive, take_settings
from leadthrough.models.dmp.progress import Progress, progress_of, speeds_of
from leadthrough.models.dmp.query import (
    Via,
    check_channels,
    check_final_velocity,
    ends_of,
)
from leadthrough.models.dmp.refit import weights_of
from leadthrough.models.dmp.regression import REGRESSIONS, fit
from leadthrough.models.dmp.springs import FORMS, Springs
from leadthrough.models.judged import judged
from leadthrough.models.parameters import Parameter
from leadthrough.models.place import Place
from leadthrough.models.unfitted import Unfitted
from leadthrough.motion import JointTrajectory, Motion, MotionT, MotionT_co, Trajectory, computed
from leadthrough.shapes import Shape


@dataclass(frozen=True)
class DMP(Unfitted):
    """Dynamic movement primitives of points in any number of dimensions, or of joints.

    Attributes:
        weights: number of kernels per channel, 2 to 1000; None: 4 per second and at least 50, as
            long motions with many details need.
        form: "blended", which meets start, goal and velocities exactly; "hoffmann" (Hoffmann et al.
            2009, Pastor et al. 2009), whose force is not scaled by the goal either; "ijspeert"
            (Ijspeert et al. 2002, 2013), whose force is. At the end of a motion the last two are
            only near a new goal: "hoffmann" lacks 2.5 % of what start and goal were moved by
            (0.03 % after half as long again, in `step`), "ijspeert" its error in replay, scaled.
        regression: "replay" minimises the error of the replayed motion; "ridge" and "lwr" fit the
            force that finite differences ask for, all kernels together or each by itself.

    Raises:
        InvalidInput: if a setting is outside its range.
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
        """A skill from demonstrations; several are averaged over normalised time first.

        Args:
            demonstrations: all of points or all of joints.

        Raises:
            InvalidInput: for other motions.
            FitError: for one that does not move, and with the form "ijspeert" for one that ends
                where it began.
        """
        mean = mean_motion(demonstrations, (Trajectory, JointTrajectory))
        count = self.weights or enough_weights(mean.duration)
        learned = fit(
            mean.phases,
            mean.positions,
            weights=count,
            form=self.form,
            regression=self.regression,
        )
        model = replace(self, weights=count)
        known = (mean.duration, mean.size, mean.events, mean.joint_names)
        return DMPSkill(model, learned, *known, posture=mean.posture)


@dataclass(frozen=True, eq=False)
class DMPSkill(Primitive[DMP, _core.PointState], Generic[MotionT_co]):
    """A learned primitive; made by `DMP.fit`.

    Attributes:
        model: the settings that it was fitted with, with the number of weights that was found.
        springs: what was learned.
        duration: s, as demonstrated.
        size: diagonal of the box around the demonstration.
        events: at fractions of the duration, 0 to 1.
        joint_names: None where points were shown.
        posture: the arm's joints at fractions of the duration, where they were shown beside points.
    """

    joint_names: tuple[str, ...] | None

    kind: ClassVar[str] = "dmp"

    @property
    def supports(self) -> frozenset[str]:
        """What a query may ask for; obstacles only in two or three dimensions."""
        return self._supported(obstacles=self._dimensions is not None) | {"limits"}

    @judged
    def generate(
        self,
        *,
        start: Place | None = None,
        goal: Place | None = None,
        duration: float | None = None,
        dt: float = 0.01,
        obstacles: Sequence[Shape] = (),
        via: Via = (),
        start_velocity: ArrayLike | None = None,
        final_velocity: ArrayLike | None = None,
        limits: tuple[ArrayLike, ArrayLike] | None = None,
    ) -> MotionT_co:
        """A Trajectory, or a JointTrajectory where joints were shown.

        Args:
            start: (d,), by default as demonstrated.
            goal: (d,), by default as demonstrated.
            duration: s, > 0, by default `default_duration`: the demonstrations', or longer where a
                moved start or goal would make the motion more than 1.3 times as fast.
            dt: s, > 0, upper bound of the sampling step; the motion does not depend on it.
            obstacles: in the demonstrations' frame; a drawing of two dimensions lies in the plane
                z = 0.
            via: (fraction of the duration in (0, 1), point (d,)), in order.
            start_velocity: (d,) per second, by default as demonstrated, at that duration.
            final_velocity: as start_velocity; only with the form "blended".
            limits: (lower (d,), upper (d,)), which the motion does not leave.

        Raises:
            InvalidInput: if an argument is of another shape or range.
            UnsupportedQuery: for obstacles in a space that has none, and for a final velocity with
                another form.
            NoPath: where steering does not clear the obstacles.
        """
        step = check.number(dt, "dt", above=0.0)
        constraints = self._constraints(obstacles, limits)
        state = self.begin(
            start=start,
            goal=goal,
            duration=duration,
            via=via,
            start_velocity=start_velocity,
            final_velocity=final_velocity,
        )
        phases, positions, slopes = self._rolled(state, step, constraints)
        made = self._motion(state.duration, phases, positions, slopes)
        return cast(MotionT_co, made)  # joints where joints were shown

    def begin(
        self,
        *,
        start: Place | None = None,
        goal: Place | None = None,
        duration: float | None = None,
        via: Via = (),
        start_velocity: ArrayLike | None = None,
        final_velocity: ArrayLike | None = None,
    ) -> _core.PointState:
        """The state at the start, for `step`; arguments and errors as in `generate`."""
        check_final_velocity(final_velocity, self.model.form)
        total = self._duration(duration, start, goal)
        ends = ends_of(
            self.springs.ends,
            start=start,
            goal=goal,
            start_velocity=start_velocity,
            final_velocity=final_velocity,
            duration=total,
        )
        course = self._course(ends, via, count=len(ends.start))
        return _core.PointState(course, ends.start, ends.start_slope, 0.0, total)

    def step(
        self,
        state: _core.PointState,
        dt: float,
        *,
        goal: Place | None = None,
        coupling: ArrayLike | None = None,
        lag: float = 0.0,
        measured: Place | None = None,
        obstacles: Sequence[Shape] = (),
        limits: tuple[ArrayLike, ArrayLike] | None = None,
    ) -> _core.PointState:
        """The state dt s later: .position, .velocity (d,), .phase; exact for any dt.

        Args:
            state: from `begin` or the last step.
            dt: s, > 0.
            goal: (d,), moves the goal.
            coupling: (d,), an acceleration, unit per s^2, that acts during the step.
            lag: >= 0; in this step the motion, phase and springs alike, runs 1 / (1 + lag) as fast,
                as with a larger tau. For phase stopping, take a gain times the squared distance
                between the arm and the state: while the arm is held, the motion waits; once it
                follows, the motion goes on as fast as before. (An arm that always trails behind
                slows it always: the gain must make little of its usual error.)
            measured: (d,), where the motion goes on from instead of the state's position.
            obstacles: as in `generate`, of this step.
            limits: as in `generate`, of this step.

        Raises:
            InvalidInput: if an argument is of another shape or range.
            UnsupportedQuery: for obstacles in a space that has none.
        """
        changed = goal is not None or measured is not None or coupling is not None
        if not (changed or obstacles or limits is not None) and type(dt) is float and lag == 0.0:
            # The quick way: control loops ask a thousand times a second.
            after = state.tick(self.springs.forces, dt)
            if after is not None:
                return after
        return self._advanced(
            state,
            dt,
            goal=goal,
            coupling=coupling,
            lag=lag,
            measured=measured,
            obstacles=obstacles,
            limits=limits,
        )

    def parameters(
        self, demonstrations: Demonstrations[Motion] = ()
    ) -> Sequence[Parameter[MotionT_co]]:
        """Its number of weights, where there are demonstrations to fit again.

        Args:
            demonstrations: those that it was fitted to.
        """
        return weights_of(self, demonstrations)

    def to_archive(self) -> tuple[dict[str, Any], archive.Arrays]:
        """Settings and arrays that `from_archive` puts together again."""
        names = None if self.joint_names is None else list(self.joint_names)
        settings = {**asdict(self.model), **self._settings(), "joint_names": names}
        return settings, self._arrays()

    @cached_property
    def progress(self) -> Progress:
        """How far each channel has come at each phase, in replay."""
        speeds = speeds_of(self._shown.velocities)
        return progress_of(np.repeat(speeds[:, None], len(self.springs.ends.start), axis=1))

    @cached_property
    def _shown(self) -> Part:
        values, slopes = self._replayed()
        extent = float(np.linalg.norm(values - values[0], axis=1).max())
        return Part(MOVING if self.joint_names is None else JOINTS, slopes, extent)

    def _lengthening(self, state: _core.PointState) -> float:
        _, slopes = self._looked_at(state)
        return self._shown.lengthening(self._shown.measure.peak(slopes), self.duration)

    def _motion(
        self, duration: float, phases: Float64Array, positions: Float64Array, slopes: Float64Array
    ) -> Trajectory | JointTrajectory:
        times, happening = duration * phases, self._events(duration)
        if self.joint_names is None:
            joints = self._joints(duration, phases)
            return computed(
                Trajectory, times=times, positions=positions, events=happening, joints=joints
            )
        velocities = slopes / duration
        return JointTrajectory(times, positions, velocities, None, self.joint_names, happening)

    @property
    def _dimensions(self) -> int | None:
        """Of the space that the motion runs in, if there may be obstacles."""
        count = len(self.springs.ends.start)
        return count if self.joint_names is None and count in (2, 3) else None

    def _constraints(
        self, obstacles: Sequence[Shape], limits: tuple[ArrayLike, ArrayLike] | None
    ) -> Constraints:
        count = len(self.springs.ends.start)
        return check_constraints(obstacles, limits, dimensions=self._dimensions, channels=count)

    def _acceleration(self, coupling: ArrayLike) -> Float64Array:
        return check_channels(coupling, "coupling", len(self.springs.ends.goal))

    def _redirected(self, state: _core.PointState, goal: Place) -> _core.PointState:
        wanted = check_channels(goal, "goal", len(self.springs.ends.goal))
        course = self._course_to(state, wanted)
        return _core.PointState(course, state.value, state.slope, state.phase, state.duration)

    def _moved(self, state: _core.PointState, measured: Place) -> _core.PointState:
        value = check_channels(measured, "measured", len(self.springs.ends.goal))
        return _core.PointState(state.course, value, state.slope, state.phase, state.duration)


def from_archive(settings: dict[str, Any], arrays: archive.Arrays) -> DMPSkill:
    """The skill that `DMPSkill.to_archive` took apart."""
    names = settings.pop("joint_names")
    duration, size, happening, posture = take_settings(settings, arrays)
    model = DMP(**settings)
    learned = Springs.from_arrays(model.form, settings["weights"], arrays)
    joints = None if names is None else tuple(names)
    return DMPSkill(model, learned, duration, size, happening, joints, posture=posture)

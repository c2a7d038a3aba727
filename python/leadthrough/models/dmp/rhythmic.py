"""Rhythmic movement primitives of points and of joints.

Source: Ijspeert et al. 2013, section 2.1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Generic, cast

from numpy.typing import ArrayLike

from leadthrough import _core
from leadthrough.check import Float64Array
from leadthrough.models import archive
from leadthrough.models.demonstrated import Demonstrations
from leadthrough.models.dmp import springs
from leadthrough.models.dmp.cycle import mean_cycle
from leadthrough.models.dmp.query import check_channels
from leadthrough.models.dmp.refit import weights_of
from leadthrough.models.dmp.regression import fit_rhythm
from leadthrough.models.dmp.rhythm import (
    Rhythm,
    Settings,
    check_cycle,
    cycle_ends,
    refuse_obstacles,
    take_settings,
)
from leadthrough.models.dmp.springs import RHYTHMIC
from leadthrough.models.judged import judged
from leadthrough.models.parameters import Parameter
from leadthrough.models.place import Place
from leadthrough.motion import JointTrajectory, Motion, MotionT, MotionT_co, Trajectory
from leadthrough.shapes import Shape


@dataclass(frozen=True)
class RhythmicDMP(Settings):
    """Rhythmic primitives of points in any number of dimensions, or of joints.

    Attributes:
        weights: number of kernels per channel, 3 to 1000.
        period: s, > 0, of the demonstrated motion; None: each demonstration is one period.

    Raises:
        InvalidInput: if a setting is outside its range.
    """

    def fit(self, demonstrations: Demonstrations[MotionT]) -> RhythmicDMPSkill[MotionT]:
        """A skill from demonstrations; all whole periods in them are averaged.

        Args:
            demonstrations: all of points or all of joints.

        Raises:
            InvalidInput: for other motions.
            FitError: for one that does not move or is shorter than a period.
        """
        mean = mean_cycle(demonstrations, (Trajectory, JointTrajectory), self.period)
        learned = fit_rhythm(mean.phases, mean.positions, weights=self.weights)
        known = (mean.duration, mean.events, mean.joint_names)
        return RhythmicDMPSkill(self, learned, *known, posture=mean.posture)


@dataclass(frozen=True, eq=False)
class RhythmicDMPSkill(Rhythm[RhythmicDMP, _core.PointState], Generic[MotionT_co]):
    """A learned rhythm; made by `RhythmicDMP.fit`.

    Attributes:
        model: the settings that it was fitted with.
        springs: what was learned.
        period: s, as demonstrated.
        events: at fractions of the period, 0 to 1, in every period.
        joint_names: None where points were shown.
        posture: the arm's joints at fractions of the period, where they were shown beside points.
    """

    joint_names: tuple[str, ...] | None

    kind: ClassVar[str] = "rhythmic_dmp"

    @judged
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

        Args:
            start: (d,), by default on the cycle; from elsewhere the motion swings in.
            goal: (d,), the centre of the motion, by default as demonstrated.
            duration: s, > 0, by default one period.
            dt: s, > 0, upper bound of the sampling step.
            obstacles: expected none; a rhythm keeps clear of none.
            period: s, > 0, by default as demonstrated.
            amplitude: >= 0, multiplies the distance from the centre.

        Raises:
            InvalidInput: if an argument is of another shape or range.
            UnsupportedQuery: for obstacles.
        """
        refuse_obstacles(obstacles)
        state = self.begin(start=start, goal=goal, period=period, amplitude=amplitude)
        times, positions, slopes = self._rolled(state, duration, dt)
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
        """The state at phase 0, for `step`; arguments and errors as in `generate`."""
        total, scale = check_cycle(self.period, period, amplitude)
        ends = cycle_ends(self.springs.ends, start, goal, scale)
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
        """The state dt s later; its phase counts the periods.

        Args:
            state: from `begin` or the last step.
            dt: s, > 0.
            goal: (d,), moves the centre.
            coupling: (d,), acceleration, unit per s^2, that acts during the step.

        Raises:
            InvalidInput: if an argument is of another shape or range.
        """
        return self._advanced(state, dt, goal=goal, coupling=coupling)

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
        return {**self._settings(), "joint_names": names}, self._arrays()

    def _motion(
        self, times: Float64Array, positions: Float64Array, velocities: Float64Array, period: float
    ) -> Trajectory | JointTrajectory:
        happening = self._events(times, period)
        if self.joint_names is None:
            return Trajectory(times, positions, happening, self._joints(times, period))
        return JointTrajectory(times, positions, velocities, None, self.joint_names, happening)

    def _redirected(self, state: _core.PointState, goal: ArrayLike) -> _core.PointState:
        centre = check_channels(goal, "goal", len(self.springs.ends.goal))
        course = springs.redirected(RHYTHMIC, state.course, centre)
        return _core.PointState(course, state.value, state.slope, state.phase, state.duration)

    def _acceleration(self, coupling: ArrayLike) -> Float64Array:
        return check_channels(coupling, "coupling", len(self.springs.ends.goal))


def from_archive(settings: dict[str, Any], arrays: archive.Arrays) -> RhythmicDMPSkill:
    """The skill that `RhythmicDMPSkill.to_archive` took apart."""
    learned, period, happening, posture = take_settings(settings, arrays)
    names, model = settings["joint_names"], RhythmicDMP(**settings["model"])
    joints = None if names is None else tuple(names)
    return RhythmicDMPSkill(model, learned, period, happening, joints, posture=posture)

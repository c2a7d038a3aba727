"""Rhythmic movement primitives of poses.

The orientation is anchored, as in `PoseDMP`, on a curve that closes: the tool may come back to its
orientation, or turn about whole turns in a period. Source: Ijspeert et al. 2013, section 2.1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import _core
from leadthrough.check import Float64Array
from leadthrough.models import archive
from leadthrough.models.demonstrated import Demonstrations
from leadthrough.models.dmp import springs
from leadthrough.models.dmp.cycle import mean_cycle
from leadthrough.models.dmp.query import as_pose, check_channels, pose_acceleration
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
from leadthrough.models.dmp.turning import Turning, learn_closed
from leadthrough.models.judged import judged
from leadthrough.models.parameters import Parameter
from leadthrough.models.place import Place
from leadthrough.motion import Motion, PoseTrajectory
from leadthrough.shapes import Shape


@dataclass(frozen=True)
class RhythmicPoseDMP(Settings):
    """Rhythmic primitives of poses.

    Attributes:
        weights: as in `RhythmicDMP`.
        period: as in `RhythmicDMP`.

    Raises:
        InvalidInput: if a setting is outside its range.
    """

    def fit(self, demonstrations: Demonstrations[Motion]) -> RhythmicPoseDMPSkill:
        """A skill from demonstrations of poses; all whole periods in them are averaged.

        Args:
            demonstrations: all of poses.

        Raises:
            InvalidInput: for other motions.
            FitError: for one that does not move or is shorter than a period.
        """
        mean = mean_cycle(demonstrations, (PoseTrajectory,), self.period)
        assert mean.orientations is not None
        turned, coordinates = learn_closed(mean.phases, mean.orientations)
        values = np.hstack([mean.positions, coordinates])
        learned = fit_rhythm(mean.phases, values, weights=self.weights)
        first = turned.orientations(np.zeros(1), learned.ends.start[None, 3:].copy())[0]
        turned = replace(turned, start=first, goal=first)
        known = (mean.duration, mean.events, turned)
        return RhythmicPoseDMPSkill(self, learned, *known, posture=mean.posture)


@dataclass(frozen=True, eq=False)
class RhythmicPoseDMPSkill(Rhythm[RhythmicPoseDMP, _core.PoseState]):
    """A learned rhythm of poses; made by `RhythmicPoseDMP.fit`.

    Attributes:
        model: the settings that it was fitted with.
        springs: of three coordinates of the position and three of the orientation.
        period: s, as demonstrated.
        events: at fractions of the period, 0 to 1, in every period.
        turning: what the coordinates of the orientation mean.
        posture: the arm's joints at fractions of the period, or None.
    """

    turning: Turning

    kind: ClassVar[str] = "rhythmic_pose_dmp"

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
    ) -> PoseTrajectory:
        """A motion that repeats.

        Args:
            start: a position (3,), or (position (3,), orientation (4,)), by default on the cycle;
                its orientation is turned into the cycle's during the first period.
            goal: as start: the centre of the positions, and the orientation at which a period
                begins, by default as demonstrated.
            duration: s, > 0, by default one period.
            dt: s, > 0, upper bound of the sampling step.
            obstacles: expected none; a rhythm keeps clear of none.
            period: s, > 0, by default as demonstrated.
            amplitude: >= 0, multiplies the positions' distance from the centre.

        Raises:
            InvalidInput: if an argument is of another shape or range.
            UnsupportedQuery: for obstacles.
        """
        refuse_obstacles(obstacles)
        state = self.begin(start=start, goal=goal, period=period, amplitude=amplitude)
        times, values, _ = self._rolled(state, duration, dt)
        turned = self.turning.orientations(times / state.duration, values, state.offset)
        happening = self._events(times, state.duration)
        joints = self._joints(times, state.duration)
        return PoseTrajectory(times, values[:, :3], turned, happening, joints)

    def begin(
        self,
        *,
        start: Place | None = None,
        goal: Place | None = None,
        period: float | None = None,
        amplitude: float = 1.0,
    ) -> _core.PoseState:
        """The state at phase 0, for `step`; arguments and errors as in `generate`."""
        total, scale = check_cycle(self.period, period, amplitude)
        first, first_turned = as_pose(start, "start")
        centre, centre_turned = as_pose(goal, "goal")
        learned = self.springs.ends
        ends = cycle_ends(learned.part(slice(3)), first, centre, scale).joined(
            learned.part(slice(3, 6))
        )
        turned = self.turning.goal if centre_turned is None else centre_turned
        offsets = self.turning.offsets(turned if first_turned is None else first_turned, turned)
        offset = _core.DmpPath(np.array([0.0, 1.0]), springs.between(*offsets))
        gain = np.repeat([scale, 1.0], 3)
        plain = springs.course(RHYTHMIC, ends)
        course = _core.DmpCourse(plain.breaks, plain.coefficients, gain, plain.drive)
        return _core.PoseState(
            course, ends.start, ends.start_slope, 0.0, total, self.turning.curve, offset
        )

    def step(
        self,
        state: _core.PoseState,
        dt: float,
        *,
        goal: ArrayLike | None = None,
        coupling: ArrayLike | None = None,
    ) -> _core.PoseState:
        """The state dt s later; its phase counts the periods.

        Args:
            state: from `begin` or the last step.
            dt: s, > 0.
            goal: (3,), moves the centre.
            coupling: (3,) or (6,) acceleration, as in `PoseDMPSkill.step`.

        Raises:
            InvalidInput: if an argument is of another shape or range.
        """
        return self._advanced(state, dt, goal=goal, coupling=coupling)

    def parameters(
        self, demonstrations: Demonstrations[Motion] = ()
    ) -> Sequence[Parameter[PoseTrajectory]]:
        """Its number of weights, where there are demonstrations to fit again.

        Args:
            demonstrations: those that it was fitted to.
        """
        return weights_of(self, demonstrations)

    def to_archive(self) -> tuple[dict[str, Any], archive.Arrays]:
        """Settings and arrays that `from_archive` puts together again."""
        return self._settings(), {**self._arrays(), **self.turning.arrays()}

    def _redirected(self, state: _core.PoseState, goal: ArrayLike) -> _core.PoseState:
        centre = np.append(check_channels(goal, "goal", 3), self.springs.ends.goal[3:])
        return _core.PoseState(
            springs.redirected(RHYTHMIC, state.course, centre),
            *(state.value, state.slope, state.phase, state.duration),
            *(state.curve, state.offset),
        )

    def _acceleration(self, coupling: ArrayLike) -> Float64Array:
        return pose_acceleration(coupling)


def from_archive(settings: dict[str, Any], arrays: archive.Arrays) -> RhythmicPoseDMPSkill:
    """The skill that `RhythmicPoseDMPSkill.to_archive` took apart."""
    learned, period, happening, posture = take_settings(settings, arrays)
    turned = Turning.from_arrays("anchored", arrays, rhythmic=True)
    model = RhythmicPoseDMP(**settings["model"])
    return RhythmicPoseDMPSkill(model, learned, period, happening, turned, posture=posture)

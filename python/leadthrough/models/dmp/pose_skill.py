"""A skill of movement primitives of poses: asked for motions, and stepped through them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import _core, check, rotations
from leadthrough.check import Float64Array
from leadthrough.models import archive
from leadthrough.models.demonstrated import Demonstrations
from leadthrough.models.dmp.constraints import Constraints, check_constraints
from leadthrough.models.dmp.pace import (
    COARSE_PHASES,
    MOVING,
    PHASES,
    TURNING,
    Part,
    pose_progress,
    spins_of,
)
from leadthrough.models.dmp.primitive import Primitive
from leadthrough.models.dmp.progress import Progress, corrected_until
from leadthrough.models.dmp.query import (
    Via,
    as_pose,
    check_channels,
    check_final_velocity,
    ends_of,
    pose_acceleration,
)
from leadthrough.models.dmp.refit import weights_of
from leadthrough.models.dmp.spin import refuse_spin
from leadthrough.models.dmp.springs import Ends, end_of, scaled_by
from leadthrough.models.dmp.turning import Turning
from leadthrough.models.even_times import even_phases
from leadthrough.models.judged import judged
from leadthrough.models.parameters import Parameter
from leadthrough.models.place import Place
from leadthrough.motion import Motion, PoseTrajectory, computed
from leadthrough.shapes import Shape

if TYPE_CHECKING:
    from leadthrough.models.dmp.pose import PoseDMP  # noqa: F401 (for the base class)

_NOTHING = np.zeros(3)
_SAME_TURN = 1e-12  # rad; a goal turned by less than this is the one before


@dataclass(frozen=True, eq=False)
class PoseDMPSkill(Primitive["PoseDMP", _core.PoseState]):
    """A learned primitive of poses; made by `PoseDMP.fit`.

    Attributes:
        model: the settings that it was fitted with, with the number of weights that was found.
        springs: of three coordinates of the position and three of the orientation.
        duration: s, as demonstrated.
        size: m, diagonal of the box around the demonstrated positions.
        events: at fractions of the duration, 0 to 1.
        turning: what the coordinates of the orientation mean.
        posture: the arm's joints at fractions of the duration, or None.
    """

    turning: Turning

    kind: ClassVar[str] = "pose_dmp"

    @property
    def supports(self) -> frozenset[str]:
        """What a query may ask for."""
        return self._supported(obstacles=True)

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
    ) -> PoseTrajectory:
        """A motion from pose to pose.

        Args:
            start: a position (3,), or (position (3,), orientation (4,)); what is left out is as
                demonstrated.
            goal: as start.
            duration: s, > 0, by default `default_duration`: the demonstrations', or longer where a
                moved start or goal would make the tool move or turn more than 1.3 times as fast.
            dt: s, > 0, upper bound of the sampling step; the motion does not depend on it.
            obstacles: in the demonstrations' frame; the position keeps clear of them, the
                orientation does not take them into account.
            via: (fraction of the duration in (0, 1), position (3,)), in order.
            start_velocity: (3,) m/s, by default as demonstrated, at that duration.
            final_velocity: as start_velocity; only with the form "blended".

        Raises:
            InvalidInput: if an argument is of another shape or range.
            NoPath: where steering does not clear the obstacles.
            UnsupportedQuery: where "lifted" would spin, and for a final velocity with another form.
        """
        step = check.number(dt, "dt", above=0.0)
        constraints = self._constraints(obstacles, None)
        state = self.begin(
            start=start,
            goal=goal,
            duration=duration,
            via=via,
            start_velocity=start_velocity,
            final_velocity=final_velocity,
        )
        phases, positions, orientations = self._posed(state, step, constraints)
        return computed(
            PoseTrajectory,
            times=state.duration * phases,
            positions=positions,
            orientations=orientations,
            events=self._events(state.duration),
            joints=self._joints(state.duration, phases),
        )

    def begin(
        self,
        *,
        start: Place | None = None,
        goal: Place | None = None,
        duration: float | None = None,
        via: Via = (),
        start_velocity: ArrayLike | None = None,
        final_velocity: ArrayLike | None = None,
    ) -> _core.PoseState:
        """The state at the start, for `step`; arguments and errors as in `generate`."""
        check_final_velocity(final_velocity, self.springs.form)
        if duration is None and start_velocity is None and final_velocity is None and via == ():
            return self._begin_at_own_pace(start, goal)
        total = self._duration(duration, start, goal)
        first, first_turned = as_pose(start, "start")
        last, last_turned = as_pose(goal, "goal")
        positions = ends_of(
            self.springs.ends.part(slice(3)),
            start=first,
            goal=last,
            start_velocity=start_velocity,
            final_velocity=final_velocity,
            duration=total,
        )
        turned, offset = self._turned_ends(first_turned, last_turned)
        if start_velocity is None and final_velocity is None:
            ends = self.springs.ends.moved(
                np.concatenate((positions.start, turned.start)),
                np.concatenate((positions.goal, turned.goal)),
            )
        else:
            ends = positions.joined(turned)
        course = self._course(ends, via, count=3)
        state = _core.PoseState(
            course, ends.start, ends.start_slope, 0.0, total, self.turning.curve, offset
        )
        as_demonstrated = first_turned is None and last_turned is None
        return state if as_demonstrated else self._without_spin(state)

    def _posed(
        self, state: _core.PoseState, dt: float, constraints: Constraints
    ) -> tuple[Float64Array, Float64Array, Float64Array]:
        """Phases (n,), positions (n, 3) and orientations (n, 4) from a state at the start on."""
        if constraints.are_none:
            phases = even_phases(state.duration, dt)
            return phases, *_core.dmp_poses(self.springs.forces, state, phases)
        phases, values, _ = self._rolled(state, dt, constraints)
        turned = self.turning.orientations(phases, values, state.offset)
        return phases, values[:, :3].copy(), turned

    def _begin_at_own_pace(self, start: Place | None, goal: Place | None) -> _core.PoseState:
        """The state of a motion that lasts as `default_duration` says, which needs this state."""
        if start is None and goal is None:
            return self._begin_as_shown()
        state = self.begin(start=start, goal=goal, duration=self.duration)
        if self.springs.form != "blended":
            return state
        total = self.duration * self._lengthening(state)
        return _core.PoseState(
            state.course, state.value, state.slope, state.phase, total, state.curve, state.offset
        )

    def _begin_as_shown(self) -> _core.PoseState:
        learned, curve = self.springs, self.turning.curve
        start, slope = learned.ends.start, learned.ends.start_slope
        return _core.PoseState(
            learned.shown_course, start, slope, 0.0, self.duration, curve, _core.DmpPath()
        )

    def step(
        self,
        state: _core.PoseState,
        dt: float,
        *,
        goal: Place | None = None,
        coupling: ArrayLike | None = None,
        lag: float = 0.0,
        measured: Place | None = None,
        obstacles: Sequence[Shape] = (),
    ) -> _core.PoseState:
        """The state dt s later; exact for any dt.

        Args:
            state: from `begin` or the last step.
            dt: s, > 0.
            goal: as in `generate`, moves the goal.
            coupling: (3,) acceleration, m/s^2, that acts during the step, or (6,) with an angular
                one, rad/s^2 in the base frame.
            lag: as in `DMPSkill.step`.
            measured: like goal; where the motion goes on from instead of the state's pose.
            obstacles: to keep clear of in this step.

        Returns:
            A state with .position, .velocity (3,), .orientation (4,), .angular_velocity (3,) rad/s
            in the base frame, .pose (7,), which is position and orientation in a row, and .phase.

        Raises:
            InvalidInput: if an argument is of another shape or range.
            UnsupportedQuery: where "lifted" would spin on the way to a new goal, or from a new
                pose.
        """
        changed = goal is not None or measured is not None or coupling is not None
        if not (changed or obstacles) and type(dt) is float and lag == 0.0:
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
        )

    @property
    def refuses_spins(self) -> bool:
        """Whether it refuses a query on whose way the tool would spin: with "lifted".

        Not with the form "ijspeert", which scales what it turns by, and has no such check.
        """
        return self.model.orientation == "lifted" and self.springs.form != "ijspeert"

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
        arrays = {**self._arrays(), **self.turning.arrays()}
        return {**asdict(self.model), **self._settings()}, arrays

    def _turned_ends(
        self, start: Float64Array | None, goal: Float64Array | None
    ) -> tuple[Ends, _core.DmpPath]:
        """Ends of the orientation's coordinates, and the offset of the curve."""
        learned, known = self.springs.ends.part(slice(3, 6)), self.turning
        if start is None and goal is None:
            return learned, _core.DmpPath()
        first = known.start if start is None else start
        last = known.goal if goal is None else goal
        offset = self._offset(*known.offsets(first, last))
        if known.representation == "anchored":
            return learned, offset
        at_start, _ = known.coordinates(first, phase=0.0, offset=offset, near=learned.start)
        at_goal, _ = known.coordinates(last, phase=1.0, offset=offset, near=learned.goal)
        return replace(learned, start=at_start, goal=at_goal), offset

    def _offset(self, first: Float64Array, last: Float64Array) -> _core.DmpPath:
        """The path between offsets (3,) of the curve, by the orientation's own progress."""
        if not (first.any() or last.any()):
            return _core.DmpPath()
        turning = self.progress.part(slice(3, 6))
        return _core.DmpPath(turning.breaks, turning.shift(first, last))

    @cached_property
    def progress(self) -> Progress:
        """How far each channel has come at each phase, in replay."""
        return pose_progress(*self._shown)

    @cached_property
    def _shown(self) -> tuple[Part, Part]:
        """The position and the orientation, as replayed."""
        values, slopes = self._replayed()
        q = self.turning.orientations(PHASES, values)
        moved = float(np.linalg.norm(values[:, :3] - values[0, :3], axis=1).max())
        turned = float(rotations.distance(q, np.repeat(q[:1], len(q), axis=0)).max())
        return Part(MOVING, slopes[:, :3], moved), Part(TURNING, spins_of(q), turned)

    def _lengthening(self, state: _core.PoseState) -> float:
        linear, angular = _core.dmp_peak_speeds(self.springs.forces, state, COARSE_PHASES)
        moving, turning = self._shown
        return max(
            moving.lengthening(linear, self.duration), turning.lengthening(angular, self.duration)
        )

    def _constraints(
        self, obstacles: Sequence[Shape], limits: tuple[ArrayLike, ArrayLike] | None
    ) -> Constraints:
        return check_constraints(obstacles, limits, dimensions=3, channels=6)

    def _acceleration(self, coupling: ArrayLike) -> Float64Array:
        return pose_acceleration(coupling)

    def _redirected(self, state: _core.PoseState, goal: Place) -> _core.PoseState:
        position, turned = as_pose(goal, "goal")
        wanted = np.concatenate([check_channels(position, "goal", 3), self.springs.ends.goal[3:]])
        known, before = self.turning, state.offset.end
        if turned is None:
            return self._with(state, self._course_to(state, wanted), state.value, state.slope)
        _, last = known.offsets(known.start, turned, near=before)
        if known.representation == "anchored":
            course = self._course_to(state, wanted)
            offset = self._offset_to(state, last - before)
            return self._with(state, course, state.value, state.slope, offset)
        offset = self._offset(last, last)
        wanted[3:], _ = known.coordinates(turned, phase=1.0, offset=offset, near=wanted[3:])
        value, slope = self._coordinates_of(state, state.orientation, offset)
        jumps = value - state.value, slope - state.slope
        course = self._course_to(state, wanted, *jumps)
        if self.springs.form == "ijspeert":
            course = scaled_by(course, slice(3, 6), wanted[3:] - self._started(state, offset))
        return self._without_spin(self._with(state, course, value, slope, offset))

    def _started(self, state: _core.PoseState, offset: _core.DmpPath) -> Float64Array:
        """Coordinates (3,) under another offset of where a state of the form "ijspeert" began."""
        known, began = self.turning, end_of(state.course)[3:] - state.course.gain[3:]
        first = known.orientations(np.zeros(1), began[None], state.offset)[0]
        return known.coordinates(first, phase=0.0, offset=offset, near=began)[0]

    def _offset_to(self, state: _core.PoseState, shift: Float64Array) -> _core.DmpPath:
        if np.abs(shift).max() <= _SAME_TURN:
            return state.offset
        if state.phase == 0.0:
            return self._offset(state.offset.start, state.offset.end + shift)
        until = corrected_until(state.phase, self.progress.end)
        return state.offset.superposed(state.phase, until, _NOTHING, _NOTHING, shift)

    def _moved(self, state: _core.PoseState, measured: Place) -> _core.PoseState:
        position, turned = as_pose(measured, "measured")
        q = state.orientation if turned is None else turned
        value, slope = self._coordinates_of(state, q, state.offset)
        value[:3] = check_channels(position, "measured", 3)
        return self._without_spin(self._with(state, state.course, value, slope))

    def _coordinates_of(
        self, state: _core.PoseState, orientation: Float64Array, offset: _core.DmpPath
    ) -> tuple[Float64Array, Float64Array]:
        """Value and slope (6,) of the state, with another orientation or under another offset."""
        e, e_slope = self.turning.coordinates(
            orientation,
            phase=state.phase,
            offset=offset,
            near=state.value[3:],
            velocity=state.angular_velocity * state.duration,
        )
        return np.append(state.value[:3], e), np.append(state.slope[:3], e_slope)

    def _with(
        self,
        state: _core.PoseState,
        course: _core.DmpCourse,
        value: Float64Array,
        slope: Float64Array,
        offset: _core.DmpPath | None = None,
    ) -> _core.PoseState:
        by = state.offset if offset is None else offset
        return _core.PoseState(course, value, slope, state.phase, state.duration, state.curve, by)

    def _without_spin(self, state: _core.PoseState) -> _core.PoseState:
        """The same state, unless the tool would spin from it to the end."""
        if self.refuses_spins:
            refuse_spin(self.springs, self.turning, state)
        return state

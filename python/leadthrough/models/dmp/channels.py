"""Points, joints and poses as channels of a transformation system.

Source: Lauretti et al. 2023, "Robot learning by demonstration with dynamic parameterization of the
orientation", Robotics 12:166, for the representations and the planner that ours is compared with.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check, rotations
from leadthrough.check import FitError, Float64Array, UnsupportedQuery
from leadthrough.models.dmp import transformation
from leadthrough.models.dmp.orientation import OrientationCoordinates
from leadthrough.models.dmp.progress import (
    COARSE_PHASES,
    JOINTS,
    MOVING,
    PHASES,
    ROTATING,
    Part,
    Progress,
    angular_velocities,
    corrected_until,
    pose_progress,
    progress_of,
    speeds_of,
)
from leadthrough.models.dmp.query import (
    Constraints,
    as_pose,
    check_channels,
    check_constraints,
    course_through,
    ends_of,
    pose_acceleration,
    roll,
    step_within,
)
from leadthrough.models.dmp.transformation import Ends, TransformationSystem, end_of, scaled_by
from leadthrough.models.queries import CheckedQuery
from leadthrough.motion import (
    Events,
    JointTrajectory,
    PoseTrajectory,
    Target,
    Trajectory,
    with_derivatives,
)
from leadthrough.shapes import Shape

# A goal nearer than this fraction of the motion's size to the one before is the same.
_SAME_GOAL = 1e-13

StateT = TypeVar("StateT", core.PointState, core.PoseState)


@dataclass(frozen=True, eq=False)
class Channels(Generic[StateT]):
    """The channels of a discrete primitive: reads queries into them, and motions out of them."""

    system: TransformationSystem
    size: float  # diagonal of the box around the demonstrated positions

    @property
    @abstractmethod
    def dimensions(self) -> int | None:
        """Dimensions of the space in which obstacles can be avoided, if there is one."""

    @property
    @abstractmethod
    def progress(self) -> Progress:
        """Fraction of its way that each channel has covered at each phase, in replay."""

    @property
    @abstractmethod
    def limited(self) -> int | None:
        """Number of channels that limits bound; None where there are no limits."""

    def constraints(
        self, obstacles: Sequence[Shape], limits: tuple[ArrayLike, ArrayLike] | None
    ) -> Constraints:
        return check_constraints(
            obstacles, limits, dimensions=self.dimensions, channels=self.limited
        )

    def step_within(
        self, state: StateT, dt: float, acceleration: Float64Array, constraints: Constraints
    ) -> StateT:
        """The state dt s later, under an acceleration (channels,) and constraints."""
        return step_within(
            self.system, state, dt, acceleration, constraints=constraints, size=self.size
        )

    def ahead(self, state: StateT, phases: Float64Array) -> tuple[Float64Array, Float64Array]:
        """Values and slopes (n, channels) from a state on, at phases (n,)."""
        return core.dmp_rollout(self.system.forces, state.course, state.value, state.slope, phases)

    def course(self, ends: Ends, query: CheckedQuery, *, count: int) -> core.DmpCourse:
        """The course between ends, through the query's via points of the first channels."""
        learned = self.system
        if ends.equal(learned.ends):
            direct = learned.demonstrated_course
        elif learned.form != "blended":
            direct = transformation.course(learned.form, ends)
        else:
            direct = self._moved_course(ends)
        return course_through(learned, direct, ends, query.via, count=count)

    def course_to(
        self,
        state: StateT,
        goal: Float64Array,
        value: Float64Array | None = None,
        slope: Float64Array | None = None,
    ) -> core.DmpCourse:
        """The course to another goal (channels,), after a jump in value and slope, if any."""
        before, form = state.course, self.system.form
        if form != "blended":
            return transformation.redirected(form, before, goal)
        shift = goal - transformation.end_of(before)
        if value is None or slope is None:
            if np.abs(shift).max() <= _SAME_GOAL * max(self.size, float(np.abs(goal).max())):
                return before
            if state.phase == 0.0:
                return transformation.shifted(before, self.progress, shift)
            value = slope = np.zeros(len(shift))
        until = corrected_until(state.phase, self.progress.end)
        return before.superposed(state.phase, until, value, slope, shift)

    def replayed(self) -> tuple[Float64Array, Float64Array]:
        """Values and slopes (n, channels) at PHASES, as demonstrated."""
        learned, ends = self.system, self.system.ends
        course = learned.demonstrated_course
        return core.dmp_rollout(learned.forces, course, ends.start, ends.start_slope, PHASES)

    def moving_course(self) -> dict[str, Float64Array]:
        """Arrays that the course of the form "blended" between other positions is made from."""
        progress = self.progress
        return {
            "breaks": progress.breaks,
            "moving": self._demonstrated_reference,
            "progress": progress.coefficients,
        }

    def _moved_course(self, ends: Ends) -> core.DmpCourse:
        """The course of the form "blended" between other ends than demonstrated."""
        known = self.system.ends
        if ends.start_slope is known.start_slope and ends.goal_slope is known.goal_slope:
            plain = self._demonstrated_reference
        else:
            jerk = transformation.minimum_jerk(ends.moved(known.start, known.goal))
            plain = self.progress.expanded(jerk)
        start, goal = ends.start - known.start, ends.goal - known.goal
        progress = self.progress
        return core.dmp_shifted_course(progress.breaks, plain, progress.coefficients, start, goal)

    @cached_property
    def _demonstrated_reference(self) -> Float64Array:
        """The minimum-jerk motion between the demonstrated ends, about each progress break."""
        return self.progress.expanded(transformation.minimum_jerk(self.system.ends))


@dataclass(frozen=True, eq=False)
class PointChannels(Channels[core.PointState]):
    """Channels that are the coordinates of a point, or joints."""

    joint_names: tuple[str, ...] | None  # None for points

    @property
    def dimensions(self) -> int | None:
        """Two or three for points in the plane or in space; None otherwise."""
        count = len(self.system.ends.start)
        return count if self.joint_names is None and count in (2, 3) else None

    @property
    def limited(self) -> int:
        return len(self.system.ends.start)

    @cached_property
    def progress(self) -> Progress:
        speeds = speeds_of(self._replay.velocities)
        return progress_of(np.repeat(speeds[:, None], len(self.system.ends.start), axis=1))

    @cached_property
    def _replay(self) -> Part:
        values, slopes = self.replayed()
        extent = float(np.linalg.norm(values - values[0], axis=1).max())
        return Part(MOVING if self.joint_names is None else JOINTS, slopes, extent)

    def as_demonstrated(self, duration: float) -> core.PointState:
        ends = self.system.ends
        course = self.system.demonstrated_course
        return core.PointState(course, ends.start, ends.start_slope, 0.0, duration)

    def begin(self, query: CheckedQuery, duration: float) -> core.PointState:
        """The state at the start of a motion of a duration, s."""
        ends = ends_of(query, self.system.ends, duration)
        course = self.course(ends, query, count=len(ends.start))
        return core.PointState(course, ends.start, ends.start_slope, 0.0, duration)

    def lasting(self, state: core.PointState, duration: float) -> core.PointState:
        return core.PointState(state.course, state.value, state.slope, state.phase, duration)

    def lengthening(self, state: core.PointState, duration: float) -> float:
        """Factor >= 1 by which a motion from its start on must last longer than demonstrated."""
        _, slopes = self.ahead(state, COARSE_PHASES)
        return self._replay.lengthening(self._replay.measure.peak(slopes), duration)

    def redirected(self, state: core.PointState, goal: Target) -> core.PointState:
        wanted = check_channels(goal, "goal", len(self.system.ends.goal))
        course = self.course_to(state, wanted)
        return core.PointState(course, state.value, state.slope, state.phase, state.duration)

    def moved(self, state: core.PointState, measured: Target) -> core.PointState:
        value = check_channels(measured, "measured", len(self.system.ends.goal))
        return core.PointState(state.course, value, state.slope, state.phase, state.duration)

    def acceleration(self, coupling: ArrayLike) -> Float64Array:
        return check_channels(coupling, "coupling", len(self.system.ends.goal))

    def motion(
        self,
        state: core.PointState,
        phases: Float64Array,
        *,
        constraints: Constraints,
        events: Events,
        joints: JointTrajectory | None,
    ) -> Trajectory | JointTrajectory:
        positions, slopes = roll(
            self.system, state, phases, constraints=constraints, size=self.size
        )
        times = state.duration * phases
        if self.joint_names is None:
            return check.computed(
                Trajectory, times=times, positions=positions, events=events, joints=joints
            )
        velocities = slopes / state.duration
        return with_derivatives(
            JointTrajectory(times, positions, velocities, None, self.joint_names, events)
        )


_POSITION, _ORIENTATION = slice(3), slice(3, 6)
_NOTHING = np.zeros(3)
_SAME_ORIENTATION = 1e-12  # rad; a goal rotated by less than this is the one before
# Beside whole turns the logarithm of "lifted" swings about, where the tool hardly rotates: a motion
# that rotates by this much more or less than the demonstration and its offset spins, or has lost a
# turn.
_SPIN = np.radians(20.0)
_SAMPLES = 1000


@dataclass(frozen=True, eq=False)
class PoseChannels(Channels[core.PoseState]):
    """Channels of the position, and of the orientation in its coordinates."""

    orientation: OrientationCoordinates
    dimensions = 3  # the position keeps clear of obstacles
    limited = None

    @cached_property
    def progress(self) -> Progress:
        """One for the position and one for the orientation."""
        return pose_progress(*self._replay)

    @cached_property
    def _replay(self) -> tuple[Part, Part]:
        """Position and orientation, as replayed."""
        values, slopes = self.replayed()
        q = self.orientation.orientations(PHASES, values)
        moved = float(np.linalg.norm(values[:, :3] - values[0, :3], axis=1).max())
        rotated = float(rotations.distance(q, np.repeat(q[:1], len(q), axis=0)).max())
        return Part(MOVING, slopes[:, :3], moved), Part(ROTATING, angular_velocities(q), rotated)

    def as_demonstrated(self, duration: float) -> core.PoseState:
        ends, curve = self.system.ends, self.orientation.curve
        course = self.system.demonstrated_course
        return core.PoseState(
            course, ends.start, ends.start_slope, 0.0, duration, curve, core.DmpPath()
        )

    def begin(self, query: CheckedQuery, duration: float) -> core.PoseState:
        first, first_q = as_pose(query.start, "start")
        last, last_q = as_pose(query.goal, "goal")
        asked = replace(query, start=first, goal=last)
        positions = ends_of(asked, self.system.ends.part(_POSITION), duration)
        rotated, offset = self._rotated_ends(first_q, last_q)
        if query.start_velocity is None and query.final_velocity is None:
            ends = self.system.ends.moved(
                np.concatenate((positions.start, rotated.start)),
                np.concatenate((positions.goal, rotated.goal)),
            )
        else:
            ends = positions.joined(rotated)
        course = self.course(ends, query, count=3)
        state = core.PoseState(
            course, ends.start, ends.start_slope, 0.0, duration, self.orientation.curve, offset
        )
        as_demonstrated = first_q is None and last_q is None
        return state if as_demonstrated else self._without_spin(state)

    def lasting(self, state: core.PoseState, duration: float) -> core.PoseState:
        return core.PoseState(
            state.course, state.value, state.slope, state.phase, duration, state.curve, state.offset
        )

    def lengthening(self, state: core.PoseState, duration: float) -> float:
        linear, angular = core.dmp_peak_speeds(self.system.forces, state, COARSE_PHASES)
        moving, rotating = self._replay
        return max(moving.lengthening(linear, duration), rotating.lengthening(angular, duration))

    def motion(
        self,
        state: core.PoseState,
        phases: Float64Array,
        *,
        constraints: Constraints,
        events: Events,
        joints: JointTrajectory | None,
    ) -> PoseTrajectory:
        if constraints.are_none:
            positions, orientations = core.dmp_poses(self.system.forces, state, phases)
        else:
            values, _ = roll(self.system, state, phases, constraints=constraints, size=self.size)
            positions = values[:, :3].copy()
            orientations = self.orientation.orientations(phases, values, state.offset)
        return check.computed(
            PoseTrajectory,
            times=state.duration * phases,
            positions=positions,
            orientations=orientations,
            events=events,
            joints=joints,
        )

    def acceleration(self, coupling: ArrayLike) -> Float64Array:
        """A coupling (3,) or (6,) as linear and angular acceleration (6,)."""
        return pose_acceleration(coupling)

    def redirected(self, state: core.PoseState, goal: Target) -> core.PoseState:
        position, q = as_pose(goal, "goal")
        wanted = np.concatenate([check_channels(position, "goal", 3), self.system.ends.goal[3:]])
        known, before = self.orientation, state.offset.end
        if q is None:
            return self._with(state, self.course_to(state, wanted), state.value, state.slope)
        _, last = known.offsets(known.start, q, near=before)
        if known.representation == "anchored":
            course = self.course_to(state, wanted)
            offset = self._offset_to(state, last - before)
            return self._with(state, course, state.value, state.slope, offset)
        offset = self._offset(last, last)
        wanted[3:], _ = known.coordinates(q, phase=1.0, offset=offset, near=wanted[3:])
        value, slope = self._coordinates_of(state, state.orientation, offset)
        jumps = value - state.value, slope - state.slope
        course = self.course_to(state, wanted, *jumps)
        if self.system.form == "ijspeert":
            course = scaled_by(course, _ORIENTATION, wanted[3:] - self._started(state, offset))
        return self._without_spin(self._with(state, course, value, slope, offset))

    def moved(self, state: core.PoseState, measured: Target) -> core.PoseState:
        position, given = as_pose(measured, "measured")
        q = state.orientation if given is None else given
        value, slope = self._coordinates_of(state, q, state.offset)
        value[:3] = check_channels(position, "measured", 3)
        return self._without_spin(self._with(state, state.course, value, slope))

    @property
    def refuses_spins(self) -> bool:
        """Whether queries that would make the tool spin are refused."""
        # The form "ijspeert" scales the rotation itself.
        return self.orientation.representation == "lifted" and self.system.form != "ijspeert"

    def replayed_angle(self, phases: Float64Array, demonstrated: Float64Array) -> float:
        """Angle, rad, that the tool rotates in replay of orientations (n, 4) at phases (n,)."""
        made = self._orientations(self.as_demonstrated(1.0), phases)
        worst = float(rotations.distance(made, demonstrated).max())
        if worst > _SPIN:
            raise FitError(
                f'demonstrations: orientation="lifted" would be off by {np.degrees(worst):.0f} '
                'degrees beside a whole number of turns; use "anchored"'
            )
        return _whole_angle(made)

    def _rotated_ends(
        self, start: Float64Array | None, goal: Float64Array | None
    ) -> tuple[Ends, core.DmpPath]:
        """Ends of the orientation's coordinates, and the offset of the curve."""
        learned, known = self.system.ends.part(_ORIENTATION), self.orientation
        if start is None and goal is None:
            return learned, core.DmpPath()
        first = known.start if start is None else start
        last = known.goal if goal is None else goal
        offset = self._offset(*known.offsets(first, last))
        if known.representation == "anchored":
            return learned, offset
        at_start, _ = known.coordinates(first, phase=0.0, offset=offset, near=learned.start)
        at_goal, _ = known.coordinates(last, phase=1.0, offset=offset, near=learned.goal)
        return replace(learned, start=at_start, goal=at_goal), offset

    def _offset(self, first: Float64Array, last: Float64Array) -> core.DmpPath:
        """The path between offsets (3,) of the curve, by the orientation's own progress."""
        if not (first.any() or last.any()):
            return core.DmpPath()
        own = self.progress.part(_ORIENTATION)
        return core.DmpPath(own.breaks, own.shift(first, last))

    def _started(self, state: core.PoseState, offset: core.DmpPath) -> Float64Array:
        """Coordinates (3,) under another offset of where a state of the form "ijspeert" began."""
        known, began = self.orientation, end_of(state.course)[3:] - state.course.gain[3:]
        first = known.orientations(np.zeros(1), began[None], state.offset)[0]
        return known.coordinates(first, phase=0.0, offset=offset, near=began)[0]

    def _offset_to(self, state: core.PoseState, shift: Float64Array) -> core.DmpPath:
        if np.abs(shift).max() <= _SAME_ORIENTATION:
            return state.offset
        if state.phase == 0.0:
            return self._offset(state.offset.start, state.offset.end + shift)
        until = corrected_until(state.phase, self.progress.end)
        return state.offset.superposed(state.phase, until, _NOTHING, _NOTHING, shift)

    def _coordinates_of(
        self, state: core.PoseState, orientation: Float64Array, offset: core.DmpPath
    ) -> tuple[Float64Array, Float64Array]:
        """Value and slope (6,) of the state, with another orientation or under another offset."""
        e, e_slope = self.orientation.coordinates(
            orientation,
            phase=state.phase,
            offset=offset,
            near=state.value[3:],
            velocity=state.angular_velocity * state.duration,
        )
        return np.append(state.value[:3], e), np.append(state.slope[:3], e_slope)

    def _with(
        self,
        state: core.PoseState,
        course: core.DmpCourse,
        value: Float64Array,
        slope: Float64Array,
        offset: core.DmpPath | None = None,
    ) -> core.PoseState:
        by = state.offset if offset is None else offset
        return core.PoseState(course, value, slope, state.phase, state.duration, state.curve, by)

    def _without_spin(self, state: core.PoseState) -> core.PoseState:
        """The same state, unless the tool would spin from it to the end."""
        if not self.refuses_spins or state.phase >= 1.0:
            return state
        ahead = _whole_angle(self._orientations(state, np.linspace(state.phase, 1.0, _SAMPLES)))
        angle = self.orientation.angle
        least = angle if state.phase == 0.0 else 0.0
        allowed = _SPIN + float(np.linalg.norm(state.offset.end))
        if least - allowed <= ahead <= angle + allowed:
            return state
        raise UnsupportedQuery(
            f'orientation="lifted": from here to this goal it would turn by '
            f"{np.degrees(ahead):.0f} degrees, but {np.degrees(angle):.0f} were demonstrated; "
            'use "anchored"'
        )

    def _orientations(self, state: core.PoseState, phases: Float64Array) -> Float64Array:
        values, _ = self.ahead(state, phases)
        return self.orientation.orientations(phases, values, state.offset)


def _whole_angle(orientations: Float64Array) -> float:
    """Angle, rad, between neighbouring orientations (n, 4), summed."""
    return float(rotations.distance(orientations[:-1], orientations[1:]).sum())

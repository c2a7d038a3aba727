"""Poses as channels of a transformation system: three of the position, three of the orientation.

Source: Lauretti et al. 2023, "Robot learning by demonstration with dynamic parameterization of the
orientation", Robotics 12:166, for the representations and the planner that ours is compared with.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check, rotations
from leadthrough.check import FitError, Float64Array, UnsupportedQuery
from leadthrough.models.dmp.channels import Channels
from leadthrough.models.dmp.constraints import Constraints, roll
from leadthrough.models.dmp.orientation import OrientationCoordinates
from leadthrough.models.dmp.progress import (
    COARSE_PHASES,
    MOVING,
    PHASES,
    ROTATING,
    Part,
    Progress,
    angular_velocities,
    corrected_until,
    pose_progress,
)
from leadthrough.models.dmp.query import as_pose, check_channels, ends_of, pose_acceleration
from leadthrough.models.dmp.transformation import Ends, end_of, scaled_by
from leadthrough.models.queries import CheckedQuery
from leadthrough.motion import Events, JointTrajectory, PoseTrajectory, Target

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

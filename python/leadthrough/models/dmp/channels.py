"""Points and joints as channels of a transformation system, and the courses of any channels."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.models.dmp import transformation
from leadthrough.models.dmp.constraints import Constraints, check_constraints, roll, step_within
from leadthrough.models.dmp.progress import (
    COARSE_PHASES,
    JOINTS,
    MOVING,
    PHASES,
    Part,
    Progress,
    corrected_until,
    progress_of,
    speeds_of,
)
from leadthrough.models.dmp.query import check_channels, course_through, ends_of
from leadthrough.models.dmp.transformation import Ends, TransformationSystem
from leadthrough.models.queries import CheckedQuery
from leadthrough.motion import Events, JointTrajectory, Target, Trajectory, with_derivatives
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
        """The constraints of a query."""
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
        """All of them."""
        return len(self.system.ends.start)

    @cached_property
    def progress(self) -> Progress:
        """The same for all channels."""
        speeds = speeds_of(self._replay.velocities)
        return progress_of(np.repeat(speeds[:, None], len(self.system.ends.start), axis=1))

    @cached_property
    def _replay(self) -> Part:
        values, slopes = self.replayed()
        extent = float(np.linalg.norm(values - values[0], axis=1).max())
        return Part(MOVING if self.joint_names is None else JOINTS, slopes, extent)

    def as_demonstrated(self, duration: float) -> core.PointState:
        """The state at the start of the demonstrated motion."""
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
        """A coupling (d,) as it is."""
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

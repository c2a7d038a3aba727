"""Limits and margins of a stream of commanded states, and stops that keep them.

A stream has one row a period: positions, velocities and accelerations of all joints, (3 joints,).
"""

from __future__ import annotations

import sys
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check
from leadthrough.arm import Arm, DualArm, JointLimits, check_arms
from leadthrough.arm.limits import known_rates
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.guard.admission import CommandedState, parts_of
from leadthrough.shapes import Scene, compiled
from leadthrough.timing.request import InverseDynamics, checked_dynamics, efforts, known_efforts

ALL_WORK = sys.maxsize
_WORK_OF_STOP = 4000  # pairs of shapes that are looked at along a stop
_PACES = (0.5, 0.25, 0.125, 0.0625)  # at which a motion is tried that comes too near something
_LOOK_AHEAD = 16  # rows of it


@dataclass(frozen=True, eq=False)
class StoppingTrajectory:
    rows: Float64Array  # (n, 3 joints), one a period, the last at rest
    executed: int  # how many of them come before the arm brakes


# The rows of which each command of a stopping trajectory is, with fractions in between.
Slower = tuple[StoppingTrajectory, Float64Array]


@dataclass(frozen=True, eq=False)
class Contact:
    """Two bodies nearer than their margin, a joint's torque, or the end of what was looked at.

    Attributes:
        sample: before which row, with the fraction of the step from the one before.
        bodies: by name; None where the work ended that was allowed, or a torque is too large.
        joint: by name, whose torque is too large, or None.
        ratio: of the torque to its limit.
    """

    sample: float
    bodies: tuple[str, str] | None
    joint: str | None = None
    ratio: float | None = None


@dataclass(frozen=True, eq=False)
class Rules:
    """Limits and the scene to keep clear of."""

    joints: JointLimits  # the limits of the joints
    period: float  # between commands, s
    limits: core.StepLimits  # of the joints
    scene: core.GuardedScene  # the arm and its obstacles
    torques: InverseDynamics | None = None  # that the joints' effort limits bound

    def excess(self, start: Float64Array, rows: Float64Array) -> tuple[int, int, int, float] | None:
        """The first limit that rows (n, 3 joints) exceed: its order, row, joint and ratio."""
        return core.first_excess(self.limits, start, rows)

    def contact(
        self,
        start: Float64Array,
        rows: Float64Array,
        age: float,
        *,
        before: int = 0,
        most_work: int = ALL_WORK,
    ) -> Contact | None:
        """The first contact along rows, or torque too large; None if the margins are kept."""
        if before >= len(rows):
            return None
        first = rows[before - 1] if before else start[0]
        found = core.first_contact(self.scene, first, rows[before:], age + before, most_work)
        contact = (
            None if found is None else Contact(before + found[0], found[1:] if found[1] else None)
        )
        clear = rows if contact is None else rows[: int(contact.sample)]
        return self._overload(clear, before) or contact

    def _overload(self, rows: Float64Array, before: int) -> Contact | None:
        """The first torque too large at rows from one on."""
        if self.torques is None or before >= len(rows):
            return None
        states = map(np.ascontiguousarray, parts_of(rows[before:]))
        ratios = np.abs(efforts(self.torques, *states)) / self.joints.effort
        row, joint = np.unravel_index(int(np.argmax(ratios > 1.0)), ratios.shape)
        if not ratios[row, joint] > 1.0:
            return None
        name = self.joints.joint_names[joint]
        return Contact(float(before + row), None, name, float(ratios[row, joint]))

    def stop(self, start: Float64Array) -> Float64Array:
        """The fastest stop (n, 3 joints); at rest one command, which has to keep the rules too."""
        rows = core.brake(self.limits, start)
        return rows if len(rows) else start

    def braked(self, start: Float64Array, rows: Float64Array) -> StoppingTrajectory | None:
        """Rows, then the fastest stop; None if that leaves a limit."""
        end = rows[-1:] if len(rows) else start
        stop = core.brake(self.limits, end) if len(rows) else self.stop(end)
        if self.excess(end, stop) is not None:
            return None
        return StoppingTrajectory(np.concatenate([rows, stop]), len(rows))

    def stop_excess(self, start: Float64Array) -> tuple[int, int, int, float] | None:
        """The first limit that the fastest stop leaves: its order, row, joint and ratio."""
        return self.excess(start, self.stop(start))

    def clear_braked(
        self,
        start: Float64Array,
        rows: Float64Array,
        age: float,
        *,
        most_work: int = ALL_WORK,
    ) -> StoppingTrajectory | None:
        """Rows known to be clear, then the fastest stop; None if that is not certified."""
        stopping = self.braked(start, rows)
        if stopping is None:
            return None
        found = self.contact(start, stopping.rows, age, before=len(rows), most_work=most_work)
        return stopping if found is None else None

    def cut(self, start: Float64Array, rows: Float64Array, age: float) -> StoppingTrajectory | None:
        """As many of the rows as can be executed before the arm has to brake, and the stop."""
        if len(rows) and (stopping := self._stopped(start, rows, age)):
            return stopping
        best = self.clear_braked(start, rows[:0], age)
        low, high = 0, len(rows)
        while best is not None and high - low > 1:
            middle = (low + high) // 2
            stopping = self.clear_braked(start, rows[:middle], age, most_work=_WORK_OF_STOP)
            low, high = (low, middle) if stopping is None else (middle, high)
            best = best if stopping is None else stopping
        return best

    def slower(self, start: Float64Array, rows: Float64Array, age: float) -> Slower | None:
        """Rows at the highest of some paces at which part of them can be executed; or None."""
        path = np.concatenate([start, rows[:_LOOK_AHEAD]])
        for rate in _PACES:
            eased = core.eased(self.limits, start, path, rate)
            if eased is None:
                continue
            found = self.contact(start, eased[0], age, most_work=_WORK_OF_STOP)
            clear = eased[0] if found is None else eased[0][: int(found.sample)]
            stopping = self.cut(start, clear, age) if len(clear) else None
            if stopping is not None and stopping.executed:
                return stopping, eased[1] - 1.0
        return None

    def _stopped(
        self, start: Float64Array, rows: Float64Array, age: float
    ) -> StoppingTrajectory | None:
        """The rows with a stop on them; None if that is not certified."""
        stopped = core.stopped(self.limits, start, rows)
        if stopped is None:
            return None
        executed = int(np.count_nonzero(stopped[1] == np.arange(len(stopped[1]))))
        found = self.contact(start, stopped[0], age, before=executed, most_work=_WORK_OF_STOP)
        return StoppingTrajectory(stopped[0], executed) if found is None else None


def rules_for(
    arm: Arm | DualArm, scene: Scene, period: float, torques: InverseDynamics | None = None
) -> Rules:
    check_arms(arm)
    if torques is not None:
        known_efforts(arm.limits)
    limits = step_limits(arm.limits, period)
    guarded = guarded_scene(arm, scene, period)
    return Rules(arm.limits, period, limits, guarded, checked_dynamics(torques))


def row_of(state: CommandedState | ArrayLike, joints: int) -> Float64Array:
    """The row (1, 3 joints) of a state."""
    if not isinstance(state, CommandedState):
        q = check.array(state, "state", shape=(joints,))
        return np.concatenate([q, np.zeros(2 * joints)])[None]
    names = ("q", "qd", "qdd")
    parts = [check.array(getattr(state, n), f"state.{n}", shape=(joints,)) for n in names]
    return np.concatenate(parts)[None]


def step_limits(limits: JointLimits, period: float) -> core.StepLimits:
    for name in ("velocity", "acceleration", "jerk"):
        value = getattr(limits, name)
        if value is None or not (np.isfinite(value) & (value > 0.0)).all():
            raise InvalidInput(
                f"limits: expected {name} limits > 0 of all joints, to brake inside them; "
                "`leadthrough info --write-limits` writes a file with assumed ones; in Python, "
                f"Arm.from_urdf takes a file of limits:\n{limits.template()}"
            )
    return core.StepLimits(limits.lower, limits.upper, *known_rates(limits), period)


def guarded_scene(arm: Arm | DualArm, scene: Scene, period: float) -> core.GuardedScene:
    growth = [speed * period for speed in scene.speeds]
    margins = scene.margin, scene.self_collision_margin
    return core.GuardedScene(arm._collision, compiled(scene.shapes), growth, *margins)

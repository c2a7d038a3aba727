"""Stacks of tasks with strict priorities, in velocities and accelerations.

Two schemes. "siciliano-slotine": from the highest task down, each in the null space of those above
(Siciliano and Slotine 1991, eqs. 8 to 10). "reverse": from the lowest up, each correcting the
motion so far while it disturbs the tasks below as little as it can, unilateral tasks by the share
of their activation (Flacco and De Luca 2014 and 2015). The two agree where no unilateral task is
partly active. In both the joints' position, velocity and acceleration limits hold at every level:
where one is met the level's null space takes over, and only then the level itself gives way, as in
Flacco, De Luca and Khatib 2015, found as the optimum of a strictly convex program (Kanoun, Lamiraux
and Wieber 2011), so the motion is continuous where a limit or a task becomes active.

A task is damped where it comes within 2 cm a rad of its singularity, and asks for nothing there in
the end; its null space stays the exact one, so a lower task never disturbs a higher one.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from leadthrough import _core, check
from leadthrough.arm import magnitudes
from leadthrough.arm.arm import Arm
from leadthrough.arm.tasks import JointLimitTask, PostureTask, Task, _Task
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput, InvalidRobot
from leadthrough.motion import JointTrajectory

SCHEMES = ("siciliano-slotine", "reverse")
MOST_TASKS = 12  # the core's workspaces
_UNKNOWN = np.empty(0)


@dataclass(frozen=True, eq=False, slots=True)
class TaskReport:
    """How each task fared, one value a task.

    error: m and rad, rotations counting 0.3 m a rad; of tasks that keep, how far they are violated.
    miss: by how much the motion differs from what the task asks for, the same per s or s^2.
    activation: 1, and of tasks that keep 0 to 1. limited: whether a joint limit, or a task above
    that keeps, stood in its way.
    """

    error: Float64Array
    miss: Float64Array
    activation: Float64Array
    limited: NDArray[np.bool_]


@dataclass(frozen=True, eq=False, slots=True)
class StackSolution:
    """motion: (joints,) rad/s or rad/s^2 (m for prismatic joints), inside the limits."""

    motion: Float64Array
    report: TaskReport


@dataclass(frozen=True, eq=False, slots=True)
class StackRun:
    """A closed-loop run. The arrays have one row a sample and one column a task."""

    trajectory: JointTrajectory
    error: Float64Array
    miss: Float64Array
    activation: Float64Array
    limited: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class TaskStack:
    """Tasks in the order of their priority, the highest first, at most 12.

    scheme: see the module. rest_damping: 1/s; accelerations that no task asks for slow the joints
    down at this rate. Raises InvalidInput.
    """

    arm: Arm
    tasks: tuple[Task, ...]
    scheme: str = "siciliano-slotine"
    rest_damping: float = 10.0
    _stack: _core.TaskStack = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "tasks", _checked(self.tasks, len(self.arm.joint_names)))
        check.choice(self.scheme, "scheme", SCHEMES)
        rest = magnitudes.not_negative(self.rest_damping, "rest_damping")
        compiled = [task.compiled(self._frame) for task in self.tasks]
        rates = (self.arm.limits.velocity, accelerations(self.arm))
        reverse = self.scheme == "reverse"
        stack = _core.TaskStack(self.arm._chain, compiled, *rates, reverse, rest)
        object.__setattr__(self, "_stack", stack)

    def __reduce__(self) -> tuple[Any, ...]:
        return TaskStack, (self.arm, self.tasks, self.scheme, self.rest_damping)

    def with_tasks(self, tasks: Sequence[Task]) -> TaskStack:
        """The same stack with other tasks. Raises InvalidInput."""
        return TaskStack(self.arm, tuple(tasks), self.scheme, self.rest_damping)

    def solve(self, q: Any, *, qd: Any = None, dt: float = 1e-3) -> StackSolution:
        """Velocities for the next dt, s, with a report.

        q, qd: (joints,). Without qd the accelerations that lead to the new velocities are not
        bounded. A joint outside its limits is not moved further out. Raises InvalidInput.
        """
        now = self._joints(q, "q")
        before = _UNKNOWN if qd is None else self._joints(qd, "qd")
        return _solution(*self._stack.velocity(now, before, magnitudes.interval(dt)))

    def velocity(self, q: Any, *, qd: Any = None, dt: float = 1e-3) -> Float64Array:
        """The motion of `solve`."""
        return self.solve(q, qd=qd, dt=dt).motion

    def solve_acceleration(self, q: Any, qd: Any, *, dt: float = 1e-3) -> StackSolution:
        """Accelerations for the next dt, s, with a report; qd grows by dt times them.

        q, qd: (joints,). Raises InvalidInput.
        """
        state = (self._joints(q, "q"), self._joints(qd, "qd"))
        return _solution(*self._stack.acceleration(*state, magnitudes.interval(dt)))

    def acceleration(self, q: Any, qd: Any, *, dt: float = 1e-3) -> Float64Array:
        """The motion of `solve_acceleration`."""
        return self.solve_acceleration(q, qd, dt=dt).motion

    def run(
        self,
        q: Any,
        *,
        duration: float,
        dt: float = 1e-3,
        qd: Any = None,
        tasks: Callable[[float], Sequence[Task]] | None = None,
    ) -> StackRun:
        """The closed loop from q and qd (at rest if None), one sample every dt.

        tasks: called with the time, s, gives the tasks of the next interval, as many as there are
        now; without it they stay. Every interval takes its middle's velocity (third-order error),
        so that the null space's motion leaves the tool in place. Raises InvalidInput.
        """
        state = self._joints(q, "q"), np.zeros(len(self.arm.joint_names))
        if qd is not None:
            state = state[0], self._joints(qd, "qd")
        dt = magnitudes.interval(dt)
        count = _intervals(duration, dt)
        rows, reports, stack = [state], [], self
        for k in range(count):
            if tasks is not None:
                stack = self.with_tasks(tasks(k * dt))
                if len(stack.tasks) != len(self.tasks):
                    raise InvalidInput(f"tasks: expected {len(self.tasks)}, got {len(stack.tasks)}")
            q_next, qd_next, report = stack._stack.step(*rows[-1], dt)
            rows.append((q_next, qd_next))
            reports.append(report)
        reports.append(stack._stack.velocity(*rows[-1], dt)[1])
        return _run(self.arm, rows, reports, dt)

    def _joints(self, value: Any, name: str) -> Float64Array:
        return magnitudes.values(value, name, shape=(len(self.arm.joint_names),))

    def _frame(self, link: str | None, point: Float64Array) -> _core.Frame:
        if link is None:
            return _core.Frame(self.arm._chain, point)
        try:
            upper = _core.Chain(self.arm._robot, self.arm.base, link)
        except InvalidRobot as error:
            raise InvalidInput(f"link: expected a link that the arm moves: {error}") from None
        if upper.joint_names != list(self.arm.joint_names[: len(upper.joint_names)]):
            raise InvalidInput(f"link: {link!r} is moved by joints outside the arm")
        return _core.Frame(upper, point)


def accelerations(arm: Arm) -> Float64Array:
    """The arm's acceleration limits, infinite where they are not known."""
    known = arm.limits.acceleration
    return np.full(len(arm.joint_names), np.inf) if known is None else known


def resolve(
    jacobians: Sequence[Any],
    wanted: Sequence[Any],
    *,
    lower: Any = None,
    upper: Any = None,
    scheme: str = SCHEMES[0],
) -> Float64Array:
    """The motion (joints,) that strict priorities give to tasks of one's own.

    jacobians: (rows, joints) each, the highest priority first; at most 12 tasks, 16 rows and 16
    joints. wanted: (rows,) each. lower, upper: (joints,) bounds of the motion. Raises InvalidInput.
    """
    rows = [magnitudes.values(j, "jacobians", shape=("rows", "joints")) for j in jacobians]
    if not 0 < len(rows) <= MOST_TASKS:
        raise InvalidInput(f"jacobians: expected 1 to {MOST_TASKS}, got {len(rows)}")
    joints = rows[0].shape[1]
    for jacobian in rows:
        if not 0 < max(jacobian.shape) <= 16 or jacobian.shape[1] != joints:
            raise InvalidInput(
                f"jacobians: expected up to 16 rows of {joints} joints, got {jacobian.shape}"
            )
    if len(wanted) != len(rows):
        raise InvalidInput(f"wanted: expected {len(rows)} vectors, got {len(wanted)}")
    goals = [
        magnitudes.values(goal, "wanted", shape=(len(jacobian),))
        for goal, jacobian in zip(wanted, rows, strict=True)
    ]
    low, high = _bound(lower, "lower", -np.inf, joints), _bound(upper, "upper", np.inf, joints)
    if (low > high).any():
        raise InvalidInput("lower: expected at most upper")
    reverse = check.choice(scheme, "scheme", SCHEMES) == "reverse"
    return _core.resolve_stack(rows, goals, low, high, reverse)


def _bound(value: Any, name: str, default: float, joints: int) -> Float64Array:
    if value is None:
        return np.full(joints, default)
    return magnitudes.values(value, name, shape=(joints,))


def _checked(tasks: Any, joints: int) -> tuple[Task, ...]:
    if not isinstance(tasks, Sequence) or not all(isinstance(task, _Task) for task in tasks):
        raise InvalidInput(f"tasks: expected a sequence of tasks, got {tasks!r}")
    if not 0 < len(tasks) <= MOST_TASKS:
        raise InvalidInput(f"tasks: expected 1 to {MOST_TASKS}, got {len(tasks)}")
    if sum(isinstance(task, JointLimitTask) for task in tasks) > 1:
        raise InvalidInput("tasks: expected one JointLimitTask, got several")
    for task in tasks:
        if isinstance(task, PostureTask) and len(task.q) != joints:
            raise InvalidInput(f"tasks: expected a posture of {joints} joints, got {len(task.q)}")
    return tuple(tasks)


def _intervals(duration: Any, dt: float) -> int:
    whole = check.number(duration, "duration", above=0.0) / dt
    if not whole < 1e7:
        raise InvalidInput(f"dt: {dt} s would make {whole:.3g} samples of {duration} s")
    return max(round(whole), 1)


def _solution(motion: Float64Array, report: tuple[Any, ...]) -> StackSolution:
    return StackSolution(motion, TaskReport(*report))


def _run(
    arm: Arm, rows: Sequence[tuple[Float64Array, Float64Array]], reports: Any, dt: float
) -> StackRun:
    q, qd = (np.array(part) for part in zip(*rows, strict=True))
    trajectory = JointTrajectory(
        dt * np.arange(len(q), dtype=np.float64), q, qd, joint_names=arm.joint_names
    )
    return StackRun(trajectory, *(np.array(part) for part in zip(*reports, strict=True)))

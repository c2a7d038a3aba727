"""Stacks of tasks with strict priorities, in velocities and accelerations.

The scheme "siciliano-slotine" goes from the highest task down, each in the null space of those
above (Siciliano and Slotine 1991, eqs. 8 to 10). "reverse" goes from the lowest up, unilateral
tasks in proportion to their activation (Flacco and De Luca 2014 and 2015). In both the joints'
limits hold at every level (Flacco, De Luca and Khatib 2015), as the optimum of a strictly convex
program (Kanoun, Lamiraux and Wieber 2011), so the motion is continuous. A task is damped within
2 cm per rad of its singularity; its null space stays exact.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

import leadthrough._core as core
from leadthrough import check
from leadthrough.arm import magnitudes
from leadthrough.arm.arm import Arm, check_arm
from leadthrough.arm.limits import known_acceleration
from leadthrough.arm.tasks import ArmTask, JointLimitTask, PostureTask
from leadthrough.check import Float64Array, InvalidInput, InvalidRobot, ShortRepr
from leadthrough.drawing import Drawn, Panel, over
from leadthrough.motion import JointTrajectory, with_derivatives

Scheme = Literal["siciliano-slotine", "reverse"]
_SCHEMES: tuple[Scheme, ...] = get_args(Scheme)
_MAX_TASKS = 12  # the core's workspaces
_MAX_ROWS = 16  # rows and joints: the core's workspaces
_UNKNOWN = np.empty(0)
_MAX_SAMPLES = 1e7


@dataclass(frozen=True, eq=False, init=False)
class TaskStack(ShortRepr):
    """Tasks with strict priorities, solved for the velocities or accelerations of an arm's joints.

    Attributes:
        arm: the arm.
        tasks: in the order of their priority, the highest first; at most 12.
        scheme: "siciliano-slotine" goes from the highest task down, each in the null space of those
            above; "reverse" from the lowest up, each correcting the motion so far. They differ only
            where a task that keeps a distance is partly active.
        rest_damping: rate in 1/s, >= 0, at which the joints slow down in directions in which no
            task asks for an acceleration.

    Source: Siciliano and Slotine 1991; Flacco and De Luca 2014; Flacco, De Luca and Khatib 2015.
    """

    arm: Arm
    tasks: tuple[ArmTask, ...]
    scheme: Scheme
    rest_damping: float
    _parts: dict[ArmTask, core.ArmTask] = field(
        init=False, repr=False
    )  # the tasks as the core takes them
    _stack: core.TaskStack = field(init=False, repr=False)

    def __init__(
        self,
        arm: Arm,
        tasks: Sequence[ArmTask],
        scheme: Scheme = "siciliano-slotine",
        rest_damping: float = 10.0,
    ) -> None:
        check_arm(arm)
        check.choice(scheme, "scheme", _SCHEMES)
        rest = magnitudes.not_negative(rest_damping, "rest_damping")
        vars(self).update(arm=arm, scheme=scheme, rest_damping=rest, _parts={})
        self._take(tasks)

    def __reduce__(self) -> tuple[Any, ...]:
        return TaskStack, (self.arm, self.tasks, self.scheme, self.rest_damping)

    def with_tasks(self, tasks: Sequence[ArmTask]) -> TaskStack:
        """The same stack with other tasks."""
        # Spelled out, as loops change tasks in every step: unchanged parts are reused.
        made = object.__new__(TaskStack)
        vars(made).update(vars(self))
        made._take(tasks)
        return made

    def solve(
        self, q: ArrayLike, *, qd: ArrayLike | None = None, dt: float = 1e-3
    ) -> StackSolution:
        """Velocities for the next interval, with a report on each task.

        A joint outside its limits is not moved further out.

        Args:
            q: configuration (joints,) in rad (m).
            qd: present velocities (joints,) in rad/s (m/s); without them the accelerations that
                lead to the new velocities are not bounded.
            dt: the interval in s, 1e-6 to 10.
        """
        now = self._joints(q, "q")
        before = _UNKNOWN if qd is None else self._joints(qd, "qd")
        return _solution(*self._stack.velocity(now, before, magnitudes.interval(dt)))

    def solve_acceleration(self, q: ArrayLike, qd: ArrayLike, *, dt: float = 1e-3) -> StackSolution:
        """Accelerations for the next interval, with a report on each task.

        Args:
            q: configuration (joints,) in rad (m).
            qd: present velocities (joints,) in rad/s (m/s), which grow by dt times the answer.
            dt: the interval in s, 1e-6 to 10.
        """
        state = (self._joints(q, "q"), self._joints(qd, "qd"))
        return _solution(*self._stack.acceleration(*state, magnitudes.interval(dt)))

    def run(
        self,
        q: ArrayLike,
        *,
        duration: float,
        dt: float = 1e-3,
        qd: ArrayLike | None = None,
        tasks: Callable[[float], Sequence[ArmTask]] | None = None,
    ) -> StackRun:
        """The joints and reports of the closed loop in velocities, one sample every dt.

        Every interval uses the velocity of its middle (third-order error), so that motion in the
        null space leaves the tool in place.

        Args:
            q: configuration (joints,) in rad (m) to start in.
            duration: in s, > 0.
            dt: the interval in s, 1e-6 to 10.
            qd: velocities (joints,) to start with in rad/s (m/s); by default at rest.
            tasks: the tasks of the next interval by its time in s, as many as the stack has; by
                default they stay.

        Raises:
            InvalidInput: if the number of tasks changes.
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
                    raise InvalidInput(
                        f"tasks: expected {len(self.tasks)} tasks at {k * dt:.6g} s, as in the "
                        f"stack, got {len(stack.tasks)}"
                    )
            q_next, qd_next, report = stack._stack.step(*rows[-1], dt)
            rows.append((q_next, qd_next))
            reports.append(report)
        reports.append(stack._stack.velocity(*rows[-1], dt)[1])
        return _run(self.arm, rows, reports, dt)

    def _take(self, tasks: Sequence[ArmTask]) -> None:
        """Makes these the tasks of the stack; those that it had already are not compiled again."""
        arm, known = self.arm, self._parts
        checked = _checked(tasks, len(arm.joint_names))
        parts = {task: known.get(task) or task._compiled(self._frame) for task in checked}
        stack = core.TaskStack(
            arm._chain,
            [parts[task] for task in checked],
            arm.limits.velocity,
            known_acceleration(arm.limits),
            self.scheme == "reverse",
            self.rest_damping,
        )
        vars(self).update(tasks=checked, _parts=parts, _stack=stack)

    def _joints(self, value: ArrayLike, name: str) -> Float64Array:
        return magnitudes.values(value, name, shape=(len(self.arm.joint_names),))

    def _frame(self, link: str | None, point: Float64Array) -> core.Frame:
        if link is None:
            return core.Frame(self.arm._chain, point)
        try:
            upper = core.Chain(self.arm._robot, self.arm.base, link)
        except InvalidRobot as error:
            raise InvalidInput(f"link: expected a link that the arm moves: {error}") from None
        if upper.joint_names != list(self.arm.joint_names[: len(upper.joint_names)]):
            raise check.refused("link", "a link that only the arm's joints move", repr(link))
        return core.Frame(upper, point)


def _checked(tasks: Any, joints: int) -> tuple[ArmTask, ...]:
    if not isinstance(tasks, Sequence) or not all(isinstance(task, ArmTask) for task in tasks):
        raise InvalidInput(f"tasks: expected a sequence of tasks, got {tasks!r}")
    if not 0 < len(tasks) <= _MAX_TASKS:
        raise InvalidInput(f"tasks: expected 1 to {_MAX_TASKS} tasks, got {len(tasks)}")
    if sum(isinstance(task, JointLimitTask) for task in tasks) > 1:
        raise InvalidInput("tasks: expected at most one JointLimitTask, got several")
    for task in tasks:
        if isinstance(task, PostureTask) and len(task.q) != joints:
            raise InvalidInput(
                f"tasks: expected a PostureTask of {joints} joints, got one of {len(task.q)}"
            )
    return tuple(tasks)


def _intervals(duration: float, dt: float) -> int:
    whole = check.number(duration, "duration", above=0.0) / dt
    if not whole < _MAX_SAMPLES:
        raise InvalidInput(
            f"dt: {duration} s at {dt} s would make {whole:.3g} samples, more than "
            f"{_MAX_SAMPLES:g}; use a larger dt or a shorter duration"
        )
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
    return StackRun(
        with_derivatives(trajectory), *(np.array(part) for part in zip(*reports, strict=True))
    )


@dataclass(frozen=True, eq=False, slots=True)
class TaskReport(ShortRepr):
    """How each task fared; every array is (tasks,).

    Attributes:
        error: in m and rad, rotations counting 0.3 m per rad; of tasks that keep a distance, by how
            much it is violated.
        residual: difference between the motion and what the task asks for, the same per s or s^2.
        activation: 1; of tasks that keep a distance, 0 to 1.
        limited: whether a joint limit, or a higher task that keeps a distance, limited the task.
    """

    error: Float64Array
    residual: Float64Array
    activation: Float64Array
    limited: NDArray[np.bool_]


@dataclass(frozen=True, eq=False, slots=True)
class StackSolution(ShortRepr):
    """The motion for one interval.

    Attributes:
        motion: (joints,) in rad/s or rad/s^2 (m for prismatic joints), inside the limits.
        report: how each task fared.
    """

    motion: Float64Array
    report: TaskReport


@dataclass(frozen=True, eq=False, slots=True)
class StackRun(Drawn):
    """A closed-loop run; the arrays are (samples, tasks) and mean what those of TaskReport mean.

    Attributes:
        trajectory: the joints.
        error: in m and rad.
        residual: in m/s and rad/s.
        activation: 0 to 1.
        limited: whether something limited the task.
    """

    trajectory: JointTrajectory
    error: Float64Array
    residual: Float64Array
    activation: Float64Array
    limited: NDArray[np.bool_]

    def _panels(self) -> list[Panel]:
        names = [f"task {i + 1}" for i in range(self.error.shape[1])]
        errors = over(self.trajectory.times, self.error, names, title="errors in m and rad")
        return [*self.trajectory._panels()[:1], errors]


def resolve(
    jacobians: Sequence[ArrayLike],
    wanted: Sequence[ArrayLike],
    *,
    lower: ArrayLike | None = None,
    upper: ArrayLike | None = None,
    scheme: Scheme = "siciliano-slotine",
) -> Float64Array:
    """The motion (joints,) that meets tasks in the order of their priority.

    Args:
        jacobians: of each task (rows, joints), the highest priority first; at most 12 tasks, 16
            rows and 16 joints.
        wanted: the motion that each task asks for, (rows,).
        lower: bounds (joints,) of the motion; none by default.
        upper: bounds (joints,) of the motion; none by default.
        scheme: as in `TaskStack`.
    """
    rows = _checked_jacobians(jacobians)
    joints = rows[0].shape[1]
    if len(wanted) != len(rows):
        raise check.refused("wanted", f"{len(rows)} vectors, as many as jacobians", len(wanted))
    goals = [
        magnitudes.values(goal, "wanted", shape=(len(jacobian),))
        for goal, jacobian in zip(wanted, rows, strict=True)
    ]
    low, high = _bound(lower, "lower", -np.inf, joints), _bound(upper, "upper", np.inf, joints)
    if (low > high).any():
        i = int(np.argmax(low > high))
        raise check.refused("lower", f"at most upper for joint {i}", f"{low[i]} and {high[i]}")
    reverse = check.choice(scheme, "scheme", _SCHEMES) == "reverse"
    return core.resolve_stack(rows, goals, low, high, reverse)


def _checked_jacobians(jacobians: Sequence[ArrayLike]) -> list[Float64Array]:
    rows = [magnitudes.values(j, "jacobians", shape=("rows", "joints")) for j in jacobians]
    if not 0 < len(rows) <= _MAX_TASKS:
        raise InvalidInput(f"jacobians: expected 1 to {_MAX_TASKS} matrices, got {len(rows)}")
    joints = rows[0].shape[1]
    for jacobian in rows:
        if not 0 < max(jacobian.shape) <= _MAX_ROWS or jacobian.shape[1] != joints:
            raise InvalidInput(
                f"jacobians: expected up to {_MAX_ROWS} rows of {joints} joints (at most "
                f"{_MAX_ROWS}), got {jacobian.shape}"
            )
    return rows


def _bound(value: ArrayLike | None, name: str, default: float, joints: int) -> Float64Array:
    if value is None:
        return np.full(joints, default)
    return magnitudes.values(value, name, shape=(joints,))

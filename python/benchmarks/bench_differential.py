"""One step of closed-loop kinematics against pink, which solves a quadratic program for it.

Both keep the tool of a Panda on a circle within position and velocity limits, with the posture as
the task of lower priority. The error is the largest distance of the tool from its target. Pink
weights its tasks, so that a lower task disturbs a higher one; our stack has strict priorities.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pink
import pinocchio as pin
from frame import Benchmark
from judge import Judge, urdf_of

import leadthrough as lt

START = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7])
DT, GAIN = 1e-3, 20.0  # s, 1/s
TURNS = 2.0  # rad/s
TOLERANCE = 5e-3  # m: lag behind a moving target whose velocity is unknown


def benchmarks(*, quick: bool) -> Iterator[Benchmark]:
    """Steps of DifferentialIk and of a task stack, each against pink."""
    arm = lt.Arm.load("panda")
    position, orientation = arm.forward_kinematics(START)
    phase = TURNS * DT * np.arange(200 if quick else 2000)
    circle = position + 0.03 * np.column_stack([np.cos(phase) - 1, np.sin(phase), 0 * phase])
    peer = _pink(arm, circle)
    ways: dict[str, Callable[[], Any]] = {
        "DifferentialIk": lambda: _differential(arm, circle, orientation),
        "TaskStack of three": lambda: _stack(arm, circle, orientation),
    }
    for name, ours in ways.items():
        yield Benchmark(
            f"panda: {len(circle)} closed-loop steps, {name}",
            ours=ours,
            peer=peer,
            peer_name="pin-pink",
            error=lambda a, b: max(_off(arm, circle, a), _off(arm, circle, b)),
            tolerance=TOLERANCE,
        )


def _off(arm: lt.Arm, circle: Any, q: Any) -> float:
    """The largest distance of the tool from its target of the same step, m."""
    return float(np.linalg.norm(arm.forward_kinematics(q)[0] - circle, axis=1).max())


def _differential(arm: lt.Arm, circle: Any, orientation: Any) -> Any:
    ik = lt.DifferentialIk(arm, dt=DT, gain=GAIN, posture=START)
    state, rows = ik.start(START), []
    for place in circle:
        state = ik.step(state, place, orientation)
        rows.append(state.q)
    return np.array(rows)


def _stack(arm: lt.Arm, circle: Any, orientation: Any) -> Any:
    def tasks(time: float) -> Any:
        place = circle[round(time / DT)]
        return [limits, lt.arm.PoseTask(place, orientation, gain=GAIN), posture]

    limits, posture = lt.arm.JointLimitTask(), lt.arm.PostureTask(START, gain=1.0)
    run = lt.arm.TaskStack(arm, tasks(0.0)).run(
        START, duration=DT * len(circle), dt=DT, tasks=tasks
    )
    return run.trajectory.positions[1:]


def _pink(arm: lt.Arm, circle: Any) -> Callable[[], Any]:
    judge = Judge(arm, urdf_of("panda"))
    tool = pink.tasks.FrameTask(arm.tip, position_cost=1.0, orientation_cost=0.3, gain=GAIN * DT)
    posture = pink.tasks.PostureTask(cost=1e-3, gain=DT)
    posture.set_target(judge.configuration(START))
    first = pin.SE3(judge.pose(START))

    def run() -> Any:
        configuration = pink.Configuration(
            judge.model, judge.data, judge.configuration(START), copy_data=False
        )
        rows = []
        for place in circle:
            tool.set_target(pin.SE3(first.rotation, place))
            velocity = _solve(configuration, [tool, posture])
            configuration.integrate_inplace(velocity, DT)
            rows.append(configuration.q[:7].copy())
        return np.array(rows)

    return run


def _solve(configuration: Any, tasks: Any) -> Any:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return pink.solve_ik(configuration, tasks, DT, solver="quadprog")

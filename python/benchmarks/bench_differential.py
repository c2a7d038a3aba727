"""One step of closed-loop kinematics against pink, which solves a quadratic program for it.

Both hold a Panda's tool on a circle with the posture as the weaker task, inside position and
velocity limits. An answer is the tool's largest distance from the circle after the first lap.
Pink weighs its tasks (a lower one does disturb a higher one); our stack ranks them.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pink
import pinocchio as pin
from frame import Benchmark
from judge import Judge
from pink.tasks import FrameTask, PostureTask

import leadthrough as lt
from leadthrough.arm import JointLimitTask, PoseTask, TaskStack
from leadthrough.arm import PostureTask as Posture
from leadthrough.arm.robots import find_robot

START = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7])
DT, GAIN = 1e-3, 20.0  # s, 1/s
TURNS = 2.0  # rad/s
TOLERANCE = 5e-3  # m: the lag of a target that tells nobody its speed


def benchmarks(*, quick: bool) -> Iterator[Benchmark]:
    """A step of DifferentialIk and of a stack, each against pink's."""
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
    """How far the tool is from where the circle was when it was told, at most."""
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
        return [limits, PoseTask(place, orientation, gain=GAIN), posture]

    limits, posture = JointLimitTask(), Posture(START, gain=1.0)
    run = TaskStack(arm, tasks(0.0)).run(START, duration=DT * len(circle), dt=DT, tasks=tasks)
    return run.trajectory.positions[1:]


def _pink(arm: lt.Arm, circle: Any) -> Callable[[], Any]:
    judge = Judge(arm, find_robot("panda") / "panda.urdf")
    tool = FrameTask(arm.tip, position_cost=1.0, orientation_cost=0.3, gain=GAIN * DT)
    posture = PostureTask(cost=1e-3, gain=DT)
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

"""Pushes of a simulated Panda that a model leads by its own online call, once a period.

The arm is soft in its joints, with the friction, delay and encoders of a real one. A hand pushes
its tip sideways for a while. While the tool is farther from its command than friction holds it, the
model goes on from the measured tool, otherwise from its own last target.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np

import leadthrough as lt
from leadthrough import rotations
from leadthrough.arm import JointState
from leadthrough.check import Float64Array
from leadthrough.guard import CommandedState
from leadthrough.motion import Demonstration, JointTrajectory, Motion, PoseTrajectory
from leadthrough.simulation import Disturbances, JointImpedance, Push, SimulatedArm
from leadthrough_studies.comparison.measures import across, faded_errors, path_and_size
from leadthrough_studies.comparison.pushes import online_call, time_at
from leadthrough_studies.human.demonstrations import START
from leadthrough_studies.study import Row

# The command of a target a period later: from the last one, or from measured joints.
Command: TypeAlias = Callable[[Any, JointState | None], CommandedState]

_PERIOD = 0.01  # s
_FORCE, _PUSHED = 30.0, 0.3  # N and s
_OFF = 0.02  # m; friction holds the tip up to 1 cm off
_GAIN = 50.0  # 1/s, of the joints behind the tool's target
_PUSHED_AT = (0.25, 0.5, 0.75)
_GONE = 0.15  # fraction of the path, at most, that a motion covers while it is pushed
_AFTER = 1.0  # s that the arm has after the duration of the motion
_MIDDLE = (0.5, 0.0, 0.3)  # m, of points, which the tool draws pointing down
_DOWN = np.array([0.0, 1.0, 0.0, 0.0])


def before_the_arm(shown: Sequence[Demonstration[Any]]) -> list[Demonstration[Any]]:
    """Demonstrations of points, moved to before the arm."""
    every = np.concatenate([each.motion.positions for each in shown])
    shift = _MIDDLE - 0.5 * (every.min(axis=0) + every.max(axis=0))
    return [
        replace(each, motion=replace(each.motion, positions=each.motion.positions + shift))
        for each in shown
    ]


def responses(skill: Any, tested: Motion) -> Row:
    """Errors of the tip after pushes at a quarter, half and three quarters of the path, in mm.

    Args:
        skill: of points in space, poses or the Panda's joints.
        tested: the demonstration, whose start and goal are given.
    """
    arm = lt.Arm.load("panda")
    path, _ = path_and_size(_tips(arm, tested))
    errors, moved = [], []
    for at in _PUSHED_AT:
        row = int(at * len(path))
        side = across(path[row + 1] - path[row - 1])
        after = _pushed(arm, skill, tested, at, _FORCE * side)
        gone = np.linalg.norm(path[row : row + int(_GONE * len(path))] - after[0], axis=1)
        moved.append(float(gone.min()))
        errors.append(faded_errors(path[row + int(gone.argmin()) :], after[0], after))
    parts = zip(_PUSHED_AT, errors, strict=True)
    return {
        "push_Frechet_mm": 1e3 * float(np.mean([each[0] for each in errors])),
        "push_any_fade_mm": 1e3 * float(np.mean([each[1] for each in errors])),
        "displaced_mm": 1e3 * float(np.mean(moved)),
        **{f"push_at_{100 * at:.0f}_mm": 1e3 * each[0] for at, each in parts},
    }


def _pushed(
    arm: lt.Arm, skill: Any, tested: Motion, at: float, force: Float64Array
) -> Float64Array:
    """Positions (n, 3) of the tip after a push by a force (3,), N, at a fraction of the path."""
    start, goal = (tested.at(time) for time in tested.times[[0, -1]])
    own = skill.generate(start=start, goal=goal)
    call = online_call(skill, start=start, goal=goal, period=_PERIOD)
    command, q = _commands(arm, own)
    now = time_at(own, at)
    real = SimulatedArm(
        arm,
        q,
        controller=JointImpedance(),
        disturbances=Disturbances(pushes=[Push(now, force, _PUSHED)]),
        rate=1.0 / _PERIOD,
    )
    wanted, tips = command(start, JointState(q, real.qd)), []
    for _ in range(round((max(own.duration, tested.duration) + _AFTER) / _PERIOD)):
        here, (there, _) = (arm.forward_kinematics(each) for each in (real.q, wanted.q))
        off = float(np.linalg.norm(here[0] - there)) > _OFF
        target = call(_measured(own, here, real.q) if off else None)
        wanted = command(target, JointState(real.q, real.qd) if off else None)
        tips.append(arm.forward_kinematics(real.step(wanted))[0])
    return np.array(tips[round((now + _PUSHED) / _PERIOD) :])


def _measured(own: Motion, pose: Any, q: Float64Array) -> Any:
    """The measured tool, as the model of a motion takes it."""
    if isinstance(own, JointTrajectory):
        return q
    return pose if isinstance(own, PoseTrajectory) else pose[0]


def _commands(arm: lt.Arm, own: Motion) -> tuple[Command, Float64Array]:
    """The arm's commands by targets of a motion, and the joints where it begins."""
    if isinstance(own, JointTrajectory):
        return _of_joints(own.positions[0]), own.positions[0]
    first = _pose(own, own.at(own.times[0]))
    ik = lt.DifferentialIk(arm, dt=_PERIOD, gain=_GAIN, posture=START)
    return _of_tool(ik, own), arm.inverse_kinematics(*first, q0=START).q


def _of_joints(last: Float64Array) -> Command:
    def command(target: Any, begun: JointState | None) -> CommandedState:
        nonlocal last
        before, last = last if begun is None else begun.q, np.asarray(target)
        return CommandedState(last, (last - before) / _PERIOD, np.zeros(len(last)))

    return command


def _of_tool(ik: lt.DifferentialIk, own: Motion) -> Command:
    state, last = ik.start(START), ik.arm.forward_kinematics(START)

    def command(target: Any, begun: JointState | None) -> CommandedState:
        nonlocal state, last
        if begun is not None:
            state, last = begun, ik.arm.forward_kinematics(begun.q)
        pose = _pose(own, target)
        turn = rotations.compose(pose[1][None], rotations.inverse(last[1][None]))
        twist = np.concatenate([pose[0] - last[0], rotations.log(turn)[0]]) / _PERIOD
        state, last = ik.step(state, *pose, twist=twist), pose
        return CommandedState(state.q, state.qd, np.zeros(len(state.q)))

    return command


def _pose(own: Motion, target: Any) -> tuple[Float64Array, Float64Array]:
    """A target as a pose: points pointing down, and positions as the motion turns nearest to."""
    if isinstance(target, tuple):
        return target
    if not isinstance(own, PoseTrajectory):
        return np.asarray(target), _DOWN
    nearest = np.linalg.norm(own.positions - target, axis=1).argmin()
    return np.asarray(target), own.orientations[int(nearest)]


def _tips(arm: lt.Arm, motion: Motion) -> Float64Array:
    if isinstance(motion, JointTrajectory):
        return arm.forward_kinematics(motion.positions)[0]
    return motion.positions

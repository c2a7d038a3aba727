"""Onto a motion and off it: to the first sample from where the arm is, to rest after the last."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from leadthrough.arm import Arm
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput, LimitsInfeasible, NoPath
from leadthrough.guard.admission import CommandedState
from leadthrough.guard.chunks import chunk_of
from leadthrough.guard.joining import LANDING, joined_at_start
from leadthrough.guard.rules import HISTORY, Contact, Rules, history_of, rules_for
from leadthrough.guard.writing import from_state
from leadthrough.motion import JointTrajectory
from leadthrough.shapes import SceneLike, as_scene

_TURN = 2.0 * np.pi  # rad
_SAME_PLACE = 1e-9  # m, of the tip


def connect(
    state: CommandedState | ArrayLike,
    trajectory: JointTrajectory,
    arm: Arm,
    scene: SceneLike = (),
) -> JointTrajectory:
    """The motion from the arm's present state on: eased into at its start, and to rest at its end.

    The way onto the first sample is straight for an arm at rest and a sample at rest, and as short
    as the limits of position, velocity, acceleration and jerk allow; after the last sample the arm
    brakes as fast as it may. Both are certified to be clear between samples. Joints that may turn
    further take the whole turns that bring the motion nearest to the state. The samples themselves
    stay as they are, but for these turns; `lt.Guard` and `Arm.check` judge them.

    Args:
        state: what is commanded now: a `CommandedState`, or positions (joints,) at which the arm
            rests.
        trajectory: with the arm's joints. Samples that are not evenly spaced are put on a clock
            with their shortest step.
        arm: the arm; all limits of its joints have to be known.
        scene: the obstacles, `MovingObstacle`s with a bound on their speed, and the margins.

    Returns:
        The whole motion, with the state as its first sample, at time 0. Its events keep their
        places on the trajectory.

    Raises:
        InvalidInput: if an argument has another shape, or a limit is not known.
        LimitsInfeasible: if no way inside the limits leads onto the trajectory, or to rest.
        NoPath: if the way would come too near something; `reason` is "ease_in" or "ease_out".
    """
    if not isinstance(trajectory, JointTrajectory):
        raise InvalidInput(
            f"trajectory: expected a JointTrajectory, got {type(trajectory).__name__}"
        )
    if len(trajectory.times) < 2:
        raise InvalidInput("trajectory: expected at least two samples, got one")
    period = float(np.diff(trajectory.times).min())
    rules = rules_for(arm, as_scene(scene), period)
    history = history_of(state, len(arm.joint_names), period)
    chunk = chunk_of(trajectory, arm, period)
    rows = _unwrapped(chunk.rows, history[-1], arm)
    ease = _ease_in(rules, history, rows)
    ended = np.concatenate([history, ease, rows])
    way = rules.braked(ended[-HISTORY:], rows[:0])
    if way is None:
        raise _infeasible(rules, ended[-HISTORY:], "to rest after the last sample")
    if found := rules.contact(ended[-HISTORY:], way.rows, 0.0):
        raise _blocked(found, "ease_out", "braking after the last sample")
    commands = np.concatenate([history[-1:], ease, rows, way.rows])
    shift = period * (1 + len(ease)) - chunk.start
    events = tuple(replace(each, time=each.time + shift) for each in chunk.events)
    return from_state(history[-2], commands, names=arm.joint_names, period=period, events=events)


def _ease_in(rules: Rules, history: Float64Array, rows: Float64Array) -> Float64Array:
    resting = max(0, LANDING - len(rows))
    target = np.concatenate([rows, np.repeat(rows[-1:], resting, axis=0)])
    joined = joined_at_start(rules, history, target)
    if joined is None:
        raise _infeasible(rules, history, "onto the first sample")
    ease = joined[0]
    if found := rules.contact(history, np.concatenate([ease, rows[:1]]), 0.0):
        raise _blocked(found, "ease_in", "the way onto the first sample")
    return ease


def _unwrapped(rows: Float64Array, now: Float64Array, arm: Arm) -> Float64Array:
    """The samples, each joint by whole turns nearer to where it is now."""
    result = rows.copy()
    for joint in range(rows.shape[1]):
        turned = now.copy()
        turned[joint] += _TURN
        here, there = (arm.forward_kinematics(q)[0] for q in (now, turned))
        if np.abs(here - there).max() > _SAME_PLACE:
            continue  # a prismatic joint
        low = np.ceil((arm.limits.lower[joint] - rows[:, joint].min()) / _TURN - _SAME_PLACE)
        high = np.floor((arm.limits.upper[joint] - rows[:, joint].max()) / _TURN + _SAME_PLACE)
        turns = np.round((now[joint] - rows[0, joint]) / _TURN)
        if low <= high:
            result[:, joint] += _TURN * np.clip(turns, low, high)
    return result


def _infeasible(rules: Rules, history: Float64Array, where: str) -> LimitsInfeasible:
    _, _, joint, _ = rules.stop_excess(history) or (0, 0, 0, 0.0)
    name = rules.joints.joint_names[joint]
    return LimitsInfeasible(
        f"no motion inside the limits leads {where}; the joint nearest its limits is {name}",
        joint=name,
    )


def _blocked(found: Contact, reason: str, what: str) -> NoPath:
    assert found.bodies is not None  # all of the way was looked at
    return NoPath(
        f"{what} is not clear: {' and '.join(found.bodies)} come too near; move the arm elsewhere "
        "first; in Python, `leadthrough.whole_arm.way_between` finds a way",
        reason=reason,
    )

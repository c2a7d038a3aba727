"""Motions after a push of the tool, each model by its own online call.

- `DMP`: `step(measured=)`, then `step` to the end of its motion.
- `FastMarching` and the dynamical systems: the `step` of their policy from the pushed tool.
- `ProMP`: `condition` on the pushed tool at the present time.
- `GMR`, `AlignedMean` and others: `corrected`, so that the present point is the pushed one.

Peers have a method `pushed`. The push comes when a model has covered a fraction of its own path.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.models import DynamicalSkill, FastMarchingSkill
from leadthrough.motion import Motion, Target
from leadthrough.preprocess.resample import arc_length

# A model's next target, a period later: from a measured tool, or from its own last target.
Call: TypeAlias = Callable[[Any], Any]

_STEPS = 200  # per duration of the motion
_MAX_DURATIONS = 10  # of a policy that has no clock
_AT_REST = 1e-4  # of the motion's extent per step: such a policy has ended
_CORRECTED = 0.95  # fraction of the path after which a motion is not changed any more
# Gain of phase stopping: with a tool held a tenth of the motion's size away, the phase runs at a
# tenth of its pace.
_WAITING = 900.0


def after_push(
    skill: Any,
    *,
    start: Target,
    goal: Target | None,
    at: float,
    place: Target,
    held: float = 0.0,
) -> Float64Array:
    """Positions (n, d) from a pushed tool to the end of the motion.

    Args:
        skill: of a model of the package, or of a peer with `pushed`.
        start: of the motion that is pushed.
        goal: of the motion; None for the skill's own.
        at: fraction of the skill's own path that is covered when the push comes.
        place: position, or for poses position and orientation, to which the tool is pushed.
        held: time for which it is held there, in durations; only a skill with a clock of its own
            behaves differently then: a `DMP` waits by its `lag`.
    """
    query = {"start": start, "goal": goal}
    if hasattr(skill, "pushed"):
        return np.asarray(skill.pushed(**query, at=at, place=place))
    own = skill.generate(**query)
    now = time_at(own, at)
    if hasattr(skill, "begin"):
        return _stepped(skill, skill.step(skill.begin(**query), now), place, own, held)
    if policy := _policy(skill, goal):
        return _led(_of_policy(policy, place, own.duration / _STEPS), place, own)
    return rest(_corrected(skill, now, place, query), now, place)


def online_call(skill: Any, *, start: Target, goal: Target | None, period: float) -> Call:
    """The online call of a model of the package, from the start of its motion on.

    Args:
        skill: the model's.
        start: of the motion.
        goal: of the motion; None for the skill's own.
        period: between calls, s.
    """
    query = {"start": start, "goal": goal}
    if hasattr(skill, "begin"):
        return _of_primitive(skill, skill.begin(**query), period)
    if policy := _policy(skill, goal):
        return _of_policy(policy, start, period)
    return _of_motion(skill, query, period)


def _policy(skill: Any, goal: Target | None) -> Callable[[Any, float], Any] | None:
    """The tool after some time, s, from another; None for a model without a policy."""
    if isinstance(skill, FastMarchingSkill):
        step = skill.policy_to(None if goal is None else _position(goal)).step
        return lambda tool, dt: step(_position(tool), dt)
    if isinstance(skill, DynamicalSkill):
        return lambda tool, dt: skill.step(tool, dt, goal=goal)
    return None


def _of_primitive(skill: Any, state: Any, period: float) -> Call:
    def call(measured: Any) -> Any:
        nonlocal state
        state = skill.step(state, period, measured=measured)
        turned = getattr(state, "orientation", None)
        return state.position if turned is None else (state.position, turned)

    return call


def _of_policy(policy: Callable[[Any, float], Any], tool: Any, period: float) -> Call:
    def call(measured: Any) -> Any:
        nonlocal tool
        tool = policy(tool if measured is None else measured, period)
        return tool

    return call


def _of_motion(skill: Any, query: dict[str, Any], period: float) -> Call:
    motion, now = skill.generate(**query), 0.0
    last = time_at(motion, _CORRECTED)

    def call(measured: Any) -> Any:
        nonlocal motion, now
        if measured is not None and now < last:
            motion = _corrected(skill, now, measured, query)
        now += period
        return motion.at(min(motion.times[0] + now, motion.times[-1]))

    return call


def _corrected(skill: Any, now: float, place: Target, query: dict[str, Any]) -> Motion:
    """The motion of a model without steps that is at a place at a time, s, from its start."""
    if hasattr(skill, "condition"):
        return skill.condition(now, place).generate(goal=query["goal"])  # type: ignore[no-any-return]
    return skill.corrected(now, place, **query).generate(**query)  # type: ignore[no-any-return]


def time_at(motion: Motion, fraction: float) -> float:
    """The time, s, from its start, at which a motion has covered a fraction of its path."""
    covered = arc_length(motion.positions)
    return float(np.interp(fraction, covered / covered[-1], motion.times - motion.times[0]))


def rest(motion: Motion, now: float, place: Target) -> Float64Array:
    """Positions (n, d) of a motion after a time, s, headed by the tool's."""
    later = motion.times - motion.times[0] > now
    return np.vstack([_position(place), motion.positions[later]])


def faded_rest(motion: Motion, at: float, place: Target) -> Float64Array:
    """Positions (n, d) of a motion from a fraction of its path on, shifted by a push that fades."""
    path = rest(motion, time_at(motion, at), motion.at(motion.times[0] + time_at(motion, at)))
    left = 1.0 - arc_length(path) / arc_length(path)[-1]
    return np.asarray(path + left[:, None] * (_position(place) - path[0]))


def _stepped(skill: Any, state: Any, place: Target, own: Motion, held: float) -> Float64Array:
    """A primitive with a clock, which goes on from the measured tool."""
    step = own.duration / _STEPS
    size = float(np.linalg.norm(own.positions - own.positions[-1], axis=1).max())
    for _ in range(round(held * _STEPS)):
        away = float(np.linalg.norm(state.position - _position(place))) / size
        state = skill.step(state, step, lag=_WAITING * away**2)
    path = [_position(place)]
    state = skill.step(state, step, measured=place)
    while True:
        path.append(state.position)
        if state.phase >= 1.0:
            return np.array(path)
        state = skill.step(state, step)


def _led(call: Call, place: Target, own: Motion) -> Float64Array:
    """A policy without a clock, followed until it comes to rest."""
    slow = _AT_REST * float(np.ptp(own.positions, axis=0).max())
    path = [_position(place)]
    for _ in range(_MAX_DURATIONS * _STEPS):
        path.append(_position(call(None)))
        if np.linalg.norm(path[-1] - path[-2]) < slow:
            break
    return np.array(path)


def _position(target: Any) -> Float64Array:
    """The position (d,) of a target."""
    return np.asarray(target[0] if isinstance(target, tuple) else target)

"""A motion with transitions from the arm's state to its start, and to rest after its end."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough.arm import Arm, DualArm, check_arms
from leadthrough.check import Float64Array, InvalidInput, LimitsInfeasible, NoPath
from leadthrough.guard.admission import Chunk, CommandedState, chunk_of, trajectory as motion_of
from leadthrough.guard.rules import Contact, Rules, row_of, rules_for
from leadthrough.motion import JointTrajectory, in_order
from leadthrough.shapes import SceneLike, as_scene

_TURN = 2.0 * np.pi  # rad
_SAME_PLACE = 1e-9  # m, of the tip


def connect(
    state: CommandedState | ArrayLike,
    trajectory: JointTrajectory,
    arm: Arm | DualArm,
    scene: SceneLike = (),
) -> JointTrajectory:
    """The motion from the arm's present state on: eased into at its start, and to rest at its end.

    The bridge onto the first sample is straight for an arm and a sample at rest, and as short
    as the limits of position, velocity, acceleration and jerk allow; after the last sample the arm
    brakes as fast as it may. Both are certified to be clear between samples. Joints that may turn
    further take the whole turns that bring the motion nearest to the state. The samples themselves
    stay as they are, but for these turns; `lt.Guard` and `Arm.check` judge them. If they carry no
    accelerations, their rates are those of the parabolas through three samples.

    Args:
        state: commanded now: a `CommandedState`, or positions (joints,) at which the arm rests.
        trajectory: with the arm's joints. Samples that are not evenly spaced are put on a clock
            with their shortest step.
        arm: the arm; all limits of its joints have to be known.
        scene: the obstacles, `MovingObstacle`s with a bound on their speed, and the margins.

    Returns:
        The whole motion, with the state as its first sample, at time 0. Its events keep their
        places on the trajectory.

    Raises:
        InvalidInput: if a limit is not known.
        LimitsInfeasible: if no bridge inside the limits leads onto the trajectory, or to rest.
        NoPath: if the bridge would come too near something; `reason` is "ease_in" or "ease_out".
    """
    check_arms(arm)
    trajectory = in_order(trajectory, arm.joint_names, "trajectory")
    if len(trajectory.times) < 2:
        raise InvalidInput("trajectory: expected at least two samples, got one")
    period = float(np.diff(trajectory.times).min())
    rules = rules_for(arm, as_scene(scene), period)
    start = row_of(state, len(arm.joint_names))
    chunk = chunk_of(trajectory, arm, period)
    rows = _states(chunk, _unwrapped(chunk.rows, start[0, : len(arm.joint_names)], arm), period)
    ease = _ease_in(rules, start, rows)
    stopping = rules.braked(rows[-1:], rows[:0])
    if stopping is None:
        raise _infeasible(rules, rows[-1:], "to rest after the last sample")
    if found := rules.contact(rows[-1:], stopping.rows, 0.0):
        raise _blocked(found, "ease_out", "braking after the last sample")
    commands = np.concatenate([start, ease, rows, stopping.rows])
    shift = period * (1 + len(ease)) - chunk.start
    events = tuple(replace(each, time=each.time + shift) for each in chunk.events)
    times = period * np.arange(len(commands), dtype=np.float64)
    return motion_of(times, commands, arm.joint_names, events)


def _states(chunk: Chunk, positions: Float64Array, period: float) -> Float64Array:
    """The chunk's states at positions that differ from its own by whole turns."""
    joints = positions.shape[1]
    if chunk.states is not None:
        return np.hstack([positions, chunk.states[:, joints:]])
    return replace(chunk, rows=positions).following(np.empty((0, 3 * joints)), period)


def _ease_in(rules: Rules, start: Float64Array, rows: Float64Array) -> Float64Array:
    joined = joined_at_start(rules, start, rows)
    if joined is None:
        raise _infeasible(rules, start, "onto the first sample")
    ease = joined[0]
    if found := rules.contact(start, np.concatenate([ease, rows[:1]]), 0.0):
        raise _blocked(found, "ease_in", "the bridge onto the first sample")
    return ease


def _unwrapped(rows: Float64Array, now: Float64Array, arm: Arm | DualArm) -> Float64Array:
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


def _infeasible(rules: Rules, start: Float64Array, where: str) -> LimitsInfeasible:
    _, _, joint, _ = rules.stop_excess(start) or (0, 0, 0, 0.0)
    name = rules.joints.joint_names[joint]
    return LimitsInfeasible(
        f"no motion inside the limits leads {where}; the joint nearest its limits is {name}",
        joint=name,
    )


def _blocked(found: Contact, reason: str, what: str) -> NoPath:
    assert found.bodies is not None  # the whole bridge was checked
    return NoPath(
        f"{what} is not clear: {' and '.join(found.bodies)} come too near; move the arm elsewhere "
        "first; in Python, `leadthrough.motion_planning.connect_configurations` finds a path",
        reason=reason,
    )


_JUMP = 3.0  # times its neighbours a step is longer that is a jump
_EASED = (1.0, 0.9)  # rates of a path that is followed from another pace on
_MAX_STRETCH = 10  # factor by which a piece may be stretched


@dataclass(frozen=True, eq=False)
class Changed:
    """Rows inside the limits."""

    rows: Float64Array  # (n, 3 joints)
    places: Float64Array  # which sample of the chunk each is, with fractions in between, (n,)
    complete: bool  # whether they lead to the end of the chunk


def changed(rules: Rules, start: Float64Array, samples: Float64Array) -> Changed:
    """The samples (n, joints), brought inside the limits."""
    lower, upper = rules.joints.lower, rules.joints.upper
    if (samples.min(axis=0) < lower).any() or (samples.max(axis=0) > upper).any():
        samples = np.clip(samples, lower, upper)  # of a long log, a copy is as large as the log
    rows, places = [start], [np.full(1, -1.0)]
    complete = True
    for first, end in pairwise(_pieces(samples, rules.joints.velocity * rules.period)):
        if end - first < _SHORT_PIECE and end < len(samples):
            continue
        last = rows[-1][-1:]
        run = _paced(rules, last, samples[first:end])
        if run is None:
            complete = False
            break
        target, at = run
        joined = None if first else joined_on_time(rules, last, target)
        if joined is None and not first and not _jumps(rules, last, target):
            along = _from_here(rules, last, samples[:end]) or _through_rest(rules, last, run)
            if along is None:
                complete = False
                break
            rows, places = [*rows, along[0]], [*places, along[1]]
            continue
        joined = joined or joined_at_start(rules, last, target)
        if joined is None:
            complete = False
            break
        bridge, skipped = joined
        at = np.minimum(first + at, end - 1.0)[skipped:]
        since = float(places[-1][-1])
        between = since + (at[0] - since) * np.arange(1, len(bridge) + 1) / (len(bridge) + 1)
        rows += [bridge, target[skipped:]]
        places += [between, at]
    return Changed(np.concatenate(rows)[1:], np.concatenate(places)[1:], complete)


def _paced(
    rules: Rules, last: Float64Array, piece: Float64Array
) -> tuple[Float64Array, Float64Array] | None:
    """A piece inside the limits of its rates, and its places; None if it is out of reach."""
    if beyond_reach(rules, last, piece):
        return None
    none = np.empty((0, last.shape[1]))
    path = Chunk(piece, 0.0).following(none, rules.period)
    return core.slowed(rules.limits, path, _MAX_STRETCH * max(_SHORT_PIECE, len(path)))


def _jumps(rules: Rules, start: Float64Array, target: Float64Array) -> bool:
    """Whether the first of some states is farther than a step."""
    joints = len(rules.joints.joint_names)
    away = np.abs(target[0, :joints] - start[0, :joints])
    return bool((away > rules.period * rules.joints.velocity).any())


def _from_here(
    rules: Rules, start: Float64Array, piece: Float64Array
) -> tuple[Float64Array, Float64Array] | None:
    """A piece from the present position on, at the pace of the state first; and its places."""
    joints = piece.shape[1]
    run = _paced(rules, start, np.concatenate([start[:, :joints], piece]))
    if run is None:
        return None
    path, at = run
    eased = [found for rate in _EASED if (found := core.eased(rules.limits, start, path, rate))]
    if not eased:
        return None
    rows, places = max(eased, key=lambda found: float(found[1][-1]))
    return rows, np.interp(places, np.arange(len(at)), at) - 1.0


def _through_rest(
    rules: Rules, start: Float64Array, run: tuple[Float64Array, Float64Array]
) -> tuple[Float64Array, Float64Array] | None:
    """A paced piece with a rest at its first sample; and its places."""
    target, at = run
    rest = target[:1].copy()
    rest[:, len(rules.joints.joint_names) :] = 0.0
    joined = joined_at_start(rules, start, rest)
    if joined is None:
        return None
    parts, places = [joined[0], rest], [np.linspace(-1.0, 0.0, len(joined[0]) + 2)[1:]]
    if (eased := core.eased(rules.limits, rest, target, 1.0)) is not None:
        parts.append(eased[0])
        places.append(np.interp(eased[1], np.arange(len(at)), at))
    return np.concatenate(parts), np.concatenate(places)


def _pieces(samples: Float64Array, step: Float64Array) -> list[int]:
    """Starts of the pieces without jumps, and the end of the last one."""
    steps = np.abs(np.diff(samples, axis=0))
    padded = np.pad(steps, ((1, 1), (0, 0)))
    beside = np.maximum(padded[:-2], padded[2:])
    jumps = ((steps > step) & (steps > _JUMP * beside)).any(axis=1)
    return [0, *(np.flatnonzero(jumps) + 1).tolist(), len(samples)]


_SHORT_PIECE = 3  # samples: fewer between two jumps are left out
_MAX_BRIDGE = 10.0  # s
# A bridge over at most this fraction of the samples keeps to their clock.
_ON_TIME = 0.25

# Rows of the bridge, and the number of samples that it skips.
Joined = tuple[Float64Array, int]


def beyond_reach(rules: Rules, last: Float64Array, target: Float64Array) -> bool:
    """Whether a joint is too far from a target (n, joints) for any bridge, however slow."""
    periods = 2 * _most_periods(rules) + len(target)
    away = np.abs(target[0] - last[0, : target.shape[1]])
    return bool((away > periods * rules.period * rules.joints.velocity).any())


def joined_on_time(rules: Rules, start: Float64Array, target: Float64Array) -> Joined | None:
    """The shortest bridge onto a sample when that is due; the first is due a period from now."""
    soon = max(1, int(_ON_TIME * len(target)))
    return core.bridge_on_time(rules.limits, start, target, soon)


def joined_at_start(rules: Rules, start: Float64Array, target: Float64Array) -> Joined | None:
    """The shortest bridge onto the first sample; if none is short, one with a rest."""
    longest = _most_periods(rules)
    found = core.bridge_to_start(rules.limits, start, target, longest)
    if found is not None:
        return found
    stopping = rules.braked(start, target[:0])
    if stopping is None:
        return None
    found = core.bridge_to_start(rules.limits, stopping.rows[-1:], target, longest)
    if found is None:
        return None
    return np.concatenate([stopping.rows, found[0]]), found[1]


def _most_periods(rules: Rules) -> int:
    return max(1, round(_MAX_BRIDGE / rules.period))

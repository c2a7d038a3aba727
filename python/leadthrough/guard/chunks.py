"""Chunks of a policy's actions, followed at the rate of a control loop.

A chunk is the uniform cubic B-spline whose control points are its actions: its acceleration is
continuous, it stays in the hull of its actions, so that limits of position and velocity that these
keep hold between them too, it has no lag, and it passes 1/6 of their second difference beside them.
It begins and ends on its first and its last action. A chunk takes over from another, from rest or
after periods that were missed, by the difference between the state commanded and the chunk, which
each joint ends by the fastest motion of bounded jerk that the chunk's own rates leave room for.
Nothing jumps up to the acceleration, and the chunk's own timing is kept.

Source: de Boor 1978, "A Practical Guide to Splines".
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check
from leadthrough.arm import Arm, JointLimits
from leadthrough.arm.limits import known_rates
from leadthrough.check import Float64Array, InvalidInput, ShortRepr
from leadthrough.guard.admission import Admission, CommandedState, trajectory
from leadthrough.guard.guard import Guard
from leadthrough.guard.rules import row_of, step_limits

Kind = Literal["absolute", "relative", "delta"]
_WINDOW = 0.25  # s of a chunk that are admitted at a time
_MAX_ROWS = 256  # of them, so that the answer takes a millisecond
_MEMORY = 2.0  # s of commands that are remembered, for relative actions
_USES = (0.98, 0.9, 0.7)  # of the limits in a join, until they are kept between commands too
_GENTLE = 0.5  # of the limits that a stop at the end of a chunk uses, if that is enough
_JITTER = 0.005  # s that a call may be off its time, if the half of a period is less
_DRIFT = 0.01  # of what a call is off its time that is followed at once
_PASSED = 3  # poses before now that the curve needs
_MAX_PASSES = 4  # of smoothing
_ROOM = 0.7  # of the limits: a chunk that uses more is smoothed
_FOLLOWED = 0.95  # of the limits that a chunk may use, so that it can be joined


class Chunks(ShortRepr):
    """Follows a policy's chunks of joint actions at the rate of a control loop, through a guard.

        chunks = lt.guard.Chunks(lt.Guard(arm, scene, rate=1000.0), rate=30.0)
        chunks.start(robot.q, clock())
        while running:
            if (new := policy.newest()) is not None:
                chunks.put(new.actions, new.observed_at)
            robot.send(chunks.next(clock()).q)

    Chunks may come at any time: late (actions that were due before are left out), overlapping (the
    one observed last is followed from its own time on), or with gaps. A chunk takes over without a
    step in velocity or acceleration; each joint catches up as fast as its limits allow. A chunk
    beyond the limits is slowed down, and the next one catches up. Everything is admitted by the
    guard. If no chunk comes, the arm stops on the path of the last one, at its end. If `next` was
    not called for some periods, the arm goes on from its last command and catches up.

    Args:
        guard: of the arm and its scene, at the loop's rate.
        rate: actions per second, 0.1 to 1e4.
        actions: "absolute" joint positions; "relative", all from the joints at the chunk's time;
            "delta", each from the one before it, the first from the joints at the chunk's time.
        join: duration in s, > 0, in which the difference to a new chunk ends; longer where the
            limits demand it.
    """

    def __init__(
        self, guard: Guard, *, rate: float, actions: Kind = "absolute", join: float = 0.2
    ) -> None:
        self._guard = guard
        self._step = 1.0 / check.number(rate, "rate", at_least=0.1, at_most=1e4)
        self._kind = check.choice(actions, "actions", get_args(Kind))
        self._join = check.number(join, "join", above=0.0)
        self._period = 1.0 / guard.rate
        limits = guard.arm.limits
        gentle = {name: _GENTLE * getattr(limits, name) for name in ("acceleration", "jerk")}
        self._gentle = replace(limits, **gentle)
        self._rows = max(16, min(_MAX_ROWS, round(_WINDOW * guard.rate)))
        self._sent: deque[tuple[float, Float64Array]] = deque(maxlen=round(_MEMORY * guard.rate))
        self._time: float | None = None
        self._waiting: dict[float, ChunkCurve] = {}  # by when they were observed, s
        self._curve: ChunkCurve | None = None  # the one that is followed
        self._observed = -np.inf  # when it was observed, s
        self._again = np.inf  # when more of it is admitted, s
        self._jerk = np.zeros(0)  # (joints,) by which the difference to it ends
        self._answer: Admission | None = None

    @property
    def guard(self) -> Guard:
        """The guard."""
        return self._guard

    @property
    def answer(self) -> Admission | None:
        """The guard's last answer; None before the first chunk."""
        return self._answer

    @property
    def time(self) -> float:
        """Time of the last command, s.

        Raises:
            InvalidInput: if it has not been started.
        """
        if self._time is None:
            raise InvalidInput("chunks: expected `start` with the joints before the first action")
        return self._time

    @property
    def lag(self) -> float:
        """Time in s by which the arm is behind the policy's own timing; 0 where limits allow."""
        return 0.0 if self._curve is None else self._curve.lag(self.time)

    def start(self, q: ArrayLike, time: float = 0.0) -> None:
        """Begins, at rest; again after the arm was moved by something else.

        Args:
            q: joint positions (joints,) commanded now, in rad (m).
            time: now, s on the clock that chunks are stamped with.
        """
        self._time = check.number(time, "time")
        q = check.array(q, "q", shape=(len(self._guard.arm.joint_names),))
        self._answer = self._guard.admit(q[None], q)
        self._sent.clear()
        self._sent.append((self._time, q))
        self._waiting, self._curve, self._observed = {}, None, -np.inf

    def put(self, actions: ArrayLike, time: float, *, measured: ArrayLike | None = None) -> int:
        """Takes over a chunk.

        Args:
            actions: (n, joints) in rad (m), the first due at `time`. A chunk with NaN or infinity
                is left out, and the arm follows what came before.
            time: when it was observed, s.
            measured: joint positions (joints,) at `time`, for relative and delta actions; by
                default the command that was sent then.

        Returns:
            Number of its actions that are still due; at 0 it came too late, was observed before
            the one that is followed, or is not finite, and is left out.
        """
        rows = check.with_gaps(actions, "actions", shape=("n", len(self._guard.arm.joint_names)))
        stamp, base = check.number(time, "time"), None
        if measured is not None:
            base = check.array(measured, "measured", shape=rows.shape[1:])
        if not self._due(stamp, len(rows)) or not np.isfinite(rows).all():
            return 0
        return self._take(self._absolute(rows, stamp, base), stamp, stamp)

    def put_poses(self, positions: ArrayLike, orientations: ArrayLike, time: float) -> int:
        """Takes over a chunk of poses of the tip, by the configurations nearest to each other.

        Args:
            positions: (n, 3) in m, base frame, the first due at `time`.
            orientations: (n, 4) w, x, y, z.
            time: when it was observed, s.

        Returns:
            Number of its actions that are still due. The chunk ends before the first pose that is
            out of reach; at 0 it is left out, as by `put`.
        """
        arm = self._guard.arm
        if not isinstance(arm, Arm):
            raise InvalidInput("guard: expected one arm for poses of its tip, got two; use `put`")
        places = check.with_gaps(positions, "positions", shape=("n", 3))
        turns = check.with_gaps(orientations, "orientations", shape=(len(places), 4))
        stamp = check.number(time, "time")
        due = self._due(stamp, len(places))
        if not due or not (np.isfinite(places).all() and np.isfinite(turns).all()):
            return 0
        first = max(0, len(places) - due - _PASSED)
        q, rows = self._command_at(stamp), []
        for place, turn in zip(places[first:], turns[first:], strict=True):
            found = arm.inverse_kinematics(place, turn, q0=q)
            if not found.success:
                break
            q = found.q
            rows.append(q)
        start = stamp + first * self._step
        return self._take(np.array(rows), start, stamp) if self._due(start, len(rows)) else 0

    def stop(self) -> Admission:
        """Brakes now, and forgets all chunks."""
        self._waiting, self._curve, self._observed = {}, None, -np.inf
        self._answer = self._guard.stop()
        return self._answer

    def next(self, time: float | None = None) -> CommandedState:
        """Advances by one period; the state to command now.

        Args:
            time: now, s; by default a period after the last call.
        """
        due = self.time + self._period
        now = due if time is None else check.number(time, "time")
        missed = abs(now - due) > max(0.5 * self._period, _JITTER)
        if not missed:
            now = due + _DRIFT * (now - due)  # drift is followed, jitter is not
        self._time = now
        begun = [stamp for stamp, each in self._waiting.items() if each.start <= now]
        if begun:
            self._observed = max(begun)
            self._curve = self._waiting[self._observed].slowed(now, self._guard.arm.limits)
            later = [stamp for stamp in self._waiting if stamp > self._observed]
            self._waiting = {stamp: self._waiting[stamp] for stamp in later}
        if self._curve is not None and (begun or missed or now >= self._again):
            self._follow(self._curve, now, joining=bool(begun) or missed)
        state = self._guard.next()
        self._sent.append((now, state.q))
        return state

    def _due(self, stamp: float, count: int) -> int:
        due = stamp + self._step * np.arange(count) > self.time
        return int(np.count_nonzero(due)) if stamp >= self._observed else 0

    def _take(self, rows: Float64Array, start: float, observed: float) -> int:
        """Waits for a chunk of joint positions to begin."""
        limits = self._guard.arm.limits
        rows = smoothed(np.clip(rows, limits.lower, limits.upper), self._step, limits)
        self._waiting[observed] = ChunkCurve.of(rows, start, self._step)
        return self._due(start, len(rows))

    def _absolute(
        self, rows: Float64Array, stamp: float, base: Float64Array | None
    ) -> Float64Array:
        if self._kind == "absolute":
            return rows
        base = self._command_at(stamp) if base is None else base
        return base + (rows if self._kind == "relative" else np.cumsum(rows, axis=0))

    def _command_at(self, time: float) -> Float64Array:
        """The command (joints,) that was sent at a time, or nearest to it."""
        return min(self._sent, key=lambda sent: abs(sent[0] - time))[1]

    def _follow(self, curve: ChunkCurve, now: float, *, joining: bool) -> None:
        """Admits a window of the curve, the first row for now."""
        last = now - self._period
        if now > curve.end and not joining:
            self._again = np.inf  # the rest is admitted already
            return
        present = row_of(self._guard.state, len(self._guard.arm.joint_names))
        target = self._target(curve, last)
        if joining:
            self._jerk = needed_jerk(present - target[:1], self._join)
        # Also for the rest that may be left after the curve.
        jerk = np.maximum(self._jerk, needed_jerk(np.diff(target[-2:], axis=0), self._join))
        for use in _USES:
            rows = core.joined(self._guard._rules.limits, present, target, jerk, use)
            if self._guard._rules.excess(present, rows) is None:
                break
        times = last + self._period * np.arange(1, len(rows) + 1, dtype=np.float64)
        self._answer = self._guard.admit(trajectory(times, rows, self._guard.arm.joint_names))
        whole = last + self._period * self._rows >= curve.end - self._period
        done = self._answer.verdict == "allowed" and whole
        self._again = np.inf if done else now + 0.5 * self._period * self._rows

    def _target(self, curve: ChunkCurve, last: float) -> Float64Array:
        """States of the curve from the last command on; at its end a stop on its path, and rest."""
        count = min(self._rows, int((curve.end - last) / self._period + 1e-9))
        since = self._period * np.arange(max(0, count) + 1, dtype=np.float64)
        states = curve.states(np.minimum(last + since, curve.end))
        if count == self._rows:
            return states
        gentle = step_limits(self._gentle, self._period)
        for limits in (gentle, self._guard._rules.limits) if count > 0 else ():
            if (stopped := core.stopped(limits, states[:1], states[1:])) is not None:
                states = np.concatenate([states[:1], stopped[0]])
                break
        rest = states[-1:].copy()
        rest[:, len(self._guard.arm.joint_names) :] = 0.0
        return np.concatenate([states, rest])


@dataclass(frozen=True, eq=False)
class ChunkCurve:
    """The B-spline of a chunk."""

    start: float  # s
    step: float  # s, between actions
    points: Float64Array  # (n + 2, joints); the first and the last one continue the chunk straight
    own: tuple[float, float] | None = None  # start and step of the policy, if this is slower

    @staticmethod
    def of(rows: Float64Array, start: float, step: float) -> ChunkCurve:
        padded = np.concatenate([rows[:1], rows, rows[-1:]])
        if len(rows) > 1:
            padded[0] += rows[0] - rows[1]
            padded[-1] += rows[-1] - rows[-2]
        return ChunkCurve(start, step, padded)

    @property
    def end(self) -> float:
        return self.start + self.step * (len(self.points) - 3)

    def slowed(self, now: float, limits: JointLimits) -> ChunkCurve:
        """The curve, from now on as much slower as its control points demand."""
        now = max(now, self.start)
        left = self.points[max(0, int((now - self.start) / self.step)) :]
        uses = enumerate(_uses(left, self.step, limits), 1)
        slower = max(1.0, *((used / _FOLLOWED) ** (1.0 / order) for order, used in uses))
        if slower == 1.0:
            return self
        start = now - (now - self.start) * slower
        return ChunkCurve(start, self.step * slower, self.points, (self.start, self.step))

    def lag(self, now: float) -> float:
        """How far it is behind the policy's own timing, s."""
        if self.own is None:
            return 0.0
        start, step = self.own
        return float(now - start - step * (min(now, self.end) - self.start) / self.step)

    def states(self, times: Float64Array) -> Float64Array:
        """States (n, 3 joints) at times up to its end."""
        place = (times - self.start) / self.step
        piece = np.clip(place.astype(np.intp), 0, max(0, len(self.points) - 4))
        u = (place - piece)[:, None]
        near = np.minimum(piece[:, None] + np.arange(4), len(self.points) - 1)
        a, b, c, d = self.points[near].transpose(1, 0, 2)
        v = 1.0 - u
        q = (a * (v * v * v) + b * (4.0 - 3.0 * u * u * (1.0 + v)) + d * (u * u * u)) / 6.0
        q += c * (4.0 - 3.0 * v * v * (1.0 + u)) / 6.0
        qd = ((b - a) * v * v + (c - b) * (1.0 + 2.0 * u * v) + (d - c) * u * u) / (2.0 * self.step)
        qdd = ((a - 2.0 * b + c) * v + (b - 2.0 * c + d) * u) / self.step**2
        return np.hstack([q, qd, qdd])


def needed_jerk(away: Float64Array, duration: float) -> Float64Array:
    """A jerk (joints,) by which a difference of states (1, 3 joints) ends in a duration, s."""
    # The sum of those by which a distance, a velocity and an acceleration end alone, by the fastest
    # motion that only the jerk limits.
    e, ed, edd = np.abs(away.reshape(3, -1))
    return np.asarray(32.0 * e / duration**3 + 27.0 * ed / duration**2 + 5.0 * edd / duration)


def smoothed(rows: Float64Array, step: float, limits: JointLimits) -> Float64Array:
    """Actions (n, joints) smoothed, without lag, until their B-spline keeps limits, or for long."""
    for _ in range(_MAX_PASSES):
        if max(_uses(rows, step, limits)) <= _ROOM or len(rows) < 3:
            break
        inner = (rows[:-2] + 2.0 * rows[1:-1] + rows[2:]) / 4.0
        rows = np.concatenate([rows[:1], inner, rows[-1:]])
    return rows


def _uses(points: Float64Array, step: float, limits: JointLimits) -> list[float]:
    """The largest fractions of the limits of velocity, acceleration and jerk of a B-spline."""
    return [
        float((np.abs(np.diff(points, order, axis=0)) / (limit * step**order)).max(initial=0.0))
        for order, limit in enumerate(known_rates(limits), 1)
    ]

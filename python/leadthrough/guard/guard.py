"""The gate before an arm: motions from anywhere go in, motions that may run come out."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from leadthrough import check
from leadthrough.arm import Arm, DualArm
from leadthrough.arm.limits import known_rates
from leadthrough.check import Float64Array, InvalidInput, ShortRepr
from leadthrough.guard.admission import (
    KINDS,
    Admission,
    Chunk,
    CommandedState,
    Kind,
    Reason,
    Verdict,
    chunk_of,
    moved_events,
    parts_of,
    trajectory,
)
from leadthrough.guard.connect import Changed, changed
from leadthrough.guard.rules import (
    ALL_WORK,
    Contact,
    Rules,
    StoppingTrajectory,
    guarded_scene,
    row_of,
    rules_for,
)
from leadthrough.motion import Event, JointTrajectory
from leadthrough.shapes import Obstacle, Scene, SceneLike, as_scene
from leadthrough.timing.request import InverseDynamics

_MIN_RATE, _MAX_RATE = 1.0, 1e4  # Hz
_CHANGED_PART = 16  # times as long a sample takes that has to be changed
# Pairs of shapes that are looked at for each sample of a chunk that has to be changed, and for how
# many samples at least: what bounds the time that an answer takes.
_WORK, _SHORT = 200, 50


class Guard(ShortRepr):
    """Admits chunks of joint motion to an arm: as they are, changed, or not at all.

        guard = lt.Guard(arm, scene, rate=50.0)
        guard.admit(chunk, state=q)                # whenever the policy has a new one
        while running:
            send(guard.next().q)                   # every period

    The commands still to come are always a motion that ends at rest, certified as a whole:
    inside the limits of position, velocity, acceleration and jerk, and clear by the margins between
    samples as well. A chunk only takes its place if there is such a motion that begins with it. So
    if chunks come late, or none comes any more, the arm follows what was admitted and brakes.

    The limits hold along the quintics through the commanded positions, velocities and
    accelerations, as `lt.check_limits` judges them. Nothing is random, and equal calls have equal
    answers.

    Args:
        arm: the arm, or a pair of arms; all limits of its joints have to be known.
        scene: the obstacles, `MovingObstacle`s with a bound on their speed, and the margins.
        rate: commands per second, 1 to 1e4.
        max_samples: samples of a chunk that are looked at, >= 16, so that the answer comes in time;
            of a chunk that has to be changed at most a sixteenth, and fewer where it has to run
            much more slowly. The rest is cut off, with the reason "cut short".
        inverse_dynamics: maps q, velocities and accelerations (n, joints) to efforts, such as
            `arm.motor_torques`, in which a payload counts; with it, the efforts of all commands
            satisfy their limits as well.

    Raises:
        InvalidInput: if a limit is not known.
        InvalidRobot: if the robot has no collision geometry, or a mesh is missing or flat.
    """

    def __init__(
        self,
        arm: Arm | DualArm,
        scene: SceneLike = (),
        *,
        rate: float,
        max_samples: int = 4096,
        inverse_dynamics: InverseDynamics | None = None,
    ) -> None:
        self._arm = arm
        self._torques = inverse_dynamics
        self._most = check.integer(max_samples, "max_samples", at_least=_CHANGED_PART)
        self._period = 1.0 / check.number(rate, "rate", at_least=_MIN_RATE, at_most=_MAX_RATE)
        self._scene = as_scene(scene)
        self._rules = rules_for(arm, self._scene, self._period, inverse_dynamics)
        self._age = 0.0  # periods since the obstacles were seen
        self._stream: Float64Array | None = None  # states; `_at` is that of the present command
        self._at = 0
        self._safe = True

    def __getstate__(self) -> dict[str, Any]:  # the rules are made again
        return {name: value for name, value in vars(self).items() if name != "_rules"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self._rules = rules_for(self._arm, self._scene, self._period, self._torques)

    @property
    def arm(self) -> Arm | DualArm:
        """The arm, or the pair of arms."""
        return self._arm

    @property
    def rate(self) -> float:
        """Commands per second."""
        return 1.0 / self._period

    @property
    def state(self) -> CommandedState:
        """The present command.

        Raises:
            InvalidInput: if no state was given yet.
        """
        q, qd, qdd = self._now().copy().reshape(3, -1)
        return check.computed(CommandedState, q=q, qd=qd, qdd=qdd)

    @property
    def safe(self) -> bool:
        """Whether the remaining commands are certified; see `Admission.safe`."""
        return self._safe

    @property
    def remaining(self) -> int:
        """Number of commands left until the arm rests."""
        return 0 if self._stream is None else len(self._stream) - 1 - self._at

    def next(self) -> CommandedState:
        """Advances by one period; the state to command now. After the last command the arm rests.

        Raises:
            InvalidInput: if no state was given yet.
        """
        self._now()
        if self.remaining:
            self._at += 1
        self._age += 1.0
        return self.state

    def admit(
        self,
        chunk: JointTrajectory | ArrayLike,
        state: CommandedState | ArrayLike | None = None,
    ) -> Admission:
        """Admits a chunk, which replaces all commands not sent yet.

        Args:
            chunk: joint motion whose first sample is due one period from now. A trajectory at
                another rate is put on the guard's clock; an array (n, joints) is on it. NaN and
                infinity in an array refuse the chunk, and the arm brakes.
            state: commanded now, if it differs from the last answer of `next`, as at the
                start: a `CommandedState`, or positions (joints,) at which the arm rests.

        Raises:
            InvalidInput: if the first call has no state. Motions admitted before then stay.
        """
        given = chunk_of(chunk, self._arm, self._period, most=self._most)
        if state is not None:
            self._start(state)
        times = given.start + self._period * np.arange(len(given.rows), dtype=np.float64)
        wrong = not_finite(given.rows, self._arm.joint_names, times)
        if wrong is not None:
            return self._braking((wrong,), start=given.start)
        reasons: tuple[Reason, ...] = ()
        if given.resampled:
            reasons = (Reason("resampled", given.start),)
        now = self._now()
        rows = given.states
        if rows is None or self._rules.excess(now, rows) is not None:
            rows = given.following(now, self._period)
        if (worst := self._rules.excess(now, rows)) is None:
            reasons += _cut_off(given, times)
            stopping, contact = self._looked_at(rows, ALL_WORK)
            if stopping is not None and contact is None:
                del rows  # of a long log, as large as the log
                verdict: Verdict = "changed" if reasons else "allowed"
                return self._admitted(
                    stopping, verdict, reasons, start=given.start, events=given.events
                )
            places = np.arange(len(rows), dtype=np.float64)
            return self._certified(rows, places, given, reasons, stopping=stopping, contact=contact)
        reasons += exceeded(self._rules, now, rows, times, worst)
        given = given.first(self._affordable(now, rows))
        del rows
        reasons += _cut_off(given, times)
        return self._changed(changed(self._rules, now, given.rows), given, reasons)

    def update_obstacles(self, obstacles: Iterable[Obstacle]) -> Admission | None:
        """Replaces the obstacles, resets their age and re-certifies the remaining commands.

        Args:
            obstacles: all obstacles, as in the guard's scene, whose margins stay.

        Returns:
            None if no state was given yet.
        """
        self._scene = Scene(obstacles, self._scene.margin, self._scene.self_collision_margin)
        scene = guarded_scene(self._arm, self._scene, self._period)
        self._rules = replace(self._rules, scene=scene)
        self._age = 0.0
        if self._stream is None:
            return None
        # At rest the arm stands still, which has to be clear too.
        rows = self._left() if len(self._left()) else self._now()
        contact = self._rules.contact(self._now(), rows, self._age)
        if contact is None:
            return self._admitted(
                StoppingTrajectory(rows, len(rows)), "allowed", (), start=self._period
            )
        places = np.arange(len(rows), dtype=np.float64)
        reason = _contact_reason(contact, places, self._period, self._period)
        self._safe = False  # as it is; what follows has been looked at anew
        return self._shortened(
            rows[: int(contact.sample)], places, (reason,), start=self._period, events=()
        )

    def stop(self) -> Admission:
        """Brakes now.

        Raises:
            InvalidInput: if no state was given yet.
        """
        return self._braking((), start=self._period)

    def _affordable(self, now: Float64Array, rows: Float64Array) -> int:
        """Number of samples that can be changed in time, by the pace that their rates allow."""
        few = rows[: self._most // _CHANGED_PART]
        factors = [
            ratio.max(axis=1) ** (1.0 / order)
            for order, ratio in enumerate(_rate_ratios(self._rules, now, few), start=1)
        ]
        periods = np.maximum(1.0, np.max(factors, axis=0)).cumsum()
        return max(1, int(np.searchsorted(periods, self._most / 2)))

    def _start(self, state: CommandedState | ArrayLike) -> None:
        """Makes a state the present one, with nothing known beyond it."""
        if self._stream is not None and isinstance(state, CommandedState):
            now = self.state
            if all(map(np.array_equal, (now.q, now.qd, now.qdd), (state.q, state.qd, state.qdd))):
                return
        self._stream = row_of(state, len(self._arm.joint_names))
        self._at = 0

    def _now(self) -> Float64Array:
        """The present command (1, 3 joints)."""
        if self._stream is None:
            raise InvalidInput(
                "state: expected the joints at the first call of admit, got none; give the "
                "positions that the arm is commanded to now"
            )
        return self._stream[self._at : self._at + 1]

    def _left(self) -> Float64Array:
        assert self._stream is not None
        return self._stream[self._at + 1 :]

    def _looked_at(
        self, rows: Float64Array, most_work: int
    ) -> tuple[StoppingTrajectory | None, Contact | None]:
        """Rows inside the limits with the stop after them, and where they come too near a body."""
        stopping = self._rules.braked(self._now(), rows)
        tried = rows if stopping is None else stopping.rows
        return stopping, self._rules.contact(self._now(), tried, self._age, most_work=most_work)

    def _changed(self, better: Changed, given: Chunk, reasons: tuple[Reason, ...]) -> Admission:
        """As much as is certified of rows that were made of a chunk."""
        rows, complete = better.rows, better.complete
        wrong = self._rules.excess(self._now(), rows)
        if wrong is not None:
            rows, complete = rows[: wrong[1]], False
        if not complete:
            at = better.places[len(rows) - 1] + 1.0 if len(rows) else 0.0
            reasons += (Reason("no continuation", given.start + self._period * float(at)),)
        stopping, contact = self._looked_at(rows, _WORK * max(len(given.rows), _SHORT))
        places = better.places
        if stopping is not None:
            # The same rows; of a long log, each copy is as large as the log.
            rows = stopping.rows[: len(rows)]
            del better
        return self._certified(rows, places, given, reasons, stopping=stopping, contact=contact)

    def _certified(
        self,
        rows: Float64Array,
        places: Float64Array,
        given: Chunk,
        reasons: tuple[Reason, ...],
        *,
        stopping: StoppingTrajectory | None,
        contact: Contact | None,
    ) -> Admission:
        """The rows if they are clear and end in a stop; else as much of them as is certified."""
        if stopping is not None and contact is None and len(rows):
            events = moved_events(
                given.events, places[: len(rows)], start=given.start, period=self._period
            )
            return self._admitted(stopping, "changed", reasons, start=given.start, events=events)
        whole = rows if contact is not None and (contact.bodies or contact.joint) else None
        if contact is not None:
            reasons += (_contact_reason(contact, places, given.start, self._period),)
            rows = rows[: int(contact.sample)]
        elif len(rows):
            reasons += (self._stop_reason(rows, places, given.start),)
        return self._shortened(
            rows, places, reasons, start=given.start, events=given.events, whole=whole
        )

    def _shortened(
        self,
        rows: Float64Array,
        places: Float64Array,
        reasons: tuple[Reason, ...],
        *,
        start: float,
        events: tuple[Event, ...],
        whole: Float64Array | None = None,
    ) -> Admission:
        """As many of the rows, known to be clear, as leave room to brake, or the whole slower."""
        now = self._now()
        stopping = self._rules.cut(now, rows, self._age)
        if whole is not None and (stopping is None or stopping.executed == 0):
            slower = self._rules.slower(now, whole, self._age)
            if slower is not None:
                stopping, at = slower
                places = np.interp(at, np.arange(len(places)), places)
        if stopping is None or stopping.executed == 0:
            return self._braking(reasons, start=start, stopping=stopping)
        remaining = moved_events(
            events, places[: stopping.executed], start=start, period=self._period
        )
        return self._admitted(stopping, "changed", reasons, start=start, events=remaining)

    def _braking(
        self,
        reasons: tuple[Reason, ...],
        *,
        start: float,
        stopping: StoppingTrajectory | None = None,
    ) -> Admission:
        """The fastest stop, or what was certified before; where neither is, the fastest one."""
        now, left = self._now(), self._left()
        if stopping is None:
            stopping = self._rules.clear_braked(now, left[:0], self._age)
        if stopping is None and len(left):
            certified = self._safe or self._rules.contact(now, left, self._age) is None
            stopping = StoppingTrajectory(left, 0) if certified else None
        if stopping is not None:
            return self._admitted(stopping, "braking", reasons, start=start)
        stopping = self._rules.braked(now, left[:0])
        if stopping is None:
            stopping = StoppingTrajectory(left if len(left) else self._rules.stop(now), 0)
        contact = self._rules.contact(now, stopping.rows, self._age)
        if contact is not None:
            places = np.arange(len(stopping.rows), dtype=np.float64)
            reason = _contact_reason(contact, places, start, self._period)
            reasons += () if str(reason) in map(str, reasons) else (reason,)
        elif not len(left):
            reasons += (self._stop_reason(left, np.empty(0), start),)
        return self._admitted(stopping, "braking", reasons, start=start, safe=False)

    def _stop_reason(self, rows: Float64Array, places: Float64Array, start: float) -> Reason:
        """The limit that the fastest stop after the rows exceeds."""
        end = rows[-1:] if len(rows) else self._now()
        wrong = self._rules.stop_excess(end)
        assert wrong is not None
        order, row, joint, ratio = wrong
        at = (places[len(rows) - 1] + 1.0 if len(rows) else 0.0) + row
        name = self._arm.joint_names[joint]
        return Reason(KINDS[order], start + self._period * float(at), name, ratio=ratio)

    def _admitted(
        self,
        stopping: StoppingTrajectory,
        verdict: Verdict,
        reasons: tuple[Reason, ...],
        *,
        start: float,
        events: tuple[Event, ...] = (),
        safe: bool = True,
    ) -> Admission:
        """Commands a stopping trajectory from now on."""
        now = self._now()
        rows = stopping.rows if len(stopping.rows) else now
        kept = stopping.executed or len(rows)
        times = start + self._period * np.arange(len(rows) + 1, dtype=np.float64)
        names = self._arm.joint_names
        motion = trajectory(times[:kept], rows[:kept], names, events)
        after = min(kept, len(rows) - 1)  # the last row where there is none
        brake = trajectory(times[kept:][: len(rows) - after], rows[after:], names)
        self._stream = np.concatenate([now, rows])
        self._at = 0
        self._safe = safe
        return Admission(motion, brake, verdict, safe, reasons)


def _cut_off(given: Chunk, times: Float64Array) -> tuple[Reason, ...]:
    """The reason of a chunk that is cut off for its length, if it is."""
    return () if given.whole else (Reason("cut short", float(times[len(given.rows) - 1])),)


def _contact_reason(contact: Contact, places: Float64Array, start: float, period: float) -> Reason:
    """When a contact comes, or what was looked at ends; its clock goes on beyond the chunk."""
    row = int(contact.sample)
    beyond = row - len(places) + 1.0 if row >= len(places) else 0.0
    place = float(places[min(row, len(places) - 1)]) + beyond if len(places) else 0.0
    kind: Kind = "contact" if contact.bodies else "torque" if contact.joint else "cut short"
    time = start + period * max(0.0, place)
    return Reason(kind, time, contact.joint, bodies=contact.bodies, ratio=contact.ratio)


_ROUNDING = 1e-9  # rad or m
_EXCESS = 1e-6
_JUMP = 3.0  # times its neighbours a step is longer that is a jump
_RATES: tuple[Kind, ...] = ("velocity", "acceleration", "jerk")


def not_finite(rows: Float64Array, names: tuple[str, ...], times: Float64Array) -> Reason | None:
    at = _first(~np.isfinite(rows))
    return None if at is None else Reason("not finite", float(times[at[0]]), names[at[1]])


def exceeded(
    rules: Rules,
    start: Float64Array,
    rows: Float64Array,
    times: Float64Array,
    worst: tuple[int, int, int, float],
) -> tuple[Reason, ...]:
    """The first excess of each kind that rows (n, 3 joints) have at a row, or else the `worst`."""
    limits, names = rules.joints, rules.joints.joint_names
    q = parts_of(rows)[0]
    found: list[Reason] = []
    outside = (q < limits.lower - _ROUNDING) | (q > limits.upper + _ROUNDING)
    if (at := _first(outside)) is not None:
        value = float(q[at])
        found.append(Reason("position", float(times[at[0]]), names[at[1]], ratio=value))
    jumped = slice(0)  # rows whose higher orders reach over a jump
    for kind, ratio in zip(_RATES, _rate_ratios(rules, start, rows), strict=True):
        over = ratio > 1.0 + _EXCESS
        over[jumped] = False
        if (at := _first(over)) is None:
            continue
        named: Kind = "jump" if kind == "velocity" and _is_jump(ratio, at) else kind
        if named == "jump":
            jumped = slice(max(0, at[0] - 1), at[0] + 2)
        time, name = float(times[at[0]]), names[at[1]]
        found.append(Reason(named, time, name, ratio=float(ratio[at])))
    if not found:
        order, row, joint, most = worst
        found.append(Reason(KINDS[order], float(times[row]), names[joint], ratio=most))
    return tuple(found)


def _rate_ratios(rules: Rules, start: Float64Array, rows: Float64Array) -> Iterator[Float64Array]:
    """Velocities, accelerations and jerks (n, joints) at rows, as fractions of their limits."""
    velocity, acceleration, jerk = known_rates(rules.joints)
    (q, _, qdd), (q0, _, qdd0) = parts_of(rows), parts_of(start)
    yield np.abs(np.diff(q, axis=0, prepend=q0) / rules.period) / velocity
    yield np.abs(qdd) / acceleration
    yield np.abs(np.diff(qdd, axis=0, prepend=qdd0) / rules.period) / jerk


def _is_jump(steps: Float64Array, at: tuple[int, int]) -> bool:
    row, joint = at
    beside = [steps[i, joint] for i in (row - 1, row + 1) if 0 <= i < len(steps)]
    return bool(steps[row, joint] > _JUMP * max(beside, default=0.0))


def _first(wrong: NDArray[np.bool_]) -> tuple[int, int] | None:
    """The first row with something wrong in it, and the column."""
    rows = wrong.any(axis=1)
    if not rows.any():
        return None
    row = int(np.argmax(rows))
    return row, int(np.argmax(wrong[row]))

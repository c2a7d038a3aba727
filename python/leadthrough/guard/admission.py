"""Chunks of commands put on a guard's clock, and its answers: motion, brake and reasons."""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check
from leadthrough.arm import Arm, DualArm
from leadthrough.check import Float64Array, InvalidInput, ShortRepr
from leadthrough.motion import Event, JointTrajectory, computed_joints, in_order
from leadthrough.timing.limits_report import arrays_of

Verdict = Literal["allowed", "changed", "braking"]
Kind = Literal[
    "position",
    "jump",
    "velocity",
    "acceleration",
    "jerk",
    "torque",
    "contact",
    "not finite",
    "no continuation",
    "cut short",
    "resampled",
]
KINDS: tuple[Kind, ...] = ("position", "velocity", "acceleration", "jerk")  # by order


@dataclass(frozen=True, eq=False)
class CommandedState(ShortRepr):
    """Commanded positions, velocities and accelerations of the joints; read-only copies.

    Attributes:
        q: (joints,) in rad (m for prismatic joints).
        qd: (joints,) in rad/s (m/s).
        qdd: (joints,) in rad/s^2 (m/s^2).
    """

    q: Float64Array
    qd: Float64Array
    qdd: Float64Array

    def __post_init__(self) -> None:
        q = check.frozen(self.q, "q", shape=("joints",))
        rates = {n: check.frozen(getattr(self, n), n, shape=q.shape) for n in ("qd", "qdd")}
        vars(self).update(q=q, **rates)


@dataclass(frozen=True, eq=False)
class Reason(ShortRepr):
    """Why a chunk was not admitted as it was given.

    Attributes:
        kind: the limit that it exceeds; "jump" for a step far longer than its neighbours; "contact"
            where bodies come nearer than the margin; "not finite" for NaN and infinity;
            "no continuation" where no motion that is allowed leads from the state to the chunk;
            "cut short" where certifying the continuation would take too long, for its length or
            for bodies near it;
            "resampled" where its clock was not the guard's.
        time: s, on the chunk's clock; of a contact while braking, after the chunk's end.
        joint: name of the joint, or None.
        bodies: the two bodies of a contact, or None.
        ratio: by how many times a limit is exceeded; for a position the value in rad (m).
    """

    kind: Kind
    time: float
    joint: str | None = None
    bodies: tuple[str, str] | None = None
    ratio: float | None = None

    def __str__(self) -> str:
        when = f"at {self.time:.3f} s"
        if self.bodies is not None:
            return f"{' and '.join(self.bodies)} come too near {when}"
        if self.kind == "position":
            return f"{self.joint} leaves its position limits {when}: {self.ratio:.4g}"
        if self.joint is not None and self.ratio is not None:
            limit = "velocity" if self.kind == "jump" else self.kind
            jumps = "jumps" if self.kind == "jump" else f"exceeds its {limit} limit"
            return f"{self.joint} {jumps} {when}: {self.ratio:.3g} times the {limit} limit"
        told = {
            "not finite": f"a value of {self.joint} is not finite {when}",
            "no continuation": f"no motion inside the limits leads on {when}",
            "cut short": f"only the way up to {self.time:.3f} s was certified in the time allowed",
            "resampled": "the samples were put on the guard's clock",
        }
        return told.get(self.kind, f"{self.kind} {when}")


@dataclass(frozen=True, eq=False)
class Admission(ShortRepr):
    """An admitted motion, and the certified one to rest after it.

    Attributes:
        motion: to execute, the first sample one period from now; the chunk itself if that is
            allowed.
        brake: to execute after it if nothing else comes; it ends at rest. One sample where
            the motion ends at rest.
        verdict: "allowed", the chunk to the bit; "changed", the nearest motion that is allowed;
            "braking", the motion is a braking motion.
        safe: whether motion and brake are certified: inside all limits, and clear by the margin.
            Where an obstacle appears too near or moves too fast for any braking motion, the answer
            brakes, this is false and a reason names the bodies.
        reasons: why the chunk was not admitted as it was, the first of each kind; () if it was.
    """

    motion: JointTrajectory
    brake: JointTrajectory
    verdict: Verdict
    safe: bool
    reasons: tuple[Reason, ...] = ()

    @property
    def to_rest(self) -> JointTrajectory:
        """The motion followed by the brake."""
        if self.verdict == "braking":
            return self.motion
        pair = (self.motion, self.brake)
        times = np.concatenate([each.times for each in pair])
        parts = [np.concatenate(columns) for columns in zip(*map(arrays_of, pair), strict=True)]
        names = self.brake.joint_names
        return computed_joints(times, *parts, joint_names=names, events=self.motion.events)

    def __str__(self) -> str:
        why = "; ".join(str(each) for each in self.reasons)
        unsafe = "" if self.safe else " (NOT SAFE)"
        return f"{self.verdict}{unsafe}{': ' if why else ''}{why}"


_SAME_PERIOD = 1e-6  # relative; clocks that differ by less are one


@dataclass(frozen=True, eq=False)
class Chunk:
    """Samples a period apart."""

    rows: Float64Array  # (n, joints), perhaps not finite
    start: float  # time of the first one on the chunk's own clock, s
    states: Float64Array | None = None  # (n, 3 joints), where it has all rates
    events: tuple[Event, ...] = ()  # of it
    resampled: bool = False  # whether its clock was another
    whole: bool = True  # whether it has all samples that were given

    def first(self, count: int) -> Chunk:
        if count >= len(self.rows):
            return self
        states = None if self.states is None else self.states[:count]
        return replace(self, rows=self.rows[:count], states=states, whole=False)

    def following(self, start: Float64Array, period: float) -> Float64Array:
        """States (n, 3 joints) of the samples, by the parabolas through three of them."""
        times = period * np.arange(len(self.rows), dtype=np.float64)
        return core.with_rates(times, np.ascontiguousarray(self.rows), start, period)


def chunk_of(
    value: JointTrajectory | ArrayLike,
    arm: Arm | DualArm,
    period: float,
    *,
    most: int = sys.maxsize,
) -> Chunk:
    """A user's chunk, of as many samples at most."""
    if not isinstance(value, JointTrajectory):
        rows = check.with_gaps(value, "chunk", shape=("n", len(arm.joint_names)))
        if not len(rows):
            raise InvalidInput("chunk: expected at least one sample, got none")
        return Chunk(np.array(rows[:most]), period, whole=len(rows) <= most)
    own = in_order(value, arm.joint_names, "chunk")
    start = float(own.times[0])
    steps = np.diff(own.times)
    if (np.abs(steps - period) <= _SAME_PERIOD * period + 1e-12 * np.abs(own.times[1:])).all():
        states = None
        if own.velocities is not None and own.accelerations is not None:
            states = np.hstack(arrays_of(own))
        return Chunk(own.positions, start, states, own.events).first(most)
    count = 1 + int(np.floor((own.times[-1] - start) / period * (1.0 + 1e-9)))
    kept = min(count, most)
    at = np.minimum(start + period * np.arange(kept), own.times[-1])
    rows = _interpolated(own, at)
    return Chunk(rows, start, None, own.events, resampled=True, whole=kept == count)


def _interpolated(own: JointTrajectory, at: Float64Array) -> Float64Array:
    """Positions at times, along a smooth curve through the samples."""
    if len(own.times) == 1:
        return np.repeat(own.positions, len(at), axis=0)
    piece = np.clip(np.searchsorted(own.times, at, side="right") - 1, 0, len(own.times) - 2)
    since = (at - own.times[piece])[:, None]
    a, b, c, d = _cubics(own)[piece].transpose(1, 0, 2)
    return np.asarray(a + since * (b + since * (c + since * d)))


def _cubics(own: JointTrajectory) -> Float64Array:
    """Coefficients (pieces, 4, joints) of the cubics between samples, without SciPy's import."""
    steps = np.diff(own.times)[:, None]
    if own.velocities is None:
        table = core.cubic_through(own.times, own.positions)
        return np.asarray(table.reshape(len(steps), 4, -1))
    chords = np.diff(own.positions, axis=0) / steps
    slopes = own.velocities
    bend = (slopes[:-1] + slopes[1:] - 2.0 * chords) / steps
    parts = (own.positions[:-1], slopes[:-1], (chords - slopes[:-1]) / steps - bend, bend / steps)
    return np.stack(parts, axis=1)


def begun_at(motion: JointTrajectory, q: Float64Array, rate: float) -> JointTrajectory:
    """The motion on a clock from 0, a period after rest at positions (joints,)."""
    now = float(motion.times[0]) - 1.0 / rate
    events = tuple(replace(each, time=each.time - now) for each in motion.events)
    rest = (q[None], *np.zeros((2, 1, len(q))))
    parts = [np.concatenate(both) for both in zip(rest, arrays_of(motion), strict=True)]
    times = np.arange(len(motion) + 1) / rate
    return computed_joints(times, *parts, joint_names=motion.joint_names, events=events)


def parts_of(states: Float64Array) -> tuple[Float64Array, Float64Array, Float64Array]:
    """Views of the positions, velocities and accelerations (n, joints) of states."""
    joints = states.shape[1] // 3
    return states[:, :joints], states[:, joints : 2 * joints], states[:, 2 * joints :]


def trajectory(
    times: Float64Array,
    states: Float64Array,
    names: tuple[str, ...],
    events: tuple[Event, ...] = (),
) -> JointTrajectory:
    """The motion of states (n, 3 joints)."""
    parts = [np.ascontiguousarray(part) for part in parts_of(states)]
    return computed_joints(times, *parts, joint_names=names, events=events)


def moved_events(
    events: tuple[Event, ...], places: Float64Array, *, start: float, period: float
) -> tuple[Event, ...]:
    """Events at the first row that has come to their place on the chunk; without those cut off."""
    moved = []
    for event in events:
        reached = places >= (event.time - start) / period - 1e-9
        if reached.any():
            moved.append(Event(start + period * int(np.argmax(reached)), event.name))
    return tuple(moved)

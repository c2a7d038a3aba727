"""What a guard answers: the motion that may run, how to come to rest after it, and why."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.motion import JointTrajectory
from leadthrough.repr import ShortRepr

Verdict = Literal["allowed", "changed", "braking"]
Kind = Literal[
    "position",
    "jump",
    "velocity",
    "acceleration",
    "jerk",
    "contact",
    "not finite",
    "no way on",
    "cut short",
    "resampled",
]
KINDS: tuple[Kind, ...] = ("position", "velocity", "acceleration", "jerk")  # by order


@dataclass(frozen=True, eq=False)
class CommandedState(ShortRepr):
    """Where the joints are commanded to be, and how fast they are commanded to move.

    Attributes:
        q: (joints,) in rad (m for prismatic joints).
        qd: (joints,) in rad/s (m/s); the step since the command before, over the period.
        qdd: (joints,) in rad/s^2 (m/s^2); the change of that, over the period.
    """

    q: Float64Array
    qd: Float64Array
    qdd: Float64Array


@dataclass(frozen=True, eq=False)
class Reason(ShortRepr):
    """Why a chunk was not admitted as it was given.

    Attributes:
        kind: the limit that it exceeds; "jump" for a step far longer than its neighbours; "contact"
            where bodies come nearer than the margin; "not finite" for NaN and infinity; "no way on"
            where no motion that is allowed leads from the state to the chunk; "cut short" where
            the way on is so long, or so near to something, that to certify it would take too long;
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
            "no way on": f"no motion inside the limits leads on {when}",
            "cut short": f"only the way up to {self.time:.3f} s was certified in the time allowed",
            "resampled": "the samples were put on the guard's clock",
        }
        return told.get(self.kind, f"{self.kind} {when}")


@dataclass(frozen=True, eq=False)
class Admission(ShortRepr):
    """A motion that may run, and the certified one to rest after it.

    Attributes:
        motion: what to execute, the first sample one period from now; the chunk itself where that
            is allowed.
        brake: what to execute after it if nothing else comes; it ends at rest. One sample where
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
        """The motion and then the brake, without velocities where the motion has none."""
        if self.verdict == "braking":
            return self.motion
        parts = (self.motion, self.brake)
        return JointTrajectory(
            np.concatenate([each.times for each in parts]),
            np.concatenate([each.positions for each in parts]),
            _joined([each.velocities for each in parts]),
            _joined([each.accelerations for each in parts]),
            self.brake.joint_names,
            self.motion.events,
        )

    def __str__(self) -> str:
        why = "; ".join(str(each) for each in self.reasons)
        unsafe = "" if self.safe else " (NOT SAFE)"
        return f"{self.verdict}{unsafe}{': ' if why else ''}{why}"


def _joined(parts: list[Float64Array | None]) -> Float64Array | None:
    """The rows one after the other; None if the first part has none."""
    known = [rows for rows in parts if rows is not None]
    return np.concatenate(known) if len(known) == len(parts) else None

"""Results of a simulation: errors, torques, contacts, energy and a verdict."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from leadthrough.arm import Arm
from leadthrough.check import Float64Array, ShortRepr
from leadthrough.drawing import Drawn, Line, Panel, over, palette
from leadthrough.guard import CommandedState
from leadthrough.motion import JointTrajectory
from leadthrough.shapes import Shape
from leadthrough.simulation.simulated_arm import SimulatedArm, Touch

Kind = Literal[
    "limits",
    "torque",
    "velocity",
    "tracking",
    "contact",
    "tip",
    "margin",
    "no approach motion",
    "unstable",
]
_DRAWN = 400  # points of a curve


@dataclass(frozen=True, eq=False)
class Contact(ShortRepr):
    """Two bodies that touched.

    Attributes:
        bodies: links by name, "attached", or "obstacle" with its index.
        start: s, when they first touched.
        end: s, when they last touched.
        force: the largest of it, N.
    """

    bodies: tuple[str, str]
    start: float
    end: float
    force: float

    def __str__(self) -> str:
        a, b = self.bodies
        return f"{a} and {b} touch from {self.start:.3f} s on, with up to {self.force:.3g} N"


@dataclass(frozen=True, eq=False)
class Finding(ShortRepr):
    """Why a motion is not fit to run.

    Attributes:
        kind: "limits" where the arm's limits allow a joint more than twice the velocity that its
            URDF states, as a file in another unit does; "torque" where the controller asks for more
            than a joint has; "velocity" where the motion is faster than the URDF's or the arm's
            limit; "tracking" where the error is larger than the controller's gains allow by theory;
            "contact"; "tip" where the tip's error exceeds the tolerance, "margin" where it exceeds
            the margin to obstacles; "no approach motion" where no motion inside the limits leads
            onto the motion, or from its end to rest; "unstable" where a joint runs away, or by
            theory would: the errors, torques and contacts that follow from it are left out.
        time: s, when it begins.
        joint: name of the joint, or None.
        bodies: of a contact, or None.
        ratio: the largest, by how many times the limit is exceeded; of a contact its force in N.
    """

    kind: Kind
    time: float
    joint: str | None = None
    bodies: tuple[str, str] | None = None
    ratio: float | None = None

    def __str__(self) -> str:
        when = f"at {self.time:.3f} s"
        if self.bodies is not None and self.ratio is not None:
            return f"{' and '.join(self.bodies)} touch {when}, with up to {self.ratio:.3g} N"
        factor = "" if self.ratio is None else f"{self.ratio:.3g} times"
        times = f"up to {factor}"
        since = f"from {self.time:.3f} s on"
        told = {
            "limits": f"{self.joint} is allowed {factor} the velocity that the URDF states",
            "torque": f"{self.joint} needs {times} its highest torque, {since}",
            "velocity": f"{self.joint} is to move at {times} its highest velocity, {since}",
            "tracking": f"{self.joint} is off by {times} what the gains allow, {since}",
            "tip": f"the tip is off by {times} the tolerance, {since}",
            "margin": f"the tip is off by {times} the margin to obstacles, {since}",
            "no approach motion": "no motion inside the limits leads onto the motion, or to rest",
            "unstable": f"unstable: {self.joint} runs away under its controller, {since}; "
            "lower gains or delay, or raise the rate",
        }
        return told.get(self.kind, f"{self.kind} {when}")


@dataclass(frozen=True, eq=False)
class SimulationReport(Drawn):
    """A motion as a controller and gravity made it; a motion that fails is a finding, no error.

    Attributes:
        arm: the arm, as its controller knows it.
        planned: commanded, with the approach and the way to rest, a period apart.
        simulated: the arm's motion.
        span: from when to when the motion that was given lasts, s.
        torques: of the motors behind their gears (n, joints), N m (N), without those that
            accelerate their rotors.
        torque_limits: (joints,), N m (N), infinite where none is known.
        expected: tracking errors (n, joints), rad (m), by the linear theory of the controller.
        allowed: the largest tracking error (joints,), rad (m), that the gains allow by theory.
        tip_errors: distances (n,) of the tip from where it should be, m.
        tip_turns: orientation errors (n,) of the tip, rad.
        contacts: in the order of time.
        energy: (joints,), J, that the motors put in; what they take up while they brake does not
            count.
        work: (joints,), J, with what they take up subtracted.
        findings: why the motion is not fit to run; () if it is.
        obstacles: of the simulation.
    """

    arm: Arm = field(repr=False)
    planned: JointTrajectory
    simulated: JointTrajectory
    span: tuple[float, float]
    torques: Float64Array
    torque_limits: Float64Array
    expected: Float64Array
    allowed: Float64Array
    tip_errors: Float64Array
    tip_turns: Float64Array
    contacts: tuple[Contact, ...]
    energy: Float64Array
    work: Float64Array
    findings: tuple[Finding, ...]
    obstacles: tuple[Shape, ...] = field(default=(), repr=False)

    @property
    def ok(self) -> bool:
        """Whether there is nothing against running the motion."""
        return not self.findings

    @property
    def errors(self) -> Float64Array:
        """Tracking errors (n, joints), planned minus simulated, rad (m)."""
        return self.planned.positions - self.simulated.positions

    @property
    def torque_fractions(self) -> Float64Array:
        """The largest torque of each joint (joints,), as a fraction of its limit; 0 without one."""
        return np.asarray(np.abs(self.torques).max(axis=0) / self.torque_limits)

    def __str__(self) -> str:
        if self.findings:
            return "not fit to run: " + "; ".join(map(str, self.findings))
        i = int(self.torque_fractions.argmax())
        return (
            f"fit to run: the tip is off by at most {1e3 * self.tip_errors.max():.2f} mm, torques "
            f"up to {self.torque_fractions[i]:.0%} of the limit ({self.arm.joint_names[i]}), "
            "no contact"
        )

    def _repr_parts(self) -> list[str]:
        return [f"ok={self.ok}", str(self)]

    def _panels(self) -> list[Panel]:
        step = max(1, len(self.planned.times) // _DRAWN)
        times, names = self.planned.times[::step], self.arm.joint_names
        fractions = 100.0 * self.torques[::step] / self.torque_limits
        tip = Line(times, 1e3 * self.tip_errors[::step], "tip", colour=palette.PATH)
        ends = [(time, "") for time in self.span]
        errors = 1e3 * self.errors[::step]
        return [
            over(times, errors, names, title="tracking error in mrad (mm)", marks=ends),
            over(times, fractions, names, title="torque in % of the limit", marks=ends),
            Panel("error of the tip in mm", [tip], "time in s", marks=ends),
        ]


_ROUNDING = 1e-6  # of limits, relative
_IMPLAUSIBLE = 2.0  # times the velocity that a URDF states


@dataclass(frozen=True, eq=False)
class Plan:
    """Commands (n, joints) a period apart, and where the given motion is in them, s."""

    start: CommandedState
    q: Float64Array
    qd: Float64Array
    qdd: Float64Array
    progress: Float64Array
    span: tuple[float, float]
    way_found: bool

    def first(self, count: int) -> Plan:
        """The first commands alone."""
        rows = {name: vars(self)[name][:count] for name in ("q", "qd", "qdd", "progress")}
        return replace(self, **rows)


@dataclass(frozen=True, eq=False)
class Run:
    """Recorded arrays, (n, joints); the torques are those of the period that follows."""

    q: Float64Array  # positions
    qd: Float64Array  # velocities
    qdd: Float64Array  # accelerations
    torques: Float64Array  # of the motors
    work: Float64Array  # (joints,) of the motors, J
    energy: Float64Array  # (joints,) of it what they put in
    use: Float64Array  # (joints,) most asked of them before a touch, as a fraction of their limits
    over: NDArray[np.intp]  # (joints,) first samples at which it exceeds these, or -1
    touches: list[tuple[int, list[Touch]]]  # with the index of their sample
    runaway: int | None  # the joint that ran away, by its number


def findings(
    real: SimulatedArm,
    run: Run,
    plan: Plan,
    *,
    allowed: Float64Array,
    contacts: Sequence[Contact],
    tip_errors: Float64Array,
    tolerances: Mapping[Kind, float],
) -> tuple[Finding, ...]:
    """Faults of a motion, one of each kind: the start and the worst value."""
    names, plant = real.arm.joint_names, real.plant
    period = real.period

    def worst(kind: Kind, rows: Float64Array, most: Float64Array) -> Iterator[Finding]:
        """The joint that exceeds its limit most, of (n, joints) rows, and when it first does."""
        ratios = np.maximum(rows.max(axis=0), -rows.min(axis=0)) / most
        joint = int(ratios.argmax())
        if ratios[joint] > 1.0 + _ROUNDING:
            over = np.abs(rows[:, joint]) / most[joint] > 1.0 + _ROUNDING
            yield Finding(
                kind, period * int(np.argmax(over)), names[joint], ratio=float(ratios[joint])
            )

    def found() -> Iterator[Finding]:
        if not plan.way_found:
            yield Finding("no approach motion", 0.0)
        yield from _wrong_limits(real)
        yield from worst("velocity", plan.qd, plant.velocity)
        joint = run.runaway
        if joint is None and not np.isfinite(allowed).all():  # by theory it would run away
            joint = int(np.argmax(np.isinf(allowed)))
        if joint is not None:
            yield Finding("unstable", period * (len(run.q) - 1), names[joint])
            return
        # The errors that follow from a contact are none of their own.
        free = slice(run.touches[0][0] + 1 if run.touches else None)
        if (run.over >= 0).any():
            joint = int(run.use.argmax())
            ratio, first = float(run.use[joint]), int(run.over[joint])
            yield Finding("torque", period * first, names[joint], ratio=ratio)
        for each in contacts:
            yield Finding("contact", each.start, bodies=each.bodies, ratio=each.force)
        yield from worst("tracking", (plan.q - run.q)[free], allowed)
        errors = tip_errors[free]
        for kind, most in tolerances.items():
            if errors.max() > most:
                first = int(np.argmax(errors > most))
                ratio = float(errors.max() / most) if most else np.inf
                yield Finding(kind, period * first, ratio=ratio)

    return tuple(found())


def _wrong_limits(real: SimulatedArm) -> Iterator[Finding]:
    """The joint whose velocity limit is above its URDF's by the largest factor, if beyond doubt."""
    limits = real.arm.limits
    known = np.where(np.isfinite(limits.velocity), limits.velocity, 0.0)
    ratios = known / real.plant.stated_velocity
    joint = int(ratios.argmax())
    if ratios[joint] > _IMPLAUSIBLE:
        yield Finding("limits", 0.0, limits.joint_names[joint], ratio=float(ratios[joint]))


def summed_contacts(
    touches: Sequence[tuple[int, list[Touch]]], period: float
) -> tuple[Contact, ...]:
    """One entry for each pair of bodies, in the order of their first touch."""
    spans: dict[tuple[str, str], tuple[int, int, float]] = {}
    for sample, pairs in touches:
        for each in pairs:
            first, _, force = spans.get(each.bodies, (sample, sample, 0.0))
            spans[each.bodies] = (first, sample, max(force, each.force))
    return tuple(
        Contact(bodies, period * first, period * last, force)
        for bodies, (first, last, force) in spans.items()
    )

"""Whether a simulated motion is fit to run, and why not."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.simulation.report import Contact, Finding, Kind
from leadthrough.simulation.simulated_arm import SimulatedArm, Touch

_ROUNDING = 1e-6  # of limits, relative
_IMPLAUSIBLE = 2.0  # times the velocity that a URDF states


@dataclass(frozen=True, eq=False)
class Run:
    """What was recorded, (n, joints) each; the torques are those of the period that follows."""

    q: Float64Array  # positions
    qd: Float64Array  # velocities
    qdd: Float64Array  # accelerations
    torques: Float64Array  # of the motors
    demanded: Float64Array  # what the controller asked of them
    work: Float64Array  # of the motors during the period, J
    touches: list[tuple[int, list[Touch]]]  # with the index of their sample
    whole: bool  # whether the arm went through to the end


def findings(
    real: SimulatedArm,
    run: Run,
    q: Float64Array,
    qd: Float64Array,
    *,
    allowed: Float64Array,
    contacts: Sequence[Contact],
    tip: tuple[Float64Array, float | None],
    way_found: bool,
) -> tuple[Finding, ...]:
    """What speaks against running a motion, one of each kind: where it begins, and at its worst."""
    names, plant = real.arm.joint_names, real.plant
    period = real.period

    def worst(kind: Kind, ratios: Float64Array) -> Iterator[Finding]:
        """(n, joints) fractions of a limit; the joint that exceeds it most, when it first does."""
        if ratios.max() > 1.0 + _ROUNDING:
            joint = int(ratios.max(axis=0).argmax())
            first = int(np.argmax(ratios[:, joint] > 1.0 + _ROUNDING))
            yield Finding(kind, period * first, names[joint], ratio=float(ratios[:, joint].max()))

    def found() -> Iterator[Finding]:
        if not way_found:
            yield Finding("no way onto it", 0.0)
        yield from _wrong_limits(real)
        yield from worst("velocity", np.abs(qd) / plant.velocity)
        yield from worst("torque", np.abs(run.demanded) / plant.effort)
        for each in contacts:
            yield Finding("contact", each.start, bodies=each.bodies, ratio=each.force)
        yield from worst("tracking", np.abs(q - run.q) / allowed)
        errors, most = tip
        if most is not None and errors.max() > most:
            first = int(np.argmax(errors > most))
            yield Finding("tip", period * first, ratio=float(errors.max() / most))
        if not run.whole or not np.isfinite(allowed).all():
            yield Finding("unstable", period * (len(run.q) - 1))

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

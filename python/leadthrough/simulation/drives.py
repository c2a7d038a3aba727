"""Motors, gears, encoders and load of a simulated arm, beyond what its URDF states.

The values of real arms and their sources stand in `drives.toml`.
"""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check
from leadthrough.arm import Arm
from leadthrough.check import Float64Array, InvalidInput, ShortRepr

_MAX_DELAY = 1.0  # s
_LIGHTEST = 0.05  # of the heaviest joint's inertia, of turning and of sliding joints apart
# Of the heaviest joint's inertia, below which rounding drives a joint; too little to be felt.
_WEIGHTLESS = 1e-6

# No arm moves so fast, rad/s (m/s); MuJoCo would soon give up and write a file about it.
RUNAWAY = 1e3


class RunawayError(FloatingPointError):
    """A simulated arm that runs away; `joint` is the number of the joint that did first."""

    def __init__(self, name: str, time: float, joint: int) -> None:
        super().__init__(f"{name} runs away after {time:.3f} s; lower the gains or raise the rate")
        self.joint = joint


@dataclass(frozen=True, eq=False)
class Push(ShortRepr):
    """A force on the tip, unknown to the controller.

    Attributes:
        time: when it begins, s after the start of the motion.
        force: (3,), N in the base frame.
        duration: s, > 0.
    """

    time: float
    force: ArrayLike
    duration: float = 0.1

    def __post_init__(self) -> None:
        check.number(self.time, "time", at_least=0.0)
        check.number(self.duration, "duration", above=0.0)
        object.__setattr__(self, "force", check.frozen(self.force, "force", shape=(3,)))


@dataclass(frozen=True, eq=False)
class Disturbances(ShortRepr):
    """Differences of a simulated arm from the links of its URDF.

    The controller knows the rotors and nothing of the others. A value of None is that of a real
    arm, from the table of [drives](../methods/simulation.md#drives). `replace(Disturbances.ideal(),
    friction=0.5)`, by the function of `dataclasses`, is an arm with no other disturbance.

    Attributes:
        payload: factor by which the load at the tip is heavier than known, >= 0; 1.05 by default.
        friction: of the joints that the controller does not compensate, N m (N), >= 0, (joints,) or
            one number; besides the URDF's. By default the table's where the URDF states none.
        damping: of the joints, N m s/rad (N s/m), >= 0, likewise.
        delay: of measurements, s, 0 to 1, in whole periods; one period by default.
        encoder: steps in which positions are measured, rad (m), >= 0, (joints,) or one number;
            velocities are their differences.
        rotor_inertia: of the motors, kg m^2 (kg) behind their gears, >= 0, (joints,) or one number.
        pushes: forces on the tip.
    """

    payload: float | None = None
    friction: ArrayLike | None = None
    damping: ArrayLike | None = None
    delay: float | None = None
    encoder: ArrayLike | None = None
    rotor_inertia: ArrayLike | None = None
    pushes: Sequence[Push] = ()

    def __post_init__(self) -> None:
        if self.payload is not None:
            check.number(self.payload, "payload", at_least=0.0)
        if self.delay is not None:
            check.number(self.delay, "delay", at_least=0.0, at_most=_MAX_DELAY)
        object.__setattr__(self, "pushes", tuple(self.pushes))
        for each in self.pushes:
            check.instance(each, "pushes", Push, "Push objects")

    @classmethod
    def ideal(cls) -> Self:
        """None at all: rotors without inertia, no friction but the URDF's, exact measurements."""
        return cls(1.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Drives:
    """Disturbances of one arm, each with its value; arrays are (joints,)."""

    payload: float
    friction: Float64Array  # N m (N), the URDF's included
    damping: Float64Array  # N m s/rad (N s/m), likewise
    late: int  # periods by which measurements are delayed
    encoder: Float64Array  # rad (m)
    rotors: Float64Array  # kg m^2 (kg)
    effort: Float64Array  # N m (N) behind the gears, infinite where no limit is known
    pushes: tuple[Push, ...]

    @property
    def payload_known_to(self) -> float:
        """Largest error of the payload, as a fraction, that is no fault of the plan."""
        return float(_table()["general"]["payload"]) - 1.0


def drives_of(arm: Arm, given: Disturbances, period: float) -> Drives:
    """The drives of an arm: given values, and those of a real arm in the place of None."""
    general = _table()["general"]
    loads = arm.attachment.loads
    payload = general["payload"] if given.payload is None and loads else given.payload or 1.0
    if given.payload == 0.0:
        payload = 0.0
    if payload != 1.0 and not loads:
        raise InvalidInput(
            f"payload: expected 1 for an arm that carries nothing, got {payload:g}; "
            "state its load first; in Python, by arm.with_payload or arm.with_attached"
        )
    damping, friction = arm._resistance
    own = core.Chain(arm._robot, arm.base, arm.tip)
    effort = stricter(own.effort, arm.limits.effort)
    slides = _slides(arm)
    scale = np.where(np.isfinite(effort), effort, _guessed_effort(arm, slides))
    steps = np.where(slides, general["encoder_of_slides"], general["encoder"])

    def resisting(name: str, value: ArrayLike | None, urdf: Float64Array) -> Float64Array:
        if value is None:
            return np.where(urdf > 0.0, urdf, _tabled(arm, name, scale))
        return urdf + per_joint(value, name, arm, at_least=0.0)

    def known(name: str, value: ArrayLike | None, table: Float64Array) -> Float64Array:
        return table if value is None else per_joint(value, name, arm, at_least=0.0)

    return Drives(
        payload,
        resisting("friction", given.friction, friction),
        resisting("damping", given.damping, damping),
        general["delay"] if given.delay is None else round(given.delay / period),
        known("encoder", given.encoder, steps),
        _felt(
            arm, known("rotor_inertia", given.rotor_inertia, _tabled(arm, "rotor_inertia", scale))
        ),
        effort,
        tuple(given.pushes),
    )


def _felt(arm: Arm, rotors: Float64Array) -> Float64Array:
    """Rotors (joints,), of joints that turn no mass those of a millionth of the heaviest joint."""
    inertia = np.diag(arm.mass_matrix(arm._chain.middle)) + rotors
    least = _WEIGHTLESS * inertia.max()
    return np.where(inertia > least, rotors, least)


def stricter(urdf: Float64Array, limits: Float64Array | None) -> Float64Array:
    """The lower of what a URDF and a limits file state; 0 in a URDF states nothing."""
    stated = np.where(urdf > 0.0, urdf, np.inf)
    return stated if limits is None else np.minimum(stated, np.where(limits > 0.0, limits, np.inf))


def heavy_enough(arm: Arm, inertia: Float64Array) -> Float64Array:
    """Inertias of joints (joints,), those of light ones raised to a part of the heaviest's."""
    raised, slides = inertia.copy(), _slides(arm)
    for kind in (slides, ~slides):
        raised[kind] = np.maximum(raised[kind], _LIGHTEST * raised[kind].max(initial=0.0))
    return raised


def per_joint(
    value: ArrayLike,
    name: str,
    arm: Arm,
    *,
    above: float | None = None,
    at_least: float | None = None,
) -> Float64Array:
    """A number for each joint (joints,), from as many or from one for all."""
    count = len(arm.joint_names)
    if check.rank(value) == 0:
        value = np.full(count, value)
    numbers = check.array(value, name, shape=(count,))
    for number in numbers:
        check.number(number, name, above=above, at_least=at_least)
    return numbers


def _slides(arm: Arm) -> Any:
    """Marks (joints,) of the joints that slide."""
    path = arm.robot.path(arm.base, arm.tip)
    names = {joint.name for joint in path if joint.kind == "prismatic"}
    return np.array([name in names for name in arm.joint_names])


def _guessed_effort(arm: Arm, slides: Any) -> Float64Array:
    """Torque limits (joints,) of drives whose rotors weigh as a twentieth of the heaviest joint."""
    inertia = np.diag(arm.mass_matrix(arm._chain.middle))
    heaviest = [inertia[slides == kind].max() for kind in slides]
    return _LIGHTEST * np.array(heaviest) / float(_table()["general"]["rotor_inertia"])


def _tabled(arm: Arm, name: str, effort: Float64Array) -> Float64Array:
    """The table's values (joints,) of one quantity."""
    table = _table()
    single = [table["joints"].get(joint, {}).get(name) for joint in arm.joint_names]
    general = table["general"][name] * effort
    return np.array([a if a is not None else b for a, b in zip(single, general, strict=True)])


@cache
def _table() -> dict[str, Any]:
    return tomllib.loads((files(__package__) / "drives.toml").read_text(encoding="utf-8"))

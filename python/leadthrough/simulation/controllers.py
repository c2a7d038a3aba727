"""Controllers of the joints: torques from where the arm should be and where it is.

A controller is a frozen description; `law` makes the function of a run. Each law also states its
own linear model, from which `leadthrough.simulation.theory` tells what error it allows.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import _core, check
from leadthrough.arm import Arm
from leadthrough.check import Float64Array
from leadthrough.guard import CommandedState
from leadthrough.repr import ShortRepr

# Fraction of the heaviest joint's inertia, of turning and of sliding joints apart.
_LIGHTEST = 0.05


@dataclass(frozen=True, eq=False)
class Moment:
    """What a controller knows at the beginning of a period."""

    target: CommandedState  # where the arm should be now, and the acceleration that takes it on
    q: Float64Array  # measured positions (joints,)
    qd: Float64Array  # measured velocities (joints,)
    progress: float  # fraction of the path that the tip has gone, in [0, 1]


@dataclass(frozen=True, eq=False)
class Gains(ShortRepr):
    """What a law answers to small errors, along a motion."""

    stiffness: Float64Array  # (n, joints, joints), N m/rad
    damping: Float64Array  # (n, joints, joints), N m s/rad, without that of the drives
    unmodelled: Float64Array


class Law(ABC):
    """A controller of one arm."""

    def __init__(self, arm: Arm, gravity: Float64Array) -> None:
        self.arm = arm
        self.gravity = gravity
        self._chain = arm._chain
        # N m s/rad (N s/m) per joint, of dampers in the drives: these know their joint's velocity
        # at once, at a far higher rate.
        self.drive_damping = np.zeros(len(arm.joint_names))

    @abstractmethod
    def torques(self, now: Moment) -> Float64Array:
        """Torques (joints,), N m (N), for one period."""

    @abstractmethod
    def gains(self, motion: Motion) -> Gains:
        """The linear model of the law along a motion."""

    def needed(self, q: Float64Array, qd: Float64Array, qdd: Float64Array) -> Float64Array:
        """Torques (joints,) that a motion needs, without any check of the arguments."""
        rows = _core.inverse_dynamics(self._chain, q[None], qd[None], qdd[None], self.gravity)
        return np.asarray(rows[0])

    def held(self, q: Float64Array) -> Float64Array:
        """Torques (joints,) that hold the arm against gravity, likewise."""
        still = np.zeros_like(q)
        return self.needed(q, still, still)


@dataclass(frozen=True, eq=False)
class Motion:
    """Samples (n, joints) of a motion of which a law's linear model is wanted."""

    q: Float64Array  # positions
    mass: Float64Array  # mass matrices (n, joints, joints)
    torques: Float64Array  # that the motion needs
    weight: Float64Array  # of these, those that hold the arm against gravity
    progress: Float64Array  # (n,) fractions of the tip's path


class Controller(ShortRepr, ABC):
    """What simulated arms are controlled by."""

    @abstractmethod
    def law(self, arm: Arm, q: Float64Array, *, gravity: Float64Array) -> Law:
        """The controller at work.

        Args:
            arm: as the controller knows it.
            q: where it begins (joints,), for gains that follow from the arm's inertia.
            gravity: (3,), m/s^2 in the base frame.

        Raises:
            InvalidInput: if gains do not fit the arm.
        """


@dataclass(frozen=True, eq=False)
class ComputedTorque(Controller):
    """Inverse dynamics of the arm, with errors that fade as those of a linear oscillator.

    Joints lighter than a twentieth of the heaviest count as that heavy for their errors, as real
    ones are by their motors: otherwise nothing would hold them against friction.

    Attributes:
        frequency: natural frequency of the error, rad/s, > 0.
        damping_ratio: 1 for no overshoot, > 0.

    Raises:
        InvalidInput: if one is not > 0.

    Source: Siciliano et al. 2009, "Robotics", section 8.5.2.
    """

    frequency: float = 30.0
    damping_ratio: float = 1.0

    def __post_init__(self) -> None:
        _require_positive(self, "frequency", "damping_ratio")

    def law(self, arm: Arm, q: Float64Array, *, gravity: Float64Array) -> Law:
        lacking = _inertias(arm, q) - np.diag(arm.mass_matrix(q))
        return _Linearised(arm, gravity, self, lacking)


class _Linearised(Law):
    def __init__(
        self, arm: Arm, gravity: Float64Array, made: ComputedTorque, lacking: Float64Array
    ) -> None:
        super().__init__(arm, gravity)
        self._k = made.frequency**2
        self._d = 2.0 * made.damping_ratio * made.frequency
        self._springs = self._k * lacking
        self.drive_damping = self._d * lacking

    def torques(self, now: Moment) -> Float64Array:
        target = now.target
        away, slip = target.q - now.q, target.qd - now.qd
        wanted = target.qdd + self._d * slip + self._k * away
        pull = self._springs * away + self.drive_damping * slip
        return self.needed(now.q, now.qd, wanted) + pull

    def gains(self, motion: Motion) -> Gains:
        springs = self._k * motion.mass + np.diag(self._springs)
        return Gains(springs, self._d * motion.mass, np.zeros_like(motion.q))


class _JointSprings(Controller):
    """Springs and dampers of the joints, made when the arm is known."""

    stiffness: ArrayLike | None
    frequency: float
    damping_ratio: float
    _weightless: ClassVar[bool]

    def __post_init__(self) -> None:
        _require_positive(self, "frequency", "damping_ratio")

    def law(self, arm: Arm, q: Float64Array, *, gravity: Float64Array) -> Law:
        springs, dampers = joint_gains(
            arm, q, self.stiffness, frequency=self.frequency, damping_ratio=self.damping_ratio
        )
        return _Springs(arm, gravity, springs, dampers, weightless=self._weightless)


@dataclass(frozen=True, eq=False)
class PositionServo(_JointSprings):
    """A spring and a damper at each joint, without any model of the arm.

    Attributes:
        stiffness: (joints,) or one number, N m/rad (N/m), > 0; by default that which gives the
            inertia of each joint at the start the frequency.
        frequency: natural frequency of the joints, rad/s, > 0; without a stiffness.
        damping_ratio: of each joint with its inertia at the start, > 0.

    Raises:
        InvalidInput: if one is not > 0.
    """

    stiffness: ArrayLike | None = None
    frequency: float = 100.0
    damping_ratio: float = 1.0
    _weightless: ClassVar[bool] = False


@dataclass(frozen=True, eq=False)
class JointImpedance(_JointSprings):
    """As a `PositionServo`, but softer, with torques that carry the arm's weight.

    Attributes:
        stiffness: as there.
        frequency: as there; lower by default.
        damping_ratio: as there.

    Raises:
        InvalidInput: if one is not > 0.

    Source: Albu-Schaeffer, Ott and Hirzinger 2007.
    """

    stiffness: ArrayLike | None = None
    frequency: float = 20.0
    damping_ratio: float = 1.0
    _weightless: ClassVar[bool] = True


class _Springs(Law):
    def __init__(  # the law's own parts
        self,
        arm: Arm,
        gravity: Float64Array,
        springs: Float64Array,
        dampers: Float64Array,
        *,
        weightless: bool,
    ) -> None:
        super().__init__(arm, gravity)
        self._springs, self._weightless = springs, weightless
        self.drive_damping = dampers

    def torques(self, now: Moment) -> Float64Array:
        pull = self._springs * (now.target.q - now.q)
        pull += self.drive_damping * (now.target.qd - now.qd)
        return pull + self.held(now.q) if self._weightless else pull

    def gains(self, motion: Motion) -> Gains:
        count = (len(motion.q), 1, 1)
        left = motion.torques - motion.weight if self._weightless else motion.torques
        springs = np.tile(np.diag(self._springs), count)
        return Gains(springs, np.zeros_like(springs), left)


def joint_gains(
    arm: Arm,
    q: Float64Array,
    stiffness: ArrayLike | None,
    *,
    frequency: float,
    damping_ratio: float,
) -> tuple[Float64Array, Float64Array]:
    """Springs and dampers (joints,) of an arm's joints."""
    inertia = _inertias(arm, q)
    if stiffness is None:
        springs = frequency**2 * inertia
    else:
        springs = per_joint(stiffness, "stiffness", arm, above=0.0)
    return springs, 2.0 * damping_ratio * np.sqrt(springs * inertia)


def _inertias(arm: Arm, q: Float64Array) -> Float64Array:
    """What each joint moves (joints,), kg m^2 (kg); light joints as a part of the heaviest."""
    inertia = np.diag(arm.mass_matrix(q)).copy()
    path = arm.robot.path(arm.base, arm.tip)
    slides = {joint.name for joint in path if joint.kind == "prismatic"}
    kinds = np.array([name in slides for name in arm.joint_names])
    for kind in (kinds, ~kinds):
        inertia[kind] = np.maximum(inertia[kind], _LIGHTEST * inertia[kind].max(initial=0.0))
    return inertia


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
    if np.ndim(value) == 0:
        value = np.full(count, value)
    numbers = check.array(value, name, shape=(count,))
    for number in numbers:
        check.number(number, name, above=above, at_least=at_least)
    return numbers


def _require_positive(made: object, *names: str) -> None:
    for name in names:
        check.number(getattr(made, name), name, above=0.0)

"""Controllers of the joints: torques from where the arm should be and where it is.

A controller is a frozen description; `law` makes the function of a run. Each law also states its
own linear model, from which `leadthrough.simulation.simulate` derives the error that it allows.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check
from leadthrough.arm import Arm
from leadthrough.check import Float64Array, InvalidInput, ShortRepr
from leadthrough.guard import CommandedState
from leadthrough.models import stiffness_profile
from leadthrough.models.protocol import Distributed, Skill
from leadthrough.simulation.drives import heavy_enough, per_joint


@dataclass(frozen=True, eq=False)
class Moment:
    """Inputs of a controller at the beginning of a period."""

    target: CommandedState  # commanded now, with the acceleration until the next one
    q: Float64Array  # measured positions (joints,)
    qd: Float64Array  # measured velocities (joints,)
    progress: float  # fraction of the path that the tip has gone, in [0, 1]


@dataclass(frozen=True, eq=False)
class Gains(ShortRepr):
    """Linear response of a law to small errors, along a motion."""

    stiffness: Float64Array  # (n, joints, joints), N m/rad
    damping: Float64Array  # (n, joints, joints), N m s/rad, without that of the drives
    unmodelled: Float64Array


class Law(ABC):
    """A controller of one arm."""

    def __init__(self, arm: Arm, gravity: Float64Array, rotors: Float64Array) -> None:
        self.arm = arm
        self.gravity = gravity
        self.rotors = rotors
        # kg m^2 (kg) per joint, of the rotors whose acceleration is part of the torques.
        self.fed_forward = np.zeros_like(rotors)
        self._dynamics = arm._dynamics
        # N m s/rad (N s/m) per joint, of dampers in the drives: these know their joint's velocity
        # at once, at a far higher rate.
        self.drive_damping = np.zeros(len(arm.joint_names))
        self.kernel: core.JointLaw | None = None  # the law, if the core has it

    def torques(self, now: Moment) -> Float64Array:
        """Torques (joints,), N m (N), for one period."""
        assert self.kernel is not None
        target = np.array([now.target.q, now.target.qd, now.target.qdd])
        return self.kernel.torques(target, now.q, now.qd)

    @abstractmethod
    def gains(self, motion: Motion) -> Gains:
        """The linear model of the law along a motion."""

    def mass(self, q: Float64Array) -> Float64Array:
        """Mass matrices of configurations (joints,) or (n, joints), rotors included."""
        return np.asarray(self.arm.mass_matrix(q) + np.diag(self.rotors))


@dataclass(frozen=True, eq=False)
class Motion:
    """Samples (n, joints) of a motion of which a law's linear model is wanted."""

    q: Float64Array  # positions
    mass: Float64Array  # mass matrices (n, joints, joints), rotors included
    torques: Float64Array  # that the motion needs
    weight: Float64Array  # of these, those that hold the arm against gravity
    progress: Float64Array  # (n,) fractions of the tip's path


class Controller(ShortRepr, ABC):
    """A controller of simulated arms."""

    @abstractmethod
    def law(self, arm: Arm, q: Float64Array, *, gravity: Float64Array, rotors: Float64Array) -> Law:
        """The controller at work.

        Args:
            arm: as the controller knows it.
            q: first configuration (joints,), for gains that follow from the arm's inertia.
            gravity: (3,), m/s^2 in the base frame.
            rotors: inertias (joints,) of the motors behind their gears, kg m^2 (kg).

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

    Source: Siciliano et al. 2009, "Robotics", section 8.5.2.
    """

    frequency: float = 30.0
    damping_ratio: float = 1.0

    def __post_init__(self) -> None:
        _require_positive(self, "frequency", "damping_ratio")

    def law(self, arm: Arm, q: Float64Array, *, gravity: Float64Array, rotors: Float64Array) -> Law:
        lacking = _inertias(arm, q, rotors) - np.diag(arm.mass_matrix(q)) - rotors
        return _Linearised(arm, gravity, rotors, made=self, lacking=lacking)


class _Linearised(Law):
    def __init__(  # the law's own parts
        self,
        arm: Arm,
        gravity: Float64Array,
        rotors: Float64Array,
        *,
        made: ComputedTorque,
        lacking: Float64Array,
    ) -> None:
        super().__init__(arm, gravity, rotors)
        self.fed_forward = rotors
        self._k = made.frequency**2
        self._d = 2.0 * made.damping_ratio * made.frequency
        self._springs = self._k * lacking
        self.drive_damping = self._d * lacking
        gains = (self._k, self._d), self._springs, self.drive_damping
        self.kernel = core.JointLaw(self._dynamics, gravity, rotors, *gains, "motion")

    def gains(self, motion: Motion) -> Gains:
        springs = self._k * motion.mass + np.diag(self._springs)
        return Gains(springs, self._d * motion.mass, np.zeros_like(motion.q))


@dataclass(frozen=True, eq=False)
class _JointSprings(Controller):
    """Springs and dampers of the joints, made when the arm is known."""

    stiffness: ArrayLike | None = None
    frequency: float = 100.0
    damping_ratio: float = 1.0
    _weightless: ClassVar[bool] = False

    def __post_init__(self) -> None:
        _require_positive(self, "frequency", "damping_ratio")

    def law(self, arm: Arm, q: Float64Array, *, gravity: Float64Array, rotors: Float64Array) -> Law:
        inertia = _inertias(arm, q, rotors)
        if self.stiffness is None:
            springs = self.frequency**2 * inertia
        else:
            springs = per_joint(self.stiffness, "stiffness", arm, above=0.0)
        dampers = 2.0 * self.damping_ratio * np.sqrt(springs * inertia)
        return _Springs(arm, gravity, rotors, gains=(springs, dampers), weightless=self._weightless)


@dataclass(frozen=True, eq=False)
class PositionServo(_JointSprings):
    """A spring and a damper at each joint, without any model of the arm.

    Attributes:
        stiffness: (joints,) or one number, N m/rad (N/m), > 0; by default that which gives the
            inertia of each joint at the start the frequency.
        frequency: natural frequency of the joints, rad/s, > 0; without a stiffness.
        damping_ratio: of each joint with its inertia at the start, > 0.
    """


@dataclass(frozen=True, eq=False)
class JointImpedance(_JointSprings):
    """As a `PositionServo`, but softer, with torques that carry the arm's weight.

    Attributes:
        stiffness: as there.
        frequency: as there; lower by default.
        damping_ratio: as there.

    Source: Albu-Schaeffer, Ott and Hirzinger 2007.
    """

    frequency: float = 20.0
    _weightless: ClassVar[bool] = True


class _Springs(Law):
    def __init__(  # the law's own parts
        self,
        arm: Arm,
        gravity: Float64Array,
        rotors: Float64Array,
        *,
        gains: tuple[Float64Array, Float64Array],
        weightless: bool,
    ) -> None:
        super().__init__(arm, gravity, rotors)
        self._springs, self.drive_damping = gains
        self._weightless = weightless
        model = "weight" if weightless else "none"
        self.kernel = core.JointLaw(self._dynamics, gravity, rotors, (0.0, 0.0), *gains, model)

    def gains(self, motion: Motion) -> Gains:
        count = (len(motion.q), 1, 1)
        left = motion.torques - motion.weight if self._weightless else motion.torques
        springs = np.tile(np.diag(self._springs), count)
        return Gains(springs, np.zeros_like(springs), left)


def _inertias(arm: Arm, q: Float64Array, rotors: Float64Array) -> Float64Array:
    """Inertia of each joint (joints,), kg m^2 (kg); of light joints a part of the heaviest."""
    return heavy_enough(arm, np.diag(arm.mass_matrix(q)) + rotors)


def _require_positive(made: object, *names: str) -> None:
    for name in names:
        check.number(getattr(made, name), name, above=0.0)


_SAMPLES = 100  # of a skill's covariance
_REFRESH = 20  # periods for which damping and null space are kept
# Added to the mobility of the tip, 1/kg, so that directions in which it cannot move count as heavy.
_SINGULAR = 1e-5
_ASYMMETRY = 1e-9  # relative


@dataclass(frozen=True, eq=False)
class CartesianImpedance(Controller):
    """A spring and a damper at the tip, torques that carry the arm's weight, and a posture.

    Attributes:
        stiffness: of the position in the base frame, N/m: one number > 0, a symmetric positive
            definite matrix (3, 3), or such matrices (n, 3, 3) at evenly spaced fractions of the
            length of the tip's path, as `stiffness_profile` returns them.
        turning: stiffness of the orientation, N m/rad, > 0.
        posture: natural frequency, rad/s, > 0, with which joints that the tip does not need keep to
            the planned posture.
        damping_ratio: of the tip with the inertia that it has where it is, > 0.

    Source: Khatib 1987; damping by Albu-Schaeffer et al. 2003.
    """

    stiffness: ArrayLike = 1000.0
    turning: float = 50.0
    posture: float = 20.0
    damping_ratio: float = 1.0

    def __post_init__(self) -> None:
        _require_positive(self, "turning", "posture", "damping_ratio")
        object.__setattr__(self, "stiffness", check.freeze(_matrices(self.stiffness)))

    @classmethod
    def of_skill(
        cls, skill: Skill, arm: Arm, *, softest: float = 200.0, stiffest: float = 2000.0
    ) -> Self:
        """Impedance from a skill's covariance: stiff where demonstrations agree, soft elsewhere.

        Args:
            skill: with a distribution: a ProMP or GMR of points, poses or the arm's joints.
            arm: for skills of joints, whose covariance the Jacobian maps to the tip.
            softest: least stiffness, N/m, > 0.
            stiffest: largest stiffness, N/m, >= softest.

        Raises:
            InvalidInput: if the skill has no distribution of positions.
        """
        if not isinstance(skill, Distributed):
            raise check.refused(
                "skill", "one with a distribution, as ProMP and GMR fit", type(skill).__name__
            )
        mean, covariance = skill.distribution(np.linspace(0.0, skill.duration, _SAMPLES))
        if skill.coordinates.kind == "joints":
            jacobian = arm.jacobian(mean)[:, :3]
            covariance = jacobian @ covariance @ jacobian.transpose(0, 2, 1)
            mean, _ = arm.forward_kinematics(mean)
        elif skill.coordinates.size != 3:
            raise InvalidInput("skill: expected one of points in 3-D, of poses or of joints")
        profile = stiffness_profile(covariance[:, :3, :3], softest=softest, stiffest=stiffest)
        gone = np.linalg.norm(np.diff(mean[:, :3], axis=0), axis=1).cumsum()
        at = np.concatenate([[0.0], gone]) / max(float(gone[-1]), np.finfo(float).tiny)
        even = np.linspace(0.0, 1.0, _SAMPLES)
        entries = [np.interp(even, at, entry) for entry in profile.reshape(_SAMPLES, 9).T]
        return cls(stiffness=np.column_stack(entries).reshape(_SAMPLES, 3, 3))

    def law(
        self,
        arm: Arm,
        q: Float64Array,  # noqa: ARG002  # its gains follow the arm
        *,
        gravity: Float64Array,
        rotors: Float64Array,
    ) -> Law:
        return _AtTip(arm, gravity, rotors, self)


class _AtTip(Law):
    def __init__(
        self, arm: Arm, gravity: Float64Array, rotors: Float64Array, made: CartesianImpedance
    ) -> None:
        super().__init__(arm, gravity, rotors)
        self._made = made
        self._profile = np.asarray(made.stiffness)
        self._spare = (made.posture**2, 2.0 * made.damping_ratio * made.posture)
        self._age = 0
        self._kept: tuple[Float64Array, Float64Array, Float64Array]

    def torques(self, now: Moment) -> Float64Array:
        target, q = now.target, now.q
        jacobian = self.arm.jacobian(q)
        if self._age % _REFRESH == 0:
            spring = self._springs_at(np.array([now.progress]))
            mass = self.mass(q)[None]
            damper, free = self._damping(jacobian[None], mass, spring)
            self._kept = spring[0], damper[0], free[0] @ mass[0]
        self._age += 1
        spring, damper, free = self._kept
        slip = target.qd - now.qd
        away = _pose_error(self.arm, target.q, q)
        at_tip = jacobian.T @ (spring @ away + damper @ (jacobian @ slip))
        spare = self._spare[0] * (target.q - q) + self._spare[1] * slip
        still = np.zeros((1, len(q)))
        weight = self._dynamics.inverse_dynamics(q[None], still, still, self.gravity)[0]
        return np.asarray(at_tip + free @ spare + weight)

    def gains(self, motion: Motion) -> Gains:
        jacobian = self.arm.jacobian(motion.q)
        back = jacobian.transpose(0, 2, 1)
        spring = self._springs_at(motion.progress)
        damper, free = self._damping(jacobian, motion.mass, spring)
        spare = free @ motion.mass
        return Gains(
            back @ spring @ jacobian + self._spare[0] * spare,
            back @ damper @ jacobian + self._spare[1] * spare,
            motion.torques - motion.weight,
        )

    def _springs_at(self, progress: Float64Array) -> Float64Array:
        """Stiffness (n, 6, 6) of position and orientation."""
        at = progress * (len(self._profile) - 1)
        low = np.minimum(at.astype(np.int64), max(len(self._profile) - 2, 0))
        high = np.minimum(low + 1, len(self._profile) - 1)
        part = (at - low)[:, None, None]
        result = np.tile(self._made.turning * np.eye(6), (len(progress), 1, 1))
        result[:, :3, :3] = (1.0 - part) * self._profile[low] + part * self._profile[high]
        return result

    def _damping(
        self, jacobian: Float64Array, mass: Float64Array, spring: Float64Array
    ) -> tuple[Float64Array, Float64Array]:
        """Damping (n, 6, 6) at the tip, and projectors (n, joints, joints) of its null space."""
        back = jacobian.transpose(0, 2, 1)
        ease = np.linalg.inv(mass)
        inertia = np.linalg.inv(jacobian @ ease @ back + _SINGULAR * np.eye(6))
        heavy, stiff = _root(np.asarray(inertia)), _root(spring)
        damper = self._made.damping_ratio * (heavy @ stiff + stiff @ heavy)
        free = np.eye(mass.shape[1]) - back @ inertia @ jacobian @ ease
        return damper, free


def _pose_error(arm: Arm, wanted: Float64Array, q: Float64Array) -> Float64Array:
    """Translation (3,), m, and rotation vector (3,), rad, from the tip to its target."""
    (there, turned), (here, now) = arm.forward_kinematics(wanted), arm.forward_kinematics(q)
    a0, a1, a2, a3 = turned.tolist()
    b0, b1, b2, b3 = now.tolist()
    w = a0 * b0 + a1 * b1 + a2 * b2 + a3 * b3
    turn = np.array(
        [
            a1 * b0 - a0 * b1 - a2 * b3 + a3 * b2,
            a2 * b0 - a0 * b2 - a3 * b1 + a1 * b3,
            a3 * b0 - a0 * b3 - a1 * b2 + a2 * b1,
        ]
    )
    half = math.sqrt(float(turn @ turn))
    # Of the two quaternions of a rotation, that of the shorter turn.
    along = 2.0 * (math.atan2(half, abs(w)) / half if half > 0.0 else 1.0)
    return np.concatenate([there - here, math.copysign(along, w) * turn])


def _root(matrices: Float64Array) -> Float64Array:
    """Square roots of symmetric matrices (n, d, d) without negative eigenvalues."""
    values, axes = np.linalg.eigh(matrices)
    return np.asarray(
        (axes * np.sqrt(np.maximum(values, 0.0))[:, None, :]) @ axes.transpose(0, 2, 1)
    )


def _matrices(stiffness: ArrayLike) -> Float64Array:
    """Stiffnesses (n, 3, 3), each symmetric and positive definite."""
    if check.rank(stiffness) == 0:
        stiffness = check.number(stiffness, "stiffness", above=0.0) * np.eye(3)
    given = check.array_of_rank(stiffness, "stiffness", shapes=((3, 3), ("n", 3, 3)))
    matrices = given if given.ndim == 3 else given[None]
    slack = _ASYMMETRY * np.abs(matrices).max(initial=0.0)
    lopsided = np.abs(matrices - matrices.transpose(0, 2, 1)).max(initial=0.0) > slack
    if len(matrices) == 0 or lopsided or np.linalg.eigvalsh(matrices).min() <= 0.0:
        raise InvalidInput(
            "stiffness: expected a number > 0 or symmetric, positive definite matrices"
        )
    return matrices.copy()

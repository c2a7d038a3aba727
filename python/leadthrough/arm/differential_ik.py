"""Closed-loop inverse kinematics for control loops: one step per interval."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check
from leadthrough.arm import magnitudes
from leadthrough.arm.arm import Arm, check_arm
from leadthrough.arm.limits import known_acceleration
from leadthrough.check import Float64Array, ShortRepr

_FREE = np.empty(0)
_STILL = np.zeros(6)


@dataclass(frozen=True, eq=False, slots=True)
class JointState(ShortRepr):
    """Joint positions and velocities.

    Attributes:
        q: (joints,) in rad (m for prismatic joints).
        qd: (joints,) in rad/s (m/s).
        position_error: distance from the target in m before the step that led here.
        orientation_error: angle from the target in rad before that step; 0 if the target's
            orientation is free.
    """

    q: Float64Array
    qd: Float64Array
    position_error: float = 0.0
    orientation_error: float = 0.0


@dataclass(frozen=True, eq=False, init=False)
class DifferentialIk(ShortRepr):
    """Steps an arm's joints towards a target that may move, inside the limits.

        ik = lt.DifferentialIk(arm)
        state = ik.start(q)
        while True:
            state = ik.step(state, position, orientation)   # every ik.dt; command state.q

    Positions, velocities and, where they are known, accelerations stay inside the arm's limits in
    every step. Near singularities the step is damped: the joints slow down and do not jump.

    Attributes:
        arm: the arm.
        dt: the control loop's interval in s, 1e-6 to 10.
        gain: rate in 1/s, > 0, at which the error decays. It is lower where the joints could not
            keep to their velocity limits or brake in time; then all slow down together.
        posture: configuration (joints,) towards which the joints move in the null space, which
            leaves the tool in place; by default the middle of their ranges.
        nullspace_gain: rate in 1/s, >= 0, of that motion.

    Source: Nakamura and Hanafusa 1986 (damped step); Flacco, De Luca and Khatib 2015 (limits).
    """

    arm: Arm
    dt: float
    gain: float
    posture: Float64Array
    nullspace_gain: float
    _solver: core.DifferentialIk = field(init=False, repr=False)
    _joints: int = field(init=False, repr=False)

    def __init__(
        self,
        arm: Arm,
        *,
        dt: float = 1e-3,
        gain: float = 20.0,
        posture: ArrayLike | None = None,
        nullspace_gain: float = 1.0,
    ) -> None:
        check_arm(arm)
        chain, joints = arm._chain, len(arm.joint_names)
        interval = magnitudes.interval(dt)
        rate = magnitudes.positive(gain, "gain")
        null_rate = magnitudes.not_negative(nullspace_gain, "nullspace_gain")
        preferred = chain.middle if posture is None else posture
        preferred = magnitudes.frozen(preferred, "posture", shape=(joints,))
        limits = (arm.limits.velocity, known_acceleration(arm.limits))
        vars(self).update(
            arm=arm,
            dt=interval,
            gain=rate,
            posture=preferred,
            nullspace_gain=null_rate,
            _solver=core.DifferentialIk(chain, *limits, preferred, interval, rate, null_rate),
            _joints=joints,
        )

    def __reduce__(self) -> tuple[Any, ...]:
        names = ("dt", "gain", "posture", "nullspace_gain")
        return partial(DifferentialIk, **{name: getattr(self, name) for name in names}), (self.arm,)

    def start(self, q: ArrayLike, qd: ArrayLike | None = None) -> JointState:
        """The state to start in.

        Args:
            q: configuration (joints,) in rad (m).
            qd: velocities (joints,) in rad/s (m/s); by default at rest.
        """
        still = np.zeros(self._joints) if qd is None else qd
        return JointState(
            magnitudes.values(q, "q", shape=(self._joints,)).copy(),
            magnitudes.values(still, "qd", shape=(self._joints,)).copy(),
        )

    def step(
        self,
        state: JointState,
        position: ArrayLike,
        orientation: ArrayLike | None = None,
        *,
        twist: ArrayLike | None = None,
    ) -> JointState:
        """The state one interval later.

        Args:
            position: of the target, (3,) in m, base frame.
            orientation: of the target, (4,) w, x, y, z; None leaves it free.
            twist: of the target itself, (6,) in m/s and rad/s, linear first, base frame; zero by
                default.
        """
        target = _FREE if orientation is None else orientation
        moving = _STILL if twist is None else twist
        try:  # the fast path: arrays as the kernel takes them, which checks them itself
            quick = self._solver.step(state.q, state.qd, position, target, moving)  # type: ignore[arg-type]
            return JointState(*quick)
        except (AttributeError, TypeError, ValueError):
            return JointState(*self._solver.step(*self._checked(state, position, target, moving)))

    def _checked(
        self, state: Any, position: ArrayLike, orientation: ArrayLike, twist: ArrayLike
    ) -> tuple[Float64Array, ...]:
        check.instance(state, "state", JointState)
        if orientation is not _FREE:
            check.quaternions(orientation, "orientation", shape=(4,))
        return (
            magnitudes.values(state.q, "state.q", shape=(self._joints,)),
            magnitudes.values(state.qd, "state.qd", shape=(self._joints,)),
            magnitudes.values(position, "position", shape=(3,)),
            magnitudes.values(orientation, "orientation", shape=("n",)),  # the kernel normalises it
            magnitudes.values(twist, "twist", shape=(6,)),
        )

"""Closed-loop inverse kinematics for control loops: one step an interval."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass, field
from typing import Any

import numpy as np

from leadthrough import _core, check
from leadthrough.arm import magnitudes
from leadthrough.arm.arm import Arm
from leadthrough.arm.task_stack import accelerations
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput

_FREE = np.empty(0)
_STILL = np.zeros(6)


@dataclass(frozen=True, eq=False, slots=True)
class JointState:
    """q: (joints,) rad, qd: (joints,) rad/s (m for prismatic joints).

    position_error, orientation_error: m and rad from the target before the step that led here; the
    second is 0 where no orientation was asked for.
    """

    q: Float64Array
    qd: Float64Array
    position_error: float = 0.0
    orientation_error: float = 0.0


@dataclass(frozen=True, eq=False)
class DifferentialIk:
    """Steps an arm's joints towards a target that may move, inside the limits.

        ik = lt.DifferentialIk(arm)
        state = ik.start(q)
        while True:
            state = ik.step(state, position, orientation)   # every ik.dt; command state.q

    dt: s, the control loop's interval. gain: 1/s, the rate at which the error decays; less where
    the joints could not keep to their velocity limits or brake in time, all slowing down together.
    posture: (joints,), where the null space pulls the joints at posture_gain, 1/s; None is the
    middle of their ranges. It does not move the tool.
    Positions, velocities and, where they are known, accelerations stay inside the arm's limits in
    every step. Near singularities the step is damped: the joints slow down and do not jump.
    Raises InvalidInput.
    Sources: Nakamura and Hanafusa 1986 (damped step); Flacco, De Luca and Khatib 2015 (limits).
    """

    arm: Arm
    _: KW_ONLY
    dt: float = 1e-3
    gain: float = 20.0
    posture: Float64Array | None = None
    posture_gain: float = 1.0
    _solver: _core.DifferentialIk = field(init=False, repr=False)
    _joints: int = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self._set("dt", magnitudes.interval(self.dt))
        self._set("gain", magnitudes.positive(self.gain, "gain"))
        rate = magnitudes.not_negative(self.posture_gain, "posture_gain")
        self._set("posture_gain", rate)
        chain, joints = self.arm._chain, len(self.arm.joint_names)
        posture = chain.middle if self.posture is None else self.posture
        posture = magnitudes.frozen(posture, "posture", shape=(joints,))
        self._set("posture", posture)
        self._set("_joints", joints)
        limits = (self.arm.limits.velocity, accelerations(self.arm))
        solver = _core.DifferentialIk(chain, *limits, posture, self.dt, self.gain, rate)
        self._set("_solver", solver)

    def __reduce__(self) -> tuple[Any, ...]:
        options = (self.dt, self.gain, self.posture, self.posture_gain)
        return _restored, (self.arm, *options)

    def _set(self, name: str, value: Any) -> None:
        object.__setattr__(self, name, value)

    def start(self, q: Any, qd: Any = None) -> JointState:
        """The state at q, (joints,), moving at qd, (joints,), or at rest. Raises InvalidInput."""
        still = np.zeros(self._joints) if qd is None else qd
        return JointState(
            magnitudes.values(q, "q", shape=(self._joints,)).copy(),
            magnitudes.values(still, "qd", shape=(self._joints,)).copy(),
        )

    def step(
        self, state: JointState, position: Any, orientation: Any = None, *, twist: Any = None
    ) -> JointState:
        """The state one interval later.

        position: (3,) m. orientation: (4,) w, x, y, z; None leaves it free. twist: (6,) of the
        target itself, linear first, base frame, m/s and rad/s. Raises InvalidInput.
        """
        turned = _FREE if orientation is None else orientation
        moving = _STILL if twist is None else twist
        try:  # the quick way: arrays as the kernel takes them, which looks at them itself
            return JointState(*self._solver.step(state.q, state.qd, position, turned, moving))
        except (AttributeError, TypeError, ValueError):
            return JointState(*self._solver.step(*self._checked(state, position, turned, moving)))

    def _checked(
        self, state: Any, position: Any, orientation: Any, twist: Any
    ) -> tuple[Float64Array, ...]:
        if not isinstance(state, JointState):
            raise InvalidInput(f"state: expected a JointState, got {type(state).__name__}")
        if orientation is not _FREE:
            check.quaternions(orientation, "orientation", shape=(4,))
        return (
            magnitudes.values(state.q, "state.q", shape=(self._joints,)),
            magnitudes.values(state.qd, "state.qd", shape=(self._joints,)),
            magnitudes.values(position, "position", shape=(3,)),
            magnitudes.values(orientation, "orientation", shape=("n",)),  # the kernel normalises it
            magnitudes.values(twist, "twist", shape=(6,)),
        )


def _restored(
    arm: Arm, dt: float, gain: float, posture: Float64Array, posture_gain: float
) -> DifferentialIk:
    return DifferentialIk(arm, dt=dt, gain=gain, posture=posture, posture_gain=posture_gain)

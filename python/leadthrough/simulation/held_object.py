"""Simulation of two arms that carry an object, which is welded to both hands."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.arm import GRAVITY, Arm, HeldObject
from leadthrough.arm.attachment import Load
from leadthrough.arm.rigid_transforms import Transforms
from leadthrough.check import Float64Array, InvalidInput, ShortRepr
from leadthrough.guard.admission import CommandedState, chunk_of
from leadthrough.motion import JointTrajectory, in_order
from leadthrough.simulation.controllers import ComputedTorque, Controller, Law, Moment
from leadthrough.simulation.drives import (
    RUNAWAY,
    Disturbances,
    Drives,
    RunawayError,
    drives_of,
)
from leadthrough.simulation.model import LINK, add_parts, set_inertia, specified

_RIGHT = "right "  # before the names of the right arm's bodies and joints
_OBJECT = "object"
_STIFF = (4.0, 1.0)  # of the welds: periods to correct an error, and damping ratio
_SETTLING = 0.2  # s that the object is held after the end


@dataclass(frozen=True, eq=False)
class HeldSimulation(ShortRepr):
    """Two simulated arms that carried an object.

    Attributes:
        planned: joints of both arms, one sample a period.
        simulated: joints that they had.
        torques: of the motors, (n, joints), N m (N).
        relative_errors: distances (n,) in m of the right tip from where it belongs to the left one.
        relative_angles: the same of its orientation, rad.
        forces: of the left and of the right hand on the object, (n, 2, 3) N in the pair's frame.
        inner_forces: the part of them that presses or pulls the object without moving it, (n,) N:
            half the difference of both along the line through the tips.
    """

    planned: JointTrajectory
    simulated: JointTrajectory
    torques: Float64Array
    relative_errors: Float64Array
    relative_angles: Float64Array
    forces: Float64Array
    inner_forces: Float64Array

    def __str__(self) -> str:
        most = np.abs(self.planned.positions - self.simulated.positions).max()
        return (
            f"hands within {1e3 * self.relative_errors.max():.2g} mm and "
            f"{np.degrees(self.relative_angles.max()):.2g} degrees of each other's place, inner "
            f"forces up to {self.inner_forces.max():.3g} N, joints within {most:.2g} rad (m)"
        )


def simulate_held(
    held: HeldObject,
    trajectory: JointTrajectory,
    *,
    controller: Controller | None = None,
    disturbances: Disturbances | None = None,
    gravity: ArrayLike = GRAVITY,
    rate: float = 1000.0,
) -> HeldSimulation:
    """A motion of two arms that carry an object, under gravity and a controller of either.

    The object is a body of its own, welded to both hands. Each controller knows its arm with half
    of the object's mass. Contacts of the object are not simulated: `check` tells its distances.

    Args:
        held: the object and the pair, made by `DualArm.with_object` with a mass.
        trajectory: of the joints of both arms, at any rate.
        controller: of either arm, by default a `ComputedTorque`.
        disturbances: of either arm, by default those of real ones.
        gravity: acceleration (3,) of gravity in the frame of the pair, m/s^2.
        rate: of the controllers, Hz, 100 to 1e4.

    Raises:
        InvalidInput: if the pair holds no object with a mass, or is one robot.
        MissingDependency: if the extra `simulation` is not installed.
        FloatingPointError: if a joint runs away: the gains are too high for the rate, or the hands'
            motions do not fit the grasps.
    """
    mujoco = check.package("mujoco", extra="simulation")
    if not isinstance(held, HeldObject):
        raise check.refused("held", "a HeldObject", type(held).__name__)
    period = 1.0 / check.number(rate, "rate", at_least=100.0, at_most=1e4)
    pull = check.array(gravity, "gravity", shape=(3,))
    rows = chunk_of(in_order(trajectory, held.joint_names, "trajectory"), held.pair, period).rows
    q = np.concatenate([rows, np.repeat(rows[-1:], round(_SETTLING / period), axis=0)])
    carried = _Carried.of(held)
    sides = [
        _Side(arm, load, disturbances, controller, pull=turned, period=period, q=own)
        for arm, load, turned, own in zip(
            carried.arms, carried.loads, carried.turned(pull), held.pair.split(q), strict=True
        )
    ]
    run = _Run(mujoco, _model(mujoco, carried, sides, pull, period), sides)
    found = [run.step(k) for k in range(len(q))]
    there, torques, forces = (np.array(part) for part in zip(*found, strict=True))
    times, names = period * np.arange(len(q)), held.joint_names
    wanted = Transforms.of(held.grasps[0], "grasps").inverse() @ Transforms.of(
        held.grasps[1], "grasps"
    )
    away, turned = Transforms(*held.pair.relative_pose(there)).distances(wanted)
    between = held.pair.forward_kinematics(there)[0]
    line = between[:, 1] - between[:, 0]
    line /= np.linalg.norm(line, axis=1)[:, None]
    return HeldSimulation(
        JointTrajectory(times, q, joint_names=names),
        JointTrajectory(times, there, joint_names=names),
        torques,
        away,
        turned,
        forces,
        0.5 * np.abs(np.einsum("nd,nd->n", forces[:, 0] - forces[:, 1], line)),
    )


@dataclass(frozen=True, eq=False)
class _Carried:
    """Both arms without the object, and the object in the frame of the left tip's link."""

    arms: tuple[Arm, Arm]
    placement: Transforms  # of the right base
    body: Load
    shape: Any
    right: Transforms  # of the right tip's link in that of the left one
    loads: tuple[Load, Load]  # half of the object, in the frames of the tips

    @staticmethod
    def of(held: HeldObject) -> _Carried:
        pair = held.pair
        attached = pair.left.attachment
        if not pair.shared_object or not attached.loads or not attached.shapes:
            raise InvalidInput(
                "held: expected a pair with an object that has a mass; use "
                "pair.with_object(shape, grasps, mass=...)"
            )
        if pair.base is None:
            raise InvalidInput("held: expected two robots, got two arms of one")
        body, shape = attached.loads[-1], attached.shapes[-1]
        bare = replace(attached, loads=attached.loads[:-1], shapes=attached.shapes[:-1])
        left = replace(pair.left, attachment=bare)
        tips = [
            Transforms(each.attachment.position[None], each.attachment.orientation[None])
            for each in (left, pair.right)
        ]
        grasps = [Transforms.of(grasp, "grasps") for grasp in held.grasps]
        right = tips[0] @ grasps[0].inverse() @ grasps[1] @ tips[1].inverse()
        halves = tuple(_half(body, frame.inverse()) for frame in (tips[0], right @ tips[1]))
        return _Carried(
            (left, pair.right), pair._placement, body, shape, right, (halves[0], halves[1])
        )

    def turned(self, vector: Float64Array) -> list[Float64Array]:
        """A vector of the pair's frame in the base frame of either arm."""
        return [vector, self.placement.matrices()[0].T @ vector]


def _half(body: Load, frame: Transforms) -> Load:
    """Half of a body, in another frame."""
    turn = frame.matrices()[0]
    center = frame.positions[0] + turn @ body.center
    inertia = 0.5 * turn @ body.inertia @ turn.T
    return Load(0.5 * body.mass, center, 0.5 * (inertia + inertia.T))


class _Side:
    """The controller of one arm, and its measurements."""

    def __init__(
        self,
        arm: Arm,
        load: Load,
        disturbances: Disturbances | None,
        controller: Controller | None,
        *,
        pull: Float64Array,
        period: float,
        q: Float64Array,
    ) -> None:
        self.arm, self._period = arm, period
        unknown = Disturbances() if disturbances is None else disturbances
        self.drives: Drives = drives_of(arm, unknown, period)
        loaded = arm.with_payload(load.mass, load.center, inertia=load.inertia)
        law = ComputedTorque() if controller is None else controller
        self.law: Law = law.law(loaded, q[0], gravity=pull, rotors=self.drives.rotors)
        self.q = q
        self.qd = np.diff(q, axis=0, prepend=q[:1]) / period
        self.qdd = np.diff(self.qd, axis=0, append=self.qd[-1:]) / period
        late = self.drives.late
        self._seen = deque([self.drives.encoded(q[0])] * (late + 2), maxlen=late + 2)

    def control(self, k: int, q: Float64Array) -> Float64Array:
        """Torques (joints,) that the motors are asked for in period k, at given joints."""
        self._seen.append(self.drives.encoded(q))
        seen = self._seen[1]
        speed = (seen - self._seen[0]) / self._period
        target = check.computed(CommandedState, q=self.q[k], qd=self.qd[k], qdd=self.qdd[k])
        asked = self.law.torques(Moment(target, seen, speed, k / len(self.q)))
        return np.asarray(asked + self.law.drive_damping * (speed + self._period * self.qdd[k]))


def _model(
    mujoco: Any, carried: _Carried, sides: list[_Side], pull: Float64Array, period: float
) -> Any:
    """Both arms with the object, welded to the links of both tips."""
    specs = [
        specified(
            side.arm,
            motors=side.drives,
            drive_damping=side.law.drive_damping,
            gravity=pull,
            period=period,
        )[0]
        for side in sides
    ]
    whole, right = specs
    position, orientation = carried.placement.single()
    frame = whole.worldbody.add_frame(pos=position, quat=orientation)
    whole.attach(right, prefix=_RIGHT, frame=frame)
    body = whole.worldbody.add_body(name=_OBJECT)
    body.add_freejoint()
    set_inertia(body, _OBJECT, carried.body, driven=True)
    add_parts(whole, body, carried.shape.convex_parts())
    for geom in body.geoms:
        geom.contype = geom.conaffinity = 0
    tips = (LINK + sides[0].arm.tip, _RIGHT + LINK + sides[1].arm.tip)
    for name, place in zip(tips, (Transforms.identity(), carried.right.inverse()), strict=True):
        weld = whole.add_equality(
            type=mujoco.mjtEq.mjEQ_WELD, name1=name, name2=_OBJECT, objtype=mujoco.mjtObj.mjOBJ_BODY
        )
        weld.data[:11] = [0.0] * 3 + [*place.positions[0], *place.orientations[0]] + [1.0]
        weld.solref = (_STIFF[0] * period, _STIFF[1])
    return whole.compile()


class _Run:
    """The simulation, one period at a time."""

    def __init__(self, mujoco: Any, model: Any, sides: list[_Side]) -> None:
        self._mujoco, self._model, self._sides = mujoco, model, sides
        self._data = data = mujoco.MjData(model)
        names = [
            [prefix + name for name in side.arm.joint_names]
            for prefix, side in zip(("", _RIGHT), sides, strict=True)
        ]
        self._places = [[model.joint(name).qposadr[0] for name in own] for own in names]
        self._speeds = [[model.joint(name).dofadr[0] for name in own] for own in names]
        self._motors = [[model.actuator(name).id for name in own] for own in names]
        self._welds = [i for i in range(model.neq) if model.eq_type[i] == mujoco.mjtEq.mjEQ_WELD]
        for place, side in zip(self._places, sides, strict=True):
            data.qpos[place] = side.q[0]
        mujoco.mj_kinematics(model, data)
        tip = data.body(LINK + sides[0].arm.tip)
        first = model.body(_OBJECT).jntadr[0]
        at = model.jnt_qposadr[first]
        data.qpos[at : at + 7] = [*tip.xpos, *tip.xquat]
        mujoco.mj_forward(model, data)

    def step(self, k: int) -> tuple[Float64Array, Float64Array, Float64Array]:
        """Joints before it, torques (joints,) and the forces (2, 3) of the hands on the object."""
        data = self._data
        before = np.concatenate([data.qpos[place] for place in self._places])
        for place, motors, side in zip(self._places, self._motors, self._sides, strict=True):
            data.ctrl[motors] = side.control(k, np.array(data.qpos[place]))
        self._mujoco.mj_step(self._model, data)
        self._stop_runaway(k)
        torques = np.concatenate([data.actuator_force[motors] for motors in self._motors])
        return before, torques, np.array([self._force(weld) for weld in self._welds])

    def _stop_runaway(self, k: int) -> None:
        for speeds, side in zip(self._speeds, self._sides, strict=True):
            fast = np.abs(self._data.qvel[speeds])
            if not fast.max() < RUNAWAY:
                joint = int(fast.argmax())
                time = (k + 1) * self._model.opt.timestep
                raise RunawayError(side.arm.joint_names[joint], time, joint)

    def _force(self, weld: int) -> Float64Array:
        """Of a hand on the object, (3,) N in the frame of the pair."""
        data = self._data
        own = (data.efc_type == self._mujoco.mjtConstraint.mjCNSTR_EQUALITY) & (data.efc_id == weld)
        return -np.array(data.efc_force[np.flatnonzero(own)[:3]])  # MuJoCo's is that on the hand

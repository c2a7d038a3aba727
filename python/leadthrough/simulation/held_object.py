"""Simulation of two arms that carry an object, which is welded to both hands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.arm import Arm, HeldObject
from leadthrough.arm.attachment import Load
from leadthrough.arm.rigid_transforms import Transforms, checked_grasps
from leadthrough.check import Float64Array, InvalidInput, ShortRepr
from leadthrough.guard.admission import chunk_of
from leadthrough.motion import JointTrajectory, in_order
from leadthrough.simulation.controllers import Controller
from leadthrough.simulation.drives import Disturbances
from leadthrough.simulation.model import LINK, add_parts, set_inertia, specified
from leadthrough.simulation.simulated_arm import SimulatedArm

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
    gravity: ArrayLike | None = None,
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
        gravity: acceleration (3,) of gravity in the pair's frame, m/s^2; by default the left arm's.
        rate: of the controllers, Hz, 100 to 1e4.

    Raises:
        InvalidInput: if the pair holds no object with a mass, or is one robot.
        MissingDependency: if the extra `simulation` is not installed.
        FloatingPointError: if a joint runs away: the gains are too high for the rate, or the hands'
            motions do not fit the grasps.
    """
    mujoco = check.package("mujoco", extra="simulation")
    check.instance(held, "held", HeldObject)
    carried = _Carried.of(held)
    own = held.pair.left.gravity
    pull = check.array(own if gravity is None else gravity, "gravity", shape=(3,))
    period = 1.0 / check.number(rate, "rate", at_least=100.0, at_most=1e4)
    rows = chunk_of(in_order(trajectory, held.joint_names, "trajectory"), held.pair, period).rows
    q = np.concatenate([rows, np.repeat(rows[-1:], round(_SETTLING / period), axis=0)])
    pulls = pull, carried.placement.matrices()[0].T @ pull  # in the base frame of either arm
    driven = partial(SimulatedArm, controller=controller, disturbances=disturbances, rate=rate)
    sides = [
        driven(arm, first, gravity=own)
        for arm, first, own in zip(carried.loaded, held.pair.split(q[0]), pulls, strict=True)
    ]
    model = _model(mujoco, carried, sides, pull)
    there, torques, forces = _run(mujoco, model, sides, held.pair.split(q))
    wanted = carried.grasps[0].inverse() @ carried.grasps[1]
    away, angles = Transforms(*held.pair.relative_pose(there)).distances(wanted)
    tips = held.pair.forward_kinematics(there)[0]
    line = tips[:, 1] - tips[:, 0]
    line /= np.linalg.norm(line, axis=1)[:, None]
    times, names = period * np.arange(len(q)), held.joint_names
    return HeldSimulation(
        JointTrajectory(times, q, joint_names=names),
        JointTrajectory(times, there, joint_names=names),
        torques,
        away,
        angles,
        forces,
        0.5 * np.abs(np.einsum("nd,nd->n", forces[:, 0] - forces[:, 1], line)),
    )


@dataclass(frozen=True, eq=False)
class _Carried:
    """Both arms without the object, and the object in the frame of the left tip's link."""

    arms: tuple[Arm, Arm]
    loaded: tuple[Arm, Arm]  # with half of the object, as their controllers know them
    placement: Transforms  # of the right base
    grasps: tuple[Transforms, Transforms]
    body: Load
    shape: Any
    right: Transforms  # of the right tip's link in that of the left one

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
        arms = replace(pair.left, attachment=bare), pair.right
        left, right = (Transforms.of(arm.tool, "tool") for arm in arms)
        grasps = checked_grasps(held.grasps, Transforms.of)
        across = left @ grasps[0].inverse() @ grasps[1] @ right.inverse()
        loaded = _loaded(arms[0], body, left), _loaded(arms[1], body, across @ right)
        return _Carried(arms, loaded, pair._placement, grasps, body, shape, across)


def _loaded(arm: Arm, body: Load, tip: Transforms) -> Arm:
    """The arm with half of a body, at whose frame its tip is."""
    frame = tip.inverse()
    turn = frame.matrices()[0]
    inertia = 0.5 * turn @ body.inertia @ turn.T
    center = frame.positions[0] + turn @ body.center
    return arm.with_payload(0.5 * body.mass, center, inertia=0.5 * (inertia + inertia.T))


def _model(mujoco: Any, carried: _Carried, sides: list[SimulatedArm], pull: Float64Array) -> Any:
    """Both arms with the object, welded to the links of both tips."""
    whole, right = (
        specified(
            arm,
            motors=side.drives,
            drive_damping=side.law.drive_damping,
            gravity=pull,
            period=side.period / max(each.steps for each in sides),
        )[0]
        for arm, side in zip(carried.arms, sides, strict=True)
    )
    position, orientation = carried.placement.single()
    frame = whole.worldbody.add_frame(pos=position, quat=orientation)
    whole.attach(right, prefix=_RIGHT, frame=frame)
    body = whole.worldbody.add_body(name=_OBJECT)
    body.add_freejoint(name=_OBJECT)
    set_inertia(body, _OBJECT, carried.body, driven=True)
    add_parts(whole, body, carried.shape.convex_parts())
    for geom in body.geoms:
        geom.contype = geom.conaffinity = 0
    tips = (LINK + carried.arms[0].tip, _RIGHT + LINK + carried.arms[1].tip)
    for name, place in zip(tips, (Transforms.identity(), carried.right.inverse()), strict=True):
        weld = whole.add_equality(
            type=mujoco.mjtEq.mjEQ_WELD, name1=name, name2=_OBJECT, objtype=mujoco.mjtObj.mjOBJ_BODY
        )
        weld.data[:11] = [0.0] * 3 + [*place.positions[0], *place.orientations[0]] + [1.0]
        weld.solref = (_STIFF[0] * sides[0].period, _STIFF[1])
    return whole.compile()


def _run(
    mujoco: Any, model: Any, sides: list[SimulatedArm], motions: Sequence[Float64Array]
) -> tuple[Float64Array, Float64Array, Float64Array]:
    """Joints (n, joints), torques (n, joints), and forces (n, 2, 3) of the hands on the object."""
    data = _begun(mujoco, model, sides)
    commands = [_commands(side, q) for side, q in zip(sides, motions, strict=True)]
    welds = [i for i in range(model.neq) if model.eq_type[i] == mujoco.mjtEq.mjEQ_WELD]
    rows = []
    for k, now in enumerate(zip(*commands, strict=True)):
        there = np.concatenate([side.q for side in sides])
        progress = k / len(commands[0])
        periods = (side._period(to, progress) for side, to in zip(sides, now, strict=True))
        for _ in zip(*periods, strict=True):
            mujoco.mj_step(model, data)
        torques = np.concatenate([side.torques for side in sides])
        rows.append((there, torques, [_force(mujoco, data, weld) for weld in welds]))
    joints, torques, forces = (np.array(part) for part in zip(*rows, strict=True))
    return joints, torques, forces


def _begun(mujoco: Any, model: Any, sides: list[SimulatedArm]) -> Any:
    """Both arms where they begin, and the object in the left hand."""
    data, steps = mujoco.MjData(model), max(side.steps for side in sides)
    for side, prefix in zip(sides, ("", _RIGHT), strict=True):
        side._share(model, data, prefix, steps)
    mujoco.mj_kinematics(model, data)
    tip, at = data.body(sides[0].plant.tip), model.joint(_OBJECT).qposadr[0]
    data.qpos[at : at + 7] = [*tip.xpos, *tip.xquat]
    mujoco.mj_forward(model, data)
    return data


def _commands(side: SimulatedArm, q: Float64Array) -> Float64Array:
    """States (n, 3, joints), one for the end of each period, with the acceleration during it."""
    qd = np.diff(q, axis=0, prepend=q[:1]) / side.period
    qdd = np.diff(qd, axis=0, append=qd[-1:]) / side.period
    after = [*range(1, len(q)), len(q) - 1]
    return np.stack([q[after], qd[after], qdd], axis=1)


def _force(mujoco: Any, data: Any, weld: int) -> Float64Array:
    """Of a hand on the object, (3,) N in the frame of the pair."""
    own = (data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY) & (data.efc_id == weld)
    return -np.array(data.efc_force[np.flatnonzero(own)[:3]])  # MuJoCo's is that on the hand

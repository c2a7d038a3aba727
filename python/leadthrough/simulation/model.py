"""An arm as a MuJoCo model, made from what its URDF states; no scene file is read."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

import leadthrough._core as core
from leadthrough import check, rotations, sanity
from leadthrough.arm import Arm
from leadthrough.arm.attachment import Load
from leadthrough.arm.link_geometry import convex_parts, link_poses
from leadthrough.check import Float64Array, InvalidRobot
from leadthrough.shapes import Shape
from leadthrough.shapes.shape import ConvexPart
from leadthrough.simulation.drives import Drives, stricter

ATTACHED = "attached"  # as collision reports call it
LINK = "link "  # before the names of links, of which one may be "world", as MuJoCo calls its own
# MuJoCo refuses moving bodies without a mass, kg and kg m^2: too little to be felt.
_MIN_INERTIA = 1e-13
_TOUCHING = 1e-6  # m: bodies that overlap by less touch, as collision checks count it
_BALANCED = 1e-9  # of the largest moment, by which the sum of the others exceeds it


@dataclass(frozen=True, eq=False)
class Plant:
    """A compiled model and where the arm's joints are in it."""

    model: Any  # `mujoco.MjModel`
    joints: NDArray[np.int64]
    drives: tuple[tuple[int, float, float], ...]
    tip: int  # index of the body of the tip link
    velocity: Float64Array  # (joints,), rad/s (m/s), infinite where no limit is known
    stated_velocity: Float64Array  # (joints,), rad/s (m/s), of the URDF alone
    motors: slice  # of the model's, those of the arm

    def coordinates(self, q: Float64Array) -> Float64Array:
        """Positions of all joints of the model, from the arm's own (joints,)."""
        return np.array([factor * q[joint] + offset for joint, factor, offset in self.drives])


def plant(
    arm: Arm,
    obstacles: Sequence[Shape],
    *,
    motors: Drives,
    drive_damping: Float64Array,
    gravity: Float64Array,
    period: float,
) -> Plant:
    spec, drives = specified(
        arm, motors=motors, drive_damping=drive_damping, gravity=gravity, period=period
    )
    # One arm is one island: to look for more takes a twentieth of a step.
    flags = check.package("mujoco", extra="simulation").mjtDisableBit
    spec.option.disableflags |= flags.mjDSBL_ISLAND
    for i, shape in enumerate(obstacles):
        add_parts(spec, spec.worldbody.add_body(name=f"obstacle {i}"), shape.convex_parts())
    own = core.Chain(arm._robot, arm.base, arm.tip)
    try:
        model = spec.compile()
    except ValueError as error:
        raise InvalidRobot("robot", f"MuJoCo cannot simulate it: {error}") from None
    order = [model.joint(name) for name in drives]
    joints = [model.joint(name).dofadr[0] for name in arm.joint_names]
    placed = {each.qposadr[0]: drives[each.name] for each in order}
    return Plant(
        model,
        np.array(joints, dtype=np.int64),
        tuple(placed[i] for i in range(len(placed))),
        model.body(LINK + arm.tip).id,
        stricter(own.velocity, arm.limits.velocity),
        stricter(own.velocity, None),
        slice(0, len(arm.joint_names)),
    )


def specified(
    arm: Arm,
    *,
    motors: Drives,
    drive_damping: Float64Array,
    gravity: Float64Array,
    period: float,
) -> tuple[Any, dict[str, tuple[int, float, float]]]:
    """A model of an arm that is not compiled yet, and what drives each of its joints."""
    mujoco = check.package("mujoco", extra="simulation")
    arm._require_masses()
    spec = mujoco.MjSpec()
    _set_options(mujoco, spec, gravity, period)
    _add_links(mujoco, spec, arm, link_inertias(arm, payload=motors.payload))
    for a, b in _unchecked_pairs(arm):
        spec.add_exclude(bodyname1=_body_name(a), bodyname2=_body_name(b))
    return spec, _add_joints(mujoco, spec, arm, motors, drive_damping)


def _set_options(mujoco: Any, spec: Any, gravity: Float64Array, period: float) -> None:
    spec.option.timestep = period
    spec.option.gravity = gravity
    # With this one, positions go on by the new velocities: their differences are the velocities.
    # Dampers act at the end of a step, so that strong ones on light joints are stable.
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    # A joint that runs away stays where it is, and is reported.
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
    spec.compiler.inertiafromgeom = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_FALSE
    spec.compiler.degree = False


def _add_links(mujoco: Any, spec: Any, arm: Arm, bodies: Mapping[str, Load]) -> None:
    """All links of the robot: those that the arm moves as bodies of a tree, others stand still."""
    robot = arm.robot
    still = link_poses(arm, arm._chain.middle[None])
    solids = convex_parts(arm.robot, arm.mesh_folders)
    driven = {joint.name for joint in robot.path(arm.base, arm.tip) if joint.kind != "fixed"}
    made: dict[int, Any] = {}
    incoming = {joint.child: joint for joint in robot.tree}
    for i in [0, *(joint.child for joint in robot.tree)]:
        joint, name = incoming.get(i), robot.links[i]
        if joint is not None and (joint.name in driven or joint.parent in made):
            parent = made.get(joint.parent, spec.worldbody)
            at = _at_rest(arm, joint, driven)
            if joint.parent not in made:  # the arm's first joint: on a link that stands still
                turned, placed = (part[0] for part in still[robot.links[joint.parent]])
                at = (placed + turned @ at[0], turned @ at[1])
            made[i] = body = parent.add_body(name=LINK + name, pos=at[0], quat=_quaternion(at[1]))
            set_inertia(body, name, bodies.get(name), joint.name in driven)
            if joint.name in driven:
                slides = joint.kind == "prismatic"
                kind = mujoco.mjtJoint.mjJNT_SLIDE if slides else mujoco.mjtJoint.mjJNT_HINGE
                body.add_joint(name=joint.name, type=kind, axis=joint.axis)
        else:
            turned, placed = (part[0] for part in still[name])
            body = spec.worldbody.add_body(name=LINK + name, pos=placed, quat=_quaternion(turned))
        add_parts(spec, body, solids.get(name, ()))
        if name == arm.tip and arm.attached:
            held = body.add_body(name=ATTACHED)
            for shape in arm.attached:
                add_parts(spec, held, shape.convex_parts())


def _at_rest(arm: Arm, joint: core.Joint, driven: set[str]) -> tuple[Float64Array, Float64Array]:
    """Position and rotation of a joint's child in its parent's frame, where the model begins."""
    if joint.name in driven or joint.kind == "fixed":
        return joint.position, joint.rotation
    poses = link_poses(arm, arm._chain.middle[None])
    links = arm.robot.links
    (turned, placed), (here, at) = (
        (part[0] for part in poses[links[i]]) for i in (joint.parent, joint.child)
    )
    return turned.T @ (at - placed), turned.T @ here


def set_inertia(body: Any, name: str, load: Load | None, driven: bool) -> None:
    """Gives a body the inertia of a load, or the least where it has to have one."""
    if load is None and not driven:
        return
    body.explicitinertial = True
    body.mass = _MIN_INERTIA if load is None else load.mass
    if load is None:
        body.inertia = np.full(3, _MIN_INERTIA)
        return
    moments = _balanced(load.inertia, name) + _MIN_INERTIA * np.eye(3)
    body.ipos = load.center
    body.fullinertia = [*np.diag(moments), moments[0, 1], moments[0, 2], moments[1, 2]]


def _balanced(inertia: Float64Array, link: str) -> Float64Array:
    """The nearest tensor of a rigid body: no principal moment exceeds the sum of the others."""
    moments, axes = np.linalg.eigh(inertia)
    lacking = (1.0 + _BALANCED) * moments[2] - moments[0] - moments[1]
    if moments[0] < 0.0 or lacking <= 2.0 * _BALANCED * moments[2]:
        return inertia
    sanity.warn(
        f"link {link}: no rigid body has the principal moments of inertia "
        f"{', '.join(f'{each:.3g}' for each in moments)} kg m^2, as the largest exceeds the sum of "
        "the others; simulated with the nearest that one has; correct the URDF"
    )
    nearest = moments + lacking / 3.0 * np.array([1.0, 1.0, -1.0])
    return np.asarray((axes * nearest) @ axes.T)


def add_parts(spec: Any, body: Any, parts: Iterable[ConvexPart]) -> None:
    mujoco = check.package("mujoco", extra="simulation")
    for part in parts:
        kind = getattr(mujoco.mjtGeom, f"mjGEOM_{part.kind.upper()}")
        geom = body.add_geom(type=kind, pos=part.position, quat=part.orientation)
        half = np.asarray(part.half_sizes)
        geom.size[: len(half)] = np.maximum(half - 0.5 * _TOUCHING, 0.5 * half)
        if part.vertices is not None:
            mesh = spec.add_mesh(name=f"mesh {len(spec.meshes)}")
            mesh.uservert = _shrunk(part.vertices).ravel()
            mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
            geom.meshname = mesh.name


def _shrunk(vertices: Float64Array) -> Float64Array:
    """Vertices (n, 3) of a hull whose extent in each direction is half of `_TOUCHING` smaller."""
    arms = vertices - 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    return np.asarray(vertices - 0.5 * _TOUCHING * np.sign(arms))


def _add_joints(
    mujoco: Any, spec: Any, arm: Arm, motors: Drives, drive_damping: Float64Array
) -> dict[str, tuple[int, float, float]]:
    """Limits, friction and motors of the joints; what drives each, by its name."""
    index = {name: i for i, name in enumerate(arm.joint_names)}
    drives = {}
    for joint in arm.robot.path(arm.base, arm.tip):
        if joint.kind == "fixed":
            continue
        made = spec.joint(joint.name)
        if joint.mimic is not None:
            rule = joint.mimic
            drives[joint.name] = (index[rule.joint], rule.multiplier, rule.offset)
            equal = spec.add_equality(
                type=mujoco.mjtEq.mjEQ_JOINT, name1=joint.name, name2=rule.joint
            )
            equal.data[:2] = rule.offset, rule.multiplier
            continue
        i = index[joint.name]
        drives[joint.name] = (i, 1.0, 0.0)
        motor = spec.add_actuator(name=joint.name, target=joint.name)
        motor.trntype = mujoco.mjtTrn.mjTRN_JOINT
        motor.biastype = mujoco.mjtBias.mjBIAS_AFFINE
        motor.biasprm[2] = -drive_damping[i]
        if np.isfinite(motors.effort[i]):
            motor.forcelimited = mujoco.mjtLimited.mjLIMITED_TRUE
            motor.forcerange = -motors.effort[i], motors.effort[i]
        made.frictionloss = motors.friction[i]
        made.damping[0] = motors.damping[i]
        made.armature = motors.rotors[i]
        low, high = arm.limits.lower[i], arm.limits.upper[i]
        if np.isfinite(low) and np.isfinite(high):
            made.limited = mujoco.mjtLimited.mjLIMITED_TRUE
            made.range = low, high
    return drives


def _body_name(name: str) -> str:
    return name if name == ATTACHED else LINK + name


def _unchecked_pairs(arm: Arm) -> Iterable[tuple[str, str]]:
    try:
        return arm.collision_pairs.left_out
    except InvalidRobot:
        return ()  # no geometry, so no contacts


def _quaternion(rotation: Float64Array) -> Float64Array:
    return np.asarray(rotations.from_matrix(rotation[None])[0])


def link_inertias(arm: Arm, *, payload: float) -> dict[str, Load]:
    """The rigid bodies, by the links that they are fixed to, that the arm's joints move."""
    stated = arm.robot.inertias
    found = {}
    for name in _moved_links(arm):
        bodies = [_load(*stated[name])]
        if name == arm.tip:
            loads = arm.attachment.loads
            bodies += [
                Load(payload * each.mass, each.center, payload * each.inertia) for each in loads
            ]
        found[name] = _sum(bodies)
    return {name: body for name, body in found.items() if body.mass > 0.0}


def _moved_links(arm: Arm) -> Iterable[str]:
    """The links that are fixed to what one of the arm's joints moves, by whatever branch."""
    robot = arm.robot
    moving = {joint.name for joint in robot.path(arm.base, arm.tip) if joint.kind != "fixed"}
    moved = set()
    for joint in robot.tree:  # parents stand before their children
        if joint.name in moving or (joint.kind == "fixed" and joint.parent in moved):
            moved.add(joint.child)
    return [robot.links[i] for i in sorted(moved)]


def _load(mass: float, center: Float64Array, inertia: Float64Array) -> Load:
    """A load that is not checked: identified tensors of a link need not be those of a body."""
    body = object.__new__(Load)
    vars(body).update(mass=mass, center=center, inertia=inertia)
    return body


def _sum(bodies: list[Load]) -> Load:
    mass = sum(body.mass for body in bodies)
    if mass == 0.0:
        return bodies[0]
    center = np.sum([body.mass * body.center for body in bodies], axis=0) / mass
    inertia = np.zeros((3, 3))
    for body in bodies:
        away = body.center - center
        inertia += body.inertia + body.mass * (away @ away * np.eye(3) - np.outer(away, away))
    return _load(mass, center, inertia)

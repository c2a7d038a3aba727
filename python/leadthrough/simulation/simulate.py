"""Simulation of a motion run by an arm under gravity, friction and a controller."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check, rotations
from leadthrough.arm import GRAVITY, Arm, check_arm
from leadthrough.arm.attachment import Load
from leadthrough.arm.limits import known_acceleration
from leadthrough.check import Float64Array, InvalidInput, LimitsInfeasible, NoPath
from leadthrough.guard.admission import CommandedState, chunk_of
from leadthrough.guard.connect import connect
from leadthrough.motion import Event, JointTrajectory, in_order, lerp
from leadthrough.shapes import SceneLike, as_scene
from leadthrough.simulation.controllers import Controller, Motion
from leadthrough.simulation.drives import Disturbances, RunawayError
from leadthrough.simulation.report import (
    Kind,
    Plan,
    Run,
    SimulationReport,
    findings,
    summed_contacts,
)
from leadthrough.simulation.simulated_arm import SimulatedArm

_SETTLING = 0.2  # s that the arm is held after the end
_AFTER_TOUCH = 0.1  # s after the first contact, by when real controllers have stopped
_ROUNDING = 1e-9  # of acceleration limits
_BEGUN = "begun"  # event that marks the given motion in one with ways onto it and off it


def simulate(
    arm: Arm,
    trajectory: JointTrajectory,
    scene: SceneLike = (),
    *,
    controller: Controller | None = None,
    state: CommandedState | ArrayLike | None = None,
    disturbances: Disturbances | None = None,
    gravity: ArrayLike = GRAVITY,
    tip_tolerance: float | None = None,
    rate: float = 1000.0,
) -> SimulationReport:
    """The motion of an arm under gravity, friction and a controller.

    The arm is made from its own URDF: masses, inertias, joint limits, friction, collision shapes,
    and motors with its highest torques. The controller knows the arm, and nothing of the
    disturbances. If the motion does not begin or end at rest, or the arm is elsewhere, ways onto
    it and to rest are added as by `lt.connect`; the arm is held for 0.2 s after the end. The
    simulation ends 0.1 s after a first contact, by when real controllers have stopped.
    Equal calls have equal answers.

    Args:
        arm: the arm; with acceleration and jerk limits if ways have to be added.
        trajectory: of the arm's joints, at any rate.
        scene: obstacles in the base frame, and the margin to them, which the tip's error must not
            exceed.
        controller: a `ComputedTorque`, which is the default, `PositionServo`, `JointImpedance` or
            `CartesianImpedance`.
        state: first one of the arm: positions (joints,) at rest, or a `CommandedState`; by
            default the first sample.
        disturbances: rotors, and the load, friction, delay, encoders and pushes that the controller
            does not know; by default those of a real arm. Errors by a load that is off by more
            than 5 % count as more than the gains allow.
        gravity: acceleration (3,) of gravity in the base frame, m/s^2.
        tip_tolerance: largest error of the tip, m, > 0, that is acceptable; by default any.
        rate: of the controller, Hz, 100 to 1e4.

    Returns:
        The motion as planned and as simulated, with torques, errors, contacts and a verdict.

    Raises:
        InvalidInput: if a payload is changed of an arm that carries none.
        InvalidRobot: if the URDF states no masses, or no bodies have its inertias.
        MissingDependency: if the extra `simulation` is not installed.
    """
    check_arm(arm)
    period = 1.0 / check.number(rate, "rate", at_least=100.0, at_most=1e4)
    around = as_scene(scene)
    tolerances: dict[Kind, float] = {"margin": around.margin} if around.shapes else {}
    if tip_tolerance is not None:
        tolerances["tip"] = check.number(tip_tolerance, "tip_tolerance", above=0.0)
    plan = _plan(arm, trajectory, state, period)
    real = SimulatedArm(
        arm,
        plan.start,
        around,
        controller=controller,
        disturbances=disturbances,
        gravity=gravity,
        rate=rate,
    )
    run = _run(real, plan)
    plan = plan.first(len(run.q))
    expected, smooth, dry = expected_errors(real, plan)
    allowed = allowed_errors(smooth, dry, encoder=real.drives.encoder)
    (at, turned), (there, done) = (arm.forward_kinematics(q) for q in (plan.q, run.q))
    tip_errors = np.linalg.norm(at - there, axis=1)
    contacts = summed_contacts(run.touches, period)
    times = period * np.arange(len(run.q))
    return SimulationReport(
        arm=arm,
        planned=JointTrajectory(times, plan.q, plan.qd, plan.qdd, arm.joint_names),
        simulated=JointTrajectory(times, run.q, run.qd, run.qdd, arm.joint_names),
        span=plan.span,
        torques=run.torques,
        torque_limits=real.drives.effort,
        expected=expected,
        allowed=allowed,
        tip_errors=tip_errors,
        tip_turns=rotations.distance(turned, done),
        contacts=contacts,
        energy=np.maximum(run.work, 0.0).sum(axis=0),
        work=run.work.sum(axis=0),
        findings=findings(
            real,
            run,
            plan,
            allowed=allowed,
            contacts=contacts,
            tip_errors=tip_errors,
            tolerances=tolerances,
        ),
        obstacles=around.shapes,
    )


def _plan(
    arm: Arm,
    trajectory: JointTrajectory,
    state: CommandedState | ArrayLike | None,
    period: float,
) -> Plan:
    own = in_order(trajectory, arm.joint_names, "trajectory")
    if len(own) < 2:
        raise InvalidInput("trajectory: expected at least two samples, got one")
    whole, offset, way_found = _connected(arm, own, state)
    rows = chunk_of(whole, arm, period).rows
    begins_at_rest = offset is not None or (_rates_known(arm) and _at_rest(arm, own, 0))
    first = np.zeros(rows.shape[1]) if begins_at_rest else (rows[1] - rows[0]) / period
    held = np.repeat(rows[-1:], round(_SETTLING / period), axis=0)
    q = np.concatenate([rows, held])
    qd = np.concatenate([first[None], np.diff(q, axis=0) / period])
    qdd = np.diff(qd, axis=0, append=qd[-1:]) / period
    shift = (offset or 0.0) - own.times[0]
    span = (float(own.times[0] + shift), float(own.times[-1] + shift))
    begun = state if isinstance(state, CommandedState) else None
    start = begun or CommandedState(q[0], first, np.zeros_like(first))
    return Plan(start, q, qd, qdd, _progress(arm, q, span, period), span, way_found)


def _connected(
    arm: Arm, own: JointTrajectory, state: CommandedState | ArrayLike | None
) -> tuple[JointTrajectory, float | None, bool]:
    """The motion with ways onto it and to rest, the length of the first, and whether they exist."""
    if state is None and (
        not _rates_known(arm) or (_at_rest(arm, own, 0) and _at_rest(arm, own, -1))
    ):
        return own, None, True
    marked = replace(own, events=(Event(float(own.times[0]), _BEGUN),))
    try:
        whole = connect(own.positions[0] if state is None else state, marked, arm)
    except (LimitsInfeasible, NoPath):
        return own, None, False
    return whole, whole.events[0].time, True


def _rates_known(arm: Arm) -> bool:
    return arm.limits.acceleration is not None and arm.limits.jerk is not None


def _at_rest(arm: Arm, motion: JointTrajectory, end: int) -> bool:
    """Whether one end of a motion is at rest: its first step is no longer than the limits allow."""
    a, b = (0, 1) if end == 0 else (-2, -1)
    step = motion.times[b] - motion.times[a]
    most = known_acceleration(arm.limits) * step**2 * (1.0 + _ROUNDING)
    return bool((np.abs(motion.positions[b] - motion.positions[a]) <= most).all())


def _progress(arm: Arm, q: Float64Array, span: tuple[float, float], period: float) -> Float64Array:
    """Fractions (n,) of the motion's path that the tip has gone, by length."""
    places, _ = arm.forward_kinematics(q)
    gone = np.concatenate([[0.0], np.linalg.norm(np.diff(places, axis=0), axis=1).cumsum()])
    first, last = np.interp(np.array(span) / period, np.arange(len(q)), gone)
    if last - first <= 0.0:
        return np.zeros(len(q))
    return np.asarray(np.clip((gone - first) / (last - first), 0.0, 1.0))


def _run(real: SimulatedArm, plan: Plan) -> Run:
    """All steps, or as many as the arm does not run away in."""
    count, joints = plan.q.shape
    rows = {name: np.zeros((count, joints)) for name in ("q", "qd", "qdd", "torques", "work")}
    rows["demanded"] = np.zeros((count, joints))
    touches, done, runaway = [], count, None
    q, dofs = real.q, real.plant.joints
    for k in range(count):
        after = min(k + 1, count - 1)
        command = check.computed(
            CommandedState, q=plan.q[after], qd=plan.qd[after], qdd=plan.qdd[k]
        )
        rows["q"][k], rows["qd"][k] = q, real.data.qvel[dofs]
        try:
            q = real.step(command, progress=plan.progress[k])
        except RunawayError as error:
            done, runaway = k + 1, error.joint
            break
        rows["qdd"][k] = (real.data.qvel[dofs] - rows["qd"][k]) / real.period
        rows["torques"][k], rows["demanded"][k] = real.torques, real.demanded
        rows["work"][k] = real.torques * (q - rows["q"][k])
        if real.data.ncon:
            touches.append((k, real.touches))
        if touches and k - touches[0][0] >= _AFTER_TOUCH / real.period:
            done = k + 1
            break
    kept = {name: row[:done] for name, row in rows.items()}
    return Run(**kept, touches=touches, runaway=runaway)


_EVERY = 10  # samples that share a mass matrix and gains
_PIECE = 1000 * _EVERY  # samples whose matrices are repeated at once
# The model is linear: products of errors are not in it, by which joints disturb each other too.
_SLACK, _COUPLED = 1.3, 0.1
_CURVED = 2.0  # 1/rad (1/m)
_MIN_ALLOWED = 2e-4  # rad (m)
_ENCODER_STEPS = 2.0  # that noise of the encoders may move a joint by
_MOVING = 1e-6  # rad/s (m/s): slower, dry friction is that of the last way
_DIVERGED = 1e3  # rad (m)
# Periods after a kick in which a loop shows whether it is stable, and growth that shows it is not.
_KICKED, _GROWTH = 500, 1.2


def expected_errors(
    real: SimulatedArm, plan: Plan
) -> tuple[Float64Array, Float64Array, Float64Array]:
    """Linear errors (n, joints) with and without dry friction, and its largest effect (joints,)."""
    law, drives, late = real.law, real.drives, real.drives.late
    q, qd = plan.q, plan.qd
    left = drives.damping * qd + _pushed(real, q) + _unknown_load(real, plan)
    torques = law.arm.inverse_dynamics(q, qd, plan.qdd, gravity=law.gravity)
    if real.steps > 1:
        left += _later(real, plan) - torques
    torques += drives.rotors * plan.qdd
    weight = law.arm.gravity_torques(q, gravity=law.gravity)
    coarse = slice(None, None, _EVERY)
    mass = law.mass(q[coarse])
    gains = law.gains(
        Motion(q[coarse], mass, torques[coarse], weight[coarse], plan.progress[coarse])
    )
    # Dampers in the joints and their drives act at once, and at the end of a step.
    dampers = drives.damping + law.drive_damping
    ease = np.asarray(np.linalg.inv(mass + real.period / real.steps * np.diag(dampers)))
    answer = np.concatenate([ease @ gains.stiffness, ease @ gains.damping], axis=2)
    left += _between(gains.unmodelled, len(q))
    pull = _products(ease, left)
    if late:
        before = np.maximum(np.arange(len(q)) - late, 0)
        moved = np.concatenate([q - q[before], qd - qd[before]], axis=1)
        pull -= _products(answer, moved)
    if (joint := _growing(answer, ease * dampers, real, len(q))) is not None:
        smooth = _diverged(joint, q)
        return smooth, smooth, np.zeros(q.shape[1])
    smooth = _integrated(answer, ease * dampers, pull, _jumps(real, plan.qdd), real)
    if not drives.friction.any():
        return smooth, smooth, np.zeros(q.shape[1])
    pull = _products(ease, drives.friction * _directions(qd))
    dry = _integrated(answer, ease * dampers, pull, np.zeros_like(q), real)
    # A joint may be held either way, and so deflect the others.
    held = np.abs(np.linalg.pinv(gains.stiffness)) @ drives.friction
    return smooth + dry, smooth, np.maximum(np.abs(dry).max(axis=0), held.max(axis=0))


def allowed_errors(
    smooth: Float64Array, dry: Float64Array, *, encoder: Float64Array
) -> Float64Array:
    """The largest error (joints,) that the gains allow."""
    most = np.abs(smooth).max(axis=0) + dry
    if not np.isfinite(most).all():
        return np.asarray(most)
    largest = float(most.max())
    second_order = (_COUPLED + _CURVED * largest) * largest
    return np.asarray(_SLACK * most + second_order + _MIN_ALLOWED + _ENCODER_STEPS * encoder)


def _later(real: SimulatedArm, plan: Plan) -> Float64Array:
    """Torques (n, joints) needed in the mean of each period, not at its beginning."""
    shift = real.period - real.period / real.steps
    qd = plan.qd + shift * plan.qdd
    q = plan.q + 0.5 * shift * qd
    return real.law.arm.inverse_dynamics(q, qd, plan.qdd, gravity=real.law.gravity)


def _jumps(real: SimulatedArm, qdd: Float64Array) -> Float64Array:
    """Changes (n, joints) of the planned velocity at samples, between which qdd is constant."""
    before = np.concatenate([np.zeros((1, qdd.shape[1])), qdd[:-1]])
    return np.asarray(0.5 * (real.period - real.period / real.steps) * (qdd - before))


def _integrated(
    answer: Float64Array,
    slowing: Float64Array,
    pull: Float64Array,
    jumps: Float64Array,
    real: SimulatedArm,
) -> Float64Array:
    """Errors (n, joints) by the physics' steps; the controller sees a period's mean velocity."""
    count, joints = pull.shape
    period, steps, late = real.period, real.steps, real.drives.late
    states, speed = np.zeros((count + 1, 2 * joints)), np.zeros(joints)
    for k in range(count):
        i, total, step = k // _EVERY, 0.0, period / steps
        held = pull[k] - answer[i] @ states[max(k - late, 0)]
        speed = speed + jumps[k]
        for _ in range(steps):
            speed = speed + step * (held - slowing[i] @ speed)
            total = total + speed
        now, mean = states[k + 1], total / steps
        now[joints:] = mean
        now[:joints] = states[k, :joints] + period * mean
        if k % _EVERY == 0 and not np.abs(now).max() < _DIVERGED:
            return _diverged(int(np.abs(now).argmax()) % joints, pull)
    return np.asarray(states[:count, :joints])


def _growing(
    answer: Float64Array, slowing: Float64Array, real: SimulatedArm, count: int
) -> int | None:
    """The joint that moves fastest at last if all were kicked and the errors grow from then on."""
    still = np.zeros((min(count, _KICKED), answer.shape[2] // 2))
    kick = still.copy()
    kick[:1] = 1.0
    moved = _integrated(answer, slowing, still, kick, real)
    if not np.isfinite(moved).all():
        return int(moved[-1].argmax())
    speeds = np.abs(np.diff(moved, axis=0))
    last = len(speeds) - len(speeds) // 4
    before, after = (part.max(initial=0.0) for part in np.split(speeds, [last]))
    return int(speeds[last:].max(axis=0).argmax()) if after > _GROWTH * before else None


def _diverged(joint: int, like: Float64Array) -> Float64Array:
    """Errors (n, joints) of a loop in which one joint is the first to run away."""
    return np.where(np.arange(like.shape[1]) == joint, np.inf, np.full(like.shape, _DIVERGED))


def _directions(qd: Float64Array) -> Float64Array:
    """Signs (n, joints) of the velocities; at rest those of the movement before."""
    signs = np.where(np.abs(qd) > _MOVING, np.sign(qd), 0.0)
    last = np.maximum.accumulate(np.where(signs != 0.0, np.arange(len(qd))[:, None], 0), axis=0)
    return np.asarray(np.take_along_axis(signs, last, axis=0))


def _pushed(real: SimulatedArm, q: Float64Array) -> Float64Array:
    """Torques (n, joints) against the pushes."""
    result = np.zeros_like(q)
    times = real.period * np.arange(len(q))
    for push in real.drives.pushes:
        during = (times >= push.time) & (times < push.time + push.duration)
        if during.any():
            jacobian = real.arm.jacobian(q[during])[:, :3]
            result[during] -= np.asarray(push.force) @ jacobian
    return result


def _unknown_load(real: SimulatedArm, plan: Plan) -> Float64Array:
    """Torques (n, joints) of the part of the load that nobody can be expected to know."""
    drives, arm = real.drives, real.arm
    known_to = drives.payload_known_to
    part = float(np.clip(drives.payload - 1.0, -known_to, known_to))
    if part == 0.0:
        return np.zeros_like(plan.q)
    more = [
        Load(abs(part) * each.mass, each.center, abs(part) * each.inertia)
        for each in arm.attachment.loads
    ]
    loads = (*arm.attachment.loads, *more)
    heavier = replace(arm, attachment=replace(arm.attachment, loads=loads))
    with_it, without = (
        each.inverse_dynamics(plan.q, plan.qd, plan.qdd, gravity=real.law.gravity)
        for each in (heavier, arm)
    )
    return np.asarray(np.copysign(1.0, part) * (with_it - without))


def _products(coarse: Float64Array, vectors: Float64Array) -> Float64Array:
    """Products (n, rows) of vectors with the matrix that they share with their neighbours."""
    pieces = []
    for first in range(0, len(vectors), _PIECE):
        part = vectors[first : first + _PIECE, :, None]
        matrices = coarse[first // _EVERY : (first + _PIECE) // _EVERY]
        pieces.append((np.repeat(matrices, _EVERY, axis=0)[: len(part)] @ part)[:, :, 0])
    return np.concatenate(pieces)


def _between(coarse: Float64Array, count: int) -> Float64Array:
    """Rows for all samples, from those of every tenth."""
    at, known = np.arange(count), np.arange(len(coarse)) * _EVERY
    return lerp(at, known, coarse)

"""Simulation of a motion run by an arm under gravity, friction and a controller."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check, rotations
from leadthrough.arm import Arm, check_arm
from leadthrough.arm.attachment import Load
from leadthrough.arm.limits import known_acceleration
from leadthrough.check import Float64Array, InvalidInput, LimitsInfeasible, NoPath
from leadthrough.guard.admission import CommandedState, chunk_of
from leadthrough.guard.connect import connect
from leadthrough.motion import Event, JointTrajectory, in_order, lerp
from leadthrough.shapes import SceneLike, as_scene
from leadthrough.simulation import report
from leadthrough.simulation.controllers import Controller, Motion
from leadthrough.simulation.drives import Disturbances
from leadthrough.simulation.report import Plan, Run, SimulationReport, findings
from leadthrough.simulation.simulated_arm import SimulatedArm, Touch

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
    gravity: ArrayLike | None = None,
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
        gravity: acceleration (3,) of gravity in the base frame, m/s^2; by default `arm.gravity`.
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
    tolerances: dict[report.Kind, float] = {"margin": around.margin} if around.shapes else {}
    if tip_tolerance is not None:
        tolerances["tip"] = check.number(tip_tolerance, "tip_tolerance", above=0.0)
    plan = _plan(arm, trajectory, state, period)
    del trajectory  # the plan of minutes takes as much again
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
    tip_errors, tip_turns = _tip_errors(arm, plan.q, run.q)
    contacts = report.summed_contacts(run.touches, period)
    times = period * np.arange(len(run.q))

    planned, simulated = (
        check.computed(
            JointTrajectory,
            times=times,
            positions=each.q,
            velocities=each.qd,
            accelerations=each.qdd,
            joint_names=arm.joint_names,
            events=(),
        )
        for each in (plan, run)
    )
    return SimulationReport(
        arm=arm,
        planned=planned,
        simulated=simulated,
        span=plan.span,
        torques=run.torques,
        torque_limits=real.drives.effort,
        expected=expected,
        allowed=allowed,
        tip_errors=tip_errors,
        tip_turns=tip_turns,
        contacts=contacts,
        energy=run.energy,
        work=run.work,
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


def _tip_errors(
    arm: Arm, planned: Float64Array, simulated: Float64Array
) -> tuple[Float64Array, Float64Array]:
    """Distances (n,) of the tip from where it should be, m, and angles, rad."""
    errors = []
    for first in range(0, len(planned), _PIECE):
        rows = slice(first, first + _PIECE)
        (at, turned), (there, done) = (
            arm.forward_kinematics(q[rows]) for q in (planned, simulated)
        )
        errors.append([np.linalg.norm(at - there, axis=1), rotations.distance(turned, done)])
    away, angles = np.concatenate(errors, axis=1)
    return away, angles


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
    touches = list[tuple[int, list[Touch]]]()
    *rows, work, energy, use, over, done, joint = real._run(
        (plan.q, plan.qd, plan.qdd, plan.progress),
        lambda k: touches.append((k, real.touches)),
        math.ceil(_AFTER_TOUCH / real.period),
    )
    q, qd, qdd, torques = (row[:done] for row in rows)
    return Run(q, qd, qdd, torques, work, energy, use, over, touches, joint if joint >= 0 else None)


_EVERY = 10  # samples that share a mass matrix and gains
_PIECE = 1000 * _EVERY  # samples whose matrices are kept at once
# The model is linear: products of errors are not in it, by which joints disturb each other too.
_SLACK, _COUPLED = 1.3, 0.1
_CURVED = 2.0  # 1/rad (1/m)
_MIN_ALLOWED = 2e-4  # rad (m)
_ENCODER_STEPS = 2.0  # that noise of the encoders may move a joint by
_DIVERGED = 1e3  # rad (m)
# Periods after a kick in which a loop shows whether it is stable, and growth that shows it is not.
_KICKED, _GROWTH = 500, 1.2


def expected_errors(
    real: SimulatedArm, plan: Plan
) -> tuple[Float64Array, Float64Array, Float64Array]:
    """Linear errors (n, joints), and the largest (joints,) without and by dry friction alone."""
    friction = real.drives.friction
    loop, held = _loop(real, np.zeros_like(friction)), np.zeros_like(friction)
    errors = np.empty_like(plan.q)
    for first in range(0, len(plan.q), _PIECE):
        ease, answer, left, stiffness = _response(real, plan, first)
        if first == 0 and (joint := _growing(ease, answer, real, len(plan.q))) is not None:
            return _diverged(joint, plan.q)
        moved = (each[first : first + _PIECE] for each in (plan.q, plan.qd, plan.qdd))
        errors[first : first + _PIECE] = loop.advance(ease, answer, left, *moved)
        if loop.diverged >= 0:
            return _diverged(loop.diverged, plan.q)
        if friction.any():  # a joint may be held either way, and so deflect the others
            most = (np.abs(np.linalg.pinv(stiffness, hermitian=True)) @ friction).max(axis=0)
            held = np.maximum(held, most)
    return errors, loop.smooth, np.maximum(loop.dry, held)


def allowed_errors(
    smooth: Float64Array, dry: Float64Array, *, encoder: Float64Array
) -> Float64Array:
    """The largest error (joints,) that the gains allow."""
    most = smooth + dry
    if not np.isfinite(most).all():
        return np.asarray(most)
    largest = float(most.max())
    second_order = (_COUPLED + _CURVED * largest) * largest
    return np.asarray(_SLACK * most + second_order + _MIN_ALLOWED + _ENCODER_STEPS * encoder)


def _loop(real: SimulatedArm, speed: Float64Array) -> core.ErrorLoop:
    """The errors' motion from a velocity (joints,) on."""
    drives = real.drives
    # Dampers in the joints and their drives act at once, and at the end of a step.
    dampers = drives.damping + real.law.drive_damping
    values = np.array([dampers, drives.friction, speed])
    return core.ErrorLoop(values, real.period, real.steps, drives.late, _EVERY)


def _response(
    real: SimulatedArm, plan: Plan, first: int
) -> tuple[Float64Array, Float64Array, Float64Array, Float64Array]:
    """Of a piece: inverse masses and their products with the gains, what is left, stiffness."""
    law, drives = real.law, real.drives
    # With the next piece's first sample, as what is left is interpolated.
    q, qd, qdd, progress = (
        each[first : first + _PIECE + 1 : _EVERY]
        for each in (plan.q, plan.qd, plan.qdd, plan.progress)
    )
    torques = law.arm.inverse_dynamics(q, qd, qdd, gravity=law.gravity) + drives.rotors * qdd
    mass, weight = law.mass(q), law.arm.gravity_torques(q, gravity=law.gravity)
    gains = law.gains(Motion(q, mass, torques, weight, progress))
    dampers = drives.damping + law.drive_damping
    ease = np.asarray(np.linalg.inv(mass + real.period / real.steps * np.diag(dampers)))
    answer = np.concatenate([ease @ gains.stiffness, ease @ gains.damping], axis=2)
    q, qd, qdd = (each[first : first + _PIECE] for each in (plan.q, plan.qd, plan.qdd))
    left = drives.damping * qd + _pushed(real, q, first) + _unknown_load(real, q, qd, qdd)
    left += lerp(np.arange(len(q)), _EVERY * np.arange(len(mass)), gains.unmodelled)
    if real.steps > 1:
        left += _later(real, q, qd, qdd)
    count = len(mass)
    return ease.reshape(count, -1), answer.reshape(count, -1), left, gains.stiffness


def _later(
    real: SimulatedArm, q: Float64Array, qd: Float64Array, qdd: Float64Array
) -> Float64Array:
    """Torques (n, joints) needed in the mean of each period, less those at its beginning."""
    shift, arm, pull = real.period - real.period / real.steps, real.arm, real.law.gravity
    after = qd + shift * qdd
    there = arm.inverse_dynamics(q + 0.5 * shift * after, after, qdd, gravity=pull)
    return np.asarray(there - arm.inverse_dynamics(q, qd, qdd, gravity=pull))


def _growing(
    ease: Float64Array, answer: Float64Array, real: SimulatedArm, count: int
) -> int | None:
    """The joint that moves fastest at last if all were kicked and the errors grow from then on."""
    still = np.zeros((min(count, _KICKED), len(real.drives.friction)))
    loop = _loop(real, np.ones(still.shape[1]))
    moved = loop.advance(ease, answer, *[still] * 4)
    if loop.diverged >= 0:
        return loop.diverged
    speeds = np.abs(np.diff(moved, axis=0))
    last = len(speeds) - len(speeds) // 4
    before, after = (part.max(initial=0.0) for part in np.split(speeds, [last]))
    return int(speeds[last:].max(axis=0).argmax()) if after > _GROWTH * before else None


def _diverged(joint: int, like: Float64Array) -> tuple[Float64Array, Float64Array, Float64Array]:
    """Errors of a loop in which one joint is the first to run away."""
    most = np.where(np.arange(like.shape[1]) == joint, np.inf, _DIVERGED)
    return np.tile(most, (len(like), 1)), most, np.zeros_like(most)


def _pushed(real: SimulatedArm, q: Float64Array, first: int) -> Float64Array:
    """Torques (n, joints) against the pushes, of samples from one on."""
    result = np.zeros_like(q)
    times = real.period * np.arange(first, first + len(q))
    for push in real.drives.pushes:
        during = (times >= push.time) & (times < push.time + push.duration)
        if during.any():
            jacobian = real.arm.jacobian(q[during])[:, :3]
            result[during] -= np.asarray(push.force) @ jacobian
    return result


def _unknown_load(
    real: SimulatedArm, q: Float64Array, qd: Float64Array, qdd: Float64Array
) -> Float64Array:
    """Torques (n, joints) of the part of the load that nobody can be expected to know."""
    drives, arm = real.drives, real.arm
    known_to = drives.payload_known_to
    part = float(np.clip(drives.payload - 1.0, -known_to, known_to))
    if part == 0.0:
        return np.zeros_like(q)
    more = [
        Load(abs(part) * each.mass, each.center, abs(part) * each.inertia)
        for each in arm.attachment.loads
    ]
    loads = (*arm.attachment.loads, *more)
    heavier = replace(arm, attachment=replace(arm.attachment, loads=loads))
    with_it, without = (
        each.inverse_dynamics(q, qd, qdd, gravity=real.law.gravity) for each in (heavier, arm)
    )
    return np.asarray(np.copysign(1.0, part) * (with_it - without))

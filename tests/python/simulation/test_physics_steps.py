"""Steps of the physics within a period: against exact solutions, and MuJoCo with finer steps."""

import mujoco
import numpy as np
import pytest
from motions import minimum_jerk
from simulation.conftest import HOME, IDEAL
from urdfs import one_joint

import leadthrough as lt
from leadthrough.guard import CommandedState
from leadthrough.simulation import (
    CartesianImpedance,
    ComputedTorque,
    JointImpedance,
    PositionServo,
    SimulatedArm,
    simulated_arm,
)
from leadthrough.simulation.controllers import Moment

RATE = 100.0  # Hz
AROUND_Z = (
    '<inertial><origin xyz="0.3 0 0"/><mass value="2"/>'
    '<inertia ixx="0.01" iyy="0.01" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial>'
)


def finer(monkeypatch):
    """Ten times the steps."""
    monkeypatch.setattr(simulated_arm, "MAX_CHANGE", 0.1 * simulated_arm.MAX_CHANGE)


def single(monkeypatch):
    """One step a period."""
    monkeypatch.setattr(simulated_arm, "MAX_CHANGE", np.inf)


def released(controller, periods=40):
    """Positions (periods,) of a joint that is let go 0.1 rad from where it is to be held."""
    arm = lt.Arm.from_urdf(one_joint("", link=AROUND_Z))
    real = SimulatedArm(arm, [0.1], controller=controller, disturbances=IDEAL, rate=RATE)
    target = CommandedState(np.zeros(1), np.zeros(1), np.zeros(1))
    real.step(target)  # its torque is by the first target, the start
    return np.array([real.step(target)[0] for _ in range(periods)])


def exact_servo(frequency, periods=40):
    """Positions under a spring that sees them once a period, and a damper that always does."""
    rate, period = 2.0 * frequency, 1.0 / RATE
    fade = np.exp(-rate * period)
    gone = (1.0 - fade) / rate
    q, qd, found = 0.1, 0.0, []
    for _ in range(periods):
        pull = -(frequency**2) * q
        q += gone * qd + (period - gone) / rate * pull
        qd = fade * qd + gone * pull
        found.append(q)
    return np.array(found)


def exact_computed(frequency, periods=40):
    """Positions under a torque held for a period, of position and mean velocity."""
    period = 1.0 / RATE
    q, qd, mean, found = 0.1, 0.0, 0.0, []
    for _ in range(periods):
        pull = -(frequency**2) * q - 2.0 * frequency * mean
        mean = qd + 0.5 * period * pull
        q, qd = q + period * mean, qd + period * pull
        found.append(q)
    return np.array(found)


@pytest.mark.parametrize(
    ("controller", "exact"),
    [(PositionServo(frequency=100.0), exact_servo), (ComputedTorque(30.0), exact_computed)],
)
def test_a_joint_moves_as_the_exact_solution_of_held_torques(controller, exact, monkeypatch):
    wanted = exact(controller.frequency)
    off = np.abs(released(controller) - wanted).max()
    finer(monkeypatch)
    assert np.abs(released(controller) - wanted).max() < 0.12 * off
    single(monkeypatch)
    assert off < 0.5 * np.abs(released(controller) - wanted).max()


@pytest.mark.parametrize("frequency", [10.0, 20.0, 35.0])
def test_the_step_errs_by_two_percent_of_a_joints_displacement(frequency):
    for made, exact in (
        (ComputedTorque(frequency), exact_computed(frequency)),
        (PositionServo(frequency=2.0 * frequency), exact_servo(2.0 * frequency)),
    ):
        assert np.abs(released(made) - exact).max() < 0.02 * 0.1


def swung():
    """Commands (n, joints) of a swing, a period apart, with rates as `simulate` plans them."""
    rise = minimum_jerk(np.linspace(0.0, 1.0, 101))
    q = HOME + np.outer(rise, np.full(7, 0.4))
    qd = np.diff(q, axis=0, prepend=q[:1]) * RATE
    return q, qd, np.diff(qd, axis=0, append=qd[-1:]) * RATE


def by_hand(law, model, joints, steps):
    """The swing by MuJoCo's own calls, with so many steps a period and exact measurements."""
    (q, qd, qdd), data = swung(), mujoco.MjData(model)
    model.opt.timestep = 1.0 / (RATE * steps)
    data.qpos[joints] = before = q[0]
    found = []
    for k in range(len(q) - 1):
        now = data.qpos[joints].copy()
        target = CommandedState(q[k], qd[k], qdd[k])
        asked = law.torques(Moment(target, now, (now - before) * RATE, 0.0))
        asked = asked + law.drive_damping * (now - before) * RATE
        before = now
        for i in range(steps):
            # From the middle of the last period, where the planned velocity is exact.
            ahead = (0.5 * (1.0 - 1.0 / steps) + (i + 1.0) / steps) / RATE
            data.ctrl[:] = asked + law.drive_damping * ahead * qdd[k]
            mujoco.mj_step(model, data)
        found.append(data.qpos[joints].copy())
    return np.array(found)


@pytest.mark.parametrize("controller", [ComputedTorque(), PositionServo()], ids=["torque", "servo"])
def test_a_swing_nears_the_one_of_much_finer_steps(controller, monkeypatch):
    arm = lt.Arm.load("panda")

    def simulated():
        q, qd, qdd = swung()
        start = CommandedState(q[0], qd[0], qdd[0])
        real = SimulatedArm(arm, start, controller=controller, disturbances=IDEAL, rate=RATE)
        rows = zip(q[1:], qd[1:], qdd[:-1], strict=True)
        return real, np.array([real.step(CommandedState(*row)) for row in rows])

    real, chosen = simulated()
    fine = by_hand(real.law, real.plant.model, real.plant.joints, 40 * real.steps)
    off = np.abs(chosen - fine).max()
    finer(monkeypatch)
    assert np.abs(simulated()[1] - fine).max() < 0.12 * off
    single(monkeypatch)
    assert off < 0.4 * np.abs(simulated()[1] - fine).max()


def test_default_gains_take_one_step_in_a_millisecond_and_more_in_ten():
    """At 1 kHz figures stay as they were: the planned velocities are those of the steps."""
    starts = {"panda": HOME, "ur3": np.array([0.0, -1.2, 1.4, -1.0, -1.5, 0.0])}
    for name, start in starts.items():
        arm = lt.Arm.load(name)
        for made in (ComputedTorque(), PositionServo(), JointImpedance(), CartesianImpedance()):
            assert SimulatedArm(arm, start, controller=made).steps == 1
        for made, steps in ((ComputedTorque(), {3}), (PositionServo(), {4, 5})):
            assert SimulatedArm(arm, start, controller=made, rate=RATE).steps in steps


def swing_motion():
    rise = minimum_jerk(np.linspace(0.0, 1.0, 101))
    return lt.JointTrajectory(np.linspace(0.0, 1.5, 101), HOME + np.outer(rise, np.full(7, 0.3)))


@pytest.mark.parametrize(("frequency", "rate"), [(40.0, 100.0), (100.0, 250.0)])
def test_gains_too_high_for_the_rate_are_the_only_finding(frequency, rate):
    """With one step a period these were fit to run: the delay between samples was not simulated."""
    report = lt.simulate(
        lt.Arm.load("panda"), swing_motion(), controller=ComputedTorque(frequency), rate=rate
    )
    assert [each.kind for each in report.findings] == ["unstable"]
    assert report.findings[0].joint in report.arm.joint_names


def test_an_exact_model_with_gains_too_high_is_unstable_too():
    """It was asked for 14 times its torque, as errors of zero do not grow by theory."""
    made = ComputedTorque(100.0)
    report = lt.simulate(
        lt.Arm.load("panda"), swing_motion(), controller=made, disturbances=IDEAL, rate=RATE
    )
    assert [each.kind for each in report.findings] == ["unstable"]


@pytest.mark.parametrize("controller", [ComputedTorque(12.0), ComputedTorque(30.0)])
def test_errors_by_torques_held_for_a_period_are_expected(controller):
    report = lt.simulate(
        lt.Arm.load("panda"), swing_motion(), controller=controller, disturbances=IDEAL, rate=RATE
    )
    assert report.ok, report
    most = np.abs(report.expected).max()
    assert most > 5e-5
    assert np.abs(report.errors - report.expected).max() < 0.1 * most
    assert (np.abs(report.torques) <= report.torque_limits).all()

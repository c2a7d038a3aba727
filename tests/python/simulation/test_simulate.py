"""Motions in simulation: their errors under each controller, and the report."""

import re
import sys
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from foreign_arms import urdf_in_package
from motions import minimum_jerk
from refusals import refused
from simulation.conftest import AWAY, HOME, IDEAL, disturbed
from urdfs import one_joint

import leadthrough as lt
from leadthrough.errors import InvalidInput, MissingDependency
from leadthrough.guard import CommandedState
from leadthrough.simulation import (
    CartesianImpedance,
    ComputedTorque,
    Disturbances,
    JointImpedance,
    PositionServo,
    Push,
)
from leadthrough.simulation.controllers import Moment


def kinds(report):
    return {each.kind for each in report.findings}


def test_a_motion_that_the_arm_can_run_is_fit_to_run(simulated, swing):
    assert simulated.ok
    assert str(simulated).startswith("fit to run")
    assert np.abs(simulated.errors).max() < 1e-9
    assert (simulated.torque_fractions < 1.0).all()
    first, last = simulated.span
    assert last - first == pytest.approx(swing.duration)
    assert simulated.plot().axes


def test_an_arm_of_some_tonnes_does_not_run_away():
    body = (
        '<inertial><origin xyz="1 0 0"/><mass value="3000"/>'
        '<inertia ixx="9" iyy="9" izz="9" ixy="0" ixz="0" iyz="0"/></inertial>'
    )
    arm = lt.Arm.from_urdf(one_joint('<origin rpy="1.5707963 0 0"/>', link=body))
    times = np.linspace(0.0, 2.0, 50)
    motion = lt.JointTrajectory(times, 0.2 * minimum_jerk(times / 2.0)[:, None])
    report = lt.simulate(arm, motion, disturbances=IDEAL)
    assert report.ok, report
    assert np.abs(report.torques).max() > 0.98 * 3000 * 9.81  # that of gravity, by hand


@pytest.mark.parametrize("torques", ["motor_torques", "inverse_dynamics"])
def test_joints_slowed_by_more_friction_than_torque_are_timed_as_they_move(torques):
    """The iCub's wrist has 1 N m s/rad and 0.45 N m."""
    path = urdf_in_package("example-robot-data", "icub.urdf")
    arm = lt.Arm.from_urdf(path, base="chest", tip="l_hand")
    fast = {"acceleration": np.full(7, 30.0), "jerk": np.full(7, 600.0)}
    limits = replace(arm.limits, velocity=np.full(7, 5.0), **fast)
    way = np.linspace(0.0, 1.0, 50)[:, None] * np.array([0.1, 0.1, 0.1, 0.1, 0.5, 0.3, 0.2])
    reserved = replace(limits, effort=0.9 * limits.effort)
    motion = lt.retime(arm._chain.middle + way, reserved, inverse_dynamics=getattr(arm, torques))
    report = lt.simulate(replace(arm, limits=limits), motion)
    assert report.ok == (torques == "motor_torques"), str(report)


def test_equal_calls_have_equal_answers(loaded, swing, simulated):
    again = lt.simulate(loaded, swing, disturbances=IDEAL)
    for name in ("torques", "expected", "tip_errors"):
        assert np.array_equal(getattr(again, name), getattr(simulated, name))
    assert np.array_equal(again.simulated.positions, simulated.simulated.positions)


@pytest.mark.parametrize(
    "controller",
    [PositionServo(), JointImpedance(), JointImpedance(300.0), CartesianImpedance(3000.0)],
    ids=lambda made: type(made).__name__,
)
@pytest.mark.parametrize("only", [{}, {"friction": 0.3, "damping": 0.2, "delay": 0.002}])
def test_the_error_is_that_of_the_linear_theory(loaded, swing, controller, only):
    gentle = lt.JointTrajectory(2.0 * swing.times[::4], swing.positions[::4])
    report = lt.simulate(loaded, gentle, controller=controller, disturbances=disturbed(**only))
    assert report.ok, str(report)
    expected = np.abs(report.expected).max()
    assert expected > 1e-3
    if only:  # a joint held by friction may rest anywhere within its band
        assert np.abs(report.errors).max() == pytest.approx(expected, rel=0.25)
    else:
        assert np.abs(report.errors - report.expected).max() < 0.25 * expected


@pytest.mark.parametrize(
    ("only", "least"),
    [
        ({"friction": 0.5}, 1e-3),
        ({"damping": 1.0}, 1e-3),
        ({"delay": 0.003}, 1e-3),
        ({"encoder": 1e-5}, 1e-6),
        ({"pushes": [Push(0.2, (0.0, 0.0, -20.0))]}, 1e-3),
    ],
    ids=["friction", "damping", "delay", "encoder", "push"],
)
def test_disturbances_that_are_stated_are_allowed_for(loaded, swing, only, least):
    report = lt.simulate(loaded, swing, disturbances=disturbed(**only))
    assert np.abs(report.errors).max() > least
    assert report.ok, str(report)


def pushed_where_it_stands(arm, controller, push):
    still = lt.JointTrajectory([0.0, 1.5], np.tile(HOME, (2, 1)))
    return lt.simulate(arm, still, controller=controller, disturbances=disturbed(pushes=[push]))


def test_a_held_arm_gives_way_to_a_push_by_its_compliance(loaded):
    force = np.array([3.0, 0.0, -2.0])
    report = pushed_where_it_stands(loaded, JointImpedance(400.0), Push(0.0, force, 5.0))
    way = loaded.jacobian(HOME)[:3].T @ force / 400.0
    assert np.abs(report.errors[-1] + way).max() < 0.02 * np.abs(way).max()


def test_the_tip_gives_way_by_its_stiffness(loaded):
    controller = CartesianImpedance(np.diag([500.0, 1000.0, 2000.0]))
    report = pushed_where_it_stands(loaded, controller, Push(0.0, (2.0, 3.0, -4.0), 9.0))
    here = loaded.forward_kinematics(report.simulated.positions[-1])[0]
    moved = here - loaded.forward_kinematics(HOME)[0]
    assert np.allclose(moved, [0.004, 0.003, -0.002], atol=1e-4)


def test_a_heavier_payload_is_found(loaded, swing):
    assert "tracking" in kinds(lt.simulate(loaded, swing, disturbances=Disturbances(payload=3.0)))


def test_too_little_torque_is_found(loaded, swing):
    values = vars(loaded.limits) | {"effort": 0.3 * loaded.limits.effort}
    weak = lt.Arm.load("panda", limits=lt.arm.JointLimits(**values))
    report = lt.simulate(weak, swing)
    assert {"torque", "tracking"} <= kinds(report)
    assert (np.abs(report.torques) <= values["effort"] * (1.0 + 1e-12)).all()


def test_speed_beyond_the_urdfs_limit_is_found(loaded, swing):
    fast = lt.JointTrajectory(0.5 * swing.times, swing.positions)
    assert "velocity" in kinds(lt.simulate(loaded, fast))


def test_limits_ten_times_too_high_are_found(loaded, swing):
    """Even where the motion is slow: a file in another unit is a fault of the plan."""
    rates = ("velocity", "acceleration", "jerk")
    high = {name: 10.0 * getattr(loaded.limits, name) for name in rates}
    arm = replace(loaded, limits=lt.arm.JointLimits(**vars(loaded.limits) | high))
    report = lt.simulate(arm, swing)
    assert kinds(report) == {"limits"}
    assert "is allowed 10 times the velocity that the URDF states" in str(report)


def test_obstacles_and_the_arm_itself_are_hit(loaded, swing):
    middle = loaded.forward_kinematics(0.5 * (HOME + AWAY))[0]
    report = lt.simulate(loaded, swing, [lt.Box((0.05, 0.05, 0.4), middle)])
    assert kinds(report) == {"contact"}
    assert report.contacts[0].bodies[1] == "obstacle 0"
    way = lt.trajectories.minimum_jerk_time_scaling(np.linspace(0.0, 1.0, 51))[:, None]
    bent = HOME + way * [1.0, 0.6, -0.4, 0.7, 0.3, -0.5, 1.0]
    hit = loaded.check(bent).first
    report = lt.simulate(loaded, lt.JointTrajectory(np.linspace(0.0, 1.0, 51), bent))
    assert hit is not None
    assert {each.bodies for each in report.contacts} == {hit.bodies}


def test_an_error_of_the_tip_beyond_the_tolerance_is_found(loaded, swing):
    report = lt.simulate(loaded, swing, controller=JointImpedance(), tip_tolerance=0.005)
    assert kinds(report) == {"tip"}


@pytest.mark.parametrize(
    "controller", [ComputedTorque(1e5), PositionServo(1e9), CartesianImpedance(1e8)]
)
def test_gains_too_high_for_the_rate_are_found(loaded, swing, controller, tmp_path, monkeypatch):
    """With motors of any strength as well; MuJoCo writes no log of it."""
    monkeypatch.chdir(tmp_path)
    strong = lt.Arm.from_urdf(re.sub('effort="[^"]*"', 'effort="0"', loaded.document))
    assert "unstable" in kinds(lt.simulate(strong, swing, controller=controller, rate=500.0))
    held_back = lt.simulate(loaded, swing, controller=controller, rate=500.0)
    assert kinds(held_back) & {"unstable", "torque"}
    assert not list(tmp_path.iterdir())


def test_the_arm_comes_from_where_it_is_and_ends_at_rest(loaded, swing):
    part = swing[100:300]
    report = lt.simulate(loaded, part, state=HOME - 0.05, disturbances=IDEAL)
    assert report.ok
    assert np.array_equal(report.planned.positions[0], HOME - 0.05)
    first, last = (round(1000.0 * each) for each in report.span)
    assert np.abs(report.planned.positions[first : last + 1] - part.positions).max() < 1e-9
    assert np.abs(report.planned.velocities[-1]).max() == 0.0
    cut = lt.simulate(loaded, part, disturbances=IDEAL)
    assert cut.ok and cut.span[0] > 0.0
    assert np.abs(cut.simulated.velocities[-1]).max() < 1e-6


def test_a_motion_that_no_way_leads_onto_is_found(loaded, swing):
    torn = np.array(swing.positions)
    torn[:, 0] += 2.5 * (torn[:, 0] > HOME[0] + 0.3)
    report = lt.simulate(loaded, lt.JointTrajectory(swing.times, torn)[290:330])
    assert not report.ok


def test_a_skills_tight_and_loose_phases_are_felt(loaded):
    """Demonstrations that agree at the end and not on the way: the tip is stiff at the end."""
    rng = np.random.default_rng(2)
    u = np.linspace(0.0, 1.0, 40)
    way = HOME + np.outer(lt.trajectories.minimum_jerk_time_scaling(u), AWAY - HOME)
    bulge = np.sin(np.pi * u)[:, None] ** 2
    shown = [
        lt.JointTrajectory(
            1.2 * u, way + bulge * rng.normal(0.0, 0.05, 7), joint_names=loaded.joint_names
        )
        for _ in range(5)
    ]
    skill = lt.ProMP(weights=10).fit([lt.Demonstration(each) for each in shown])
    made = CartesianImpedance.of_skill(skill, loaded, softest=200.0, stiffest=2000.0)
    stiffness = np.linalg.eigvalsh(np.asarray(made.stiffness))
    assert stiffness[50].max() < 0.5 * stiffness[-1].max()
    motion = lt.JointTrajectory(1.2 * u, way)
    quiet = lt.simulate(loaded, motion, controller=made).simulated.positions
    off = []
    for time in (0.5, 1.2):
        push = Push(time, (0.0, 0.0, 8.0), 0.15)
        moved = lt.simulate(
            loaded, motion, controller=made, disturbances=Disturbances(pushes=[push])
        ).simulated.positions
        there, here = (loaded.forward_kinematics(q)[0] for q in (moved, quiet))
        off.append(np.linalg.norm(there - here, axis=1).max())
    assert off[0] > 1.2 * off[1]


def test_wrong_arguments_are_named(loaded, swing):
    for wrong in (
        {"payload": -1.0},
        {"friction": [1.0, 2.0]},
        {"damping": -1.0},
        {"delay": 2.0},
        {"encoder": -1.0},
        {"rotor_inertia": -1.0},
        {"pushes": [1.0]},
    ):
        with pytest.raises(InvalidInput, match=f"^{next(iter(wrong))}"):
            lt.simulate(loaded, swing, disturbances=Disturbances(**wrong))
    for wrong in ({"rate": 10.0}, {"state": [0.0]}, {"tip_tolerance": 0.0}, {"gravity": [1.0]}):
        refused(next(iter(wrong)), lt.simulate, loaded, swing, **wrong)
    refused("obstacles", lt.simulate, loaded, swing, scene=[1.0])
    refused("stiffness", lt.simulate, loaded, swing, controller=PositionServo(-1.0))
    with pytest.raises(InvalidInput, match="payload: expected 1 for an arm that carries nothing"):
        lt.simulate(lt.Arm.load("panda"), swing, disturbances=Disturbances(payload=2.0))
    for wrong in [-1.0, [[1.0, 2.0], [3.0, 4.0]], -np.eye(3), np.triu(np.ones((3, 3)))]:
        refused("stiffness", CartesianImpedance, wrong)


def test_a_long_motion_takes_some_times_its_own_memory(loaded):
    """Mass matrices repeated for each sample took half of 45 times the memory of its positions."""
    times = 0.001 * np.arange(20_000)
    motion = lt.JointTrajectory(times, HOME + 0.1 * (1.0 - np.cos(0.5 * times))[:, None])
    tracemalloc.start()
    report = lt.simulate(loaded, motion)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert report.ok
    assert peak < 36 * 8 * 7 * len(times)


def test_without_mujoco_the_error_names_the_extra(loaded, swing, monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(MissingDependency, match=r"leadthrough\[simulation\]"):
        lt.simulate(loaded, swing)


def test_laws_of_the_core_are_their_formulas():
    arm, rng = lt.Arm.load("panda"), np.random.default_rng(1)
    rotors, pull = rng.uniform(0.1, 0.5, 7), np.array([0.0, 1.0, -9.81])
    q, qd, qdd, now, rate = HOME, *0.1 * rng.standard_normal((4, 7))
    moment = Moment(CommandedState(q, qd, qdd), HOME + now, rate, 0.0)
    away, slip = -now, qd - rate
    weight = arm.gravity_torques(HOME + now, gravity=pull)

    law = ComputedTorque(30.0).law(arm, HOME, gravity=pull, rotors=rotors)
    wanted = qdd + 60.0 * slip + 900.0 * away
    needed = arm.inverse_dynamics(HOME + now, rate, wanted, gravity=pull) + rotors * wanted
    light = law.drive_damping / 60.0
    assert law.torques(moment) == pytest.approx(needed + light * (900.0 * away + 60.0 * slip))
    for made, held in ((PositionServo(50.0), 0.0), (JointImpedance(50.0), weight)):
        law = made.law(arm, HOME, gravity=pull, rotors=rotors)
        expected = 50.0 * away + law.drive_damping * slip + held
        assert law.torques(moment) == pytest.approx(expected)


def test_a_law_asked_from_python_moves_the_arm_to_the_bit_as_one_of_the_core(loaded, swing):
    """With pushes the core asks Python each period; one without force changes nothing."""
    runs = [
        lt.simulate(loaded, swing, disturbances=Disturbances(pushes=pushes))
        for pushes in ((), [Push(0.1, (0.0, 0.0, 0.0))])
    ]
    assert np.array_equal(*(each.torques for each in runs))
    assert np.array_equal(*(each.simulated.positions for each in runs))
    assert np.array_equal(*(each.expected for each in runs))

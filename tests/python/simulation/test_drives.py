"""Drives of the simulated arm: a real arm's by default, from a table with sources."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from foreign_arms import urdf_in_package
from motions import minimum_jerk
from simulation.conftest import HOME, IDEAL, disturbed
from simulation.test_physics import MIMICKED

import leadthrough as lt
from leadthrough.simulation import (
    CartesianImpedance,
    Disturbances,
    JointImpedance,
    SimulatedArm,
)
from leadthrough.simulation.drives import drives_of

STARTS = {
    "panda": HOME,
    "ur3": np.array([0.0, -1.2, 1.4, -1.0, -1.5, 0.0]),
    "tiago": np.array([0.15, 1.0, 0.0, -1.0, 1.0, 0.3, 0.2, 0.0]),
}


def swing_of(arm, start):
    """From rest to rest by 0.3 rad and 5 cm, as fast as the limits allow."""
    away = np.where([name.startswith("torso") for name in arm.joint_names], 0.05, 0.3)
    return lt.retime(start + np.outer(minimum_jerk(np.linspace(0.0, 1.0, 101)), away), arm.limits)


def test_the_pandas_friction_is_that_of_gaz_et_al():
    """Supplementary material of the paper of 2019: Coulomb and viscous friction by joint."""
    made = drives_of(lt.Arm.load("panda"), Disturbances(), 0.001)
    assert made.friction.tolist() == [0.2450, 0.1523, 0.1827, 0.3591, 0.2669, 0.1658, 0.2109]
    assert made.damping.tolist() == [0.0665, 0.1987, 0.0399, 0.2257, 0.1023, 0.0, 0.0638]
    assert made.rotors == pytest.approx(0.0067 * np.array([87, 87, 87, 87, 12, 12, 12]))
    assert (made.payload, made.late) == (1.0, 1)  # it carries nothing
    assert made.encoder == pytest.approx(2.0 * np.pi / 2**17 / 100.0, rel=0.01)


def test_rotors_add_to_the_mass_matrix():
    arm = lt.Arm.load("ur3")
    real = SimulatedArm(arm, STARTS["ur3"])
    mass = np.zeros((6, 6))
    mujoco.mj_fullM(real.plant.model, real.data, mass)
    extra = mass - arm.mass_matrix(STARTS["ur3"])
    wanted = 0.0067 * np.diag([56.0, 56.0, 28.0, 12.0, 12.0, 12.0])
    assert np.abs(extra - wanted).max() < 1e-9


@pytest.mark.parametrize("name", STARTS)
def test_sound_motions_err_as_real_arms_do_and_are_fit_to_run(name):
    """By tenths of a millimetre, as the linear theory says, beside a wall that is 0.3 m away."""
    arm = lt.Arm.load(name).with_payload(0.5)
    motion = swing_of(arm, STARTS[name])
    tip, _ = arm.forward_kinematics(motion.positions)
    wall = lt.Box((0.05, 3.0, 3.0), (tip[:, 0].max() + 0.325, 0.0, 1.0))
    report = lt.simulate(arm, motion, [wall])
    assert report.ok, str(report)
    assert 1e-4 < report.tip_errors.max() < 5e-3
    expected = np.abs(report.expected).max()
    assert np.abs(report.errors).max() == pytest.approx(expected, rel=0.25)


def test_a_tip_that_errs_by_more_than_the_margin_is_not_fit_to_run(loaded, swing):
    tip, _ = loaded.forward_kinematics(swing.positions)
    wall = lt.Box((0.05, 3.0, 3.0), (tip[:, 0].max() + 0.4, 0.0, 1.0))
    soft = JointImpedance()
    error = lt.simulate(loaded, swing, controller=soft).tip_errors.max()
    for margin, kinds in ((0.9 * error, ["margin"]), (1.1 * error, [])):
        report = lt.simulate(loaded, swing, lt.Scene([wall], margin), controller=soft)
        assert [each.kind for each in report.findings] == kinds
    assert lt.simulate(loaded, swing, controller=soft).ok


def test_a_payload_is_known_to_five_percent_and_no_better(loaded, swing):
    quiet = replace(IDEAL, payload=None)
    light, heavy = (
        lt.simulate(loaded, swing, disturbances=replace(quiet, payload=factor))
        for factor in (1.05, 2.0)
    )
    assert light.ok and not heavy.ok
    assert np.abs(light.errors).max() > 1e-4
    default = lt.simulate(loaded, swing, disturbances=quiet)
    assert np.array_equal(default.simulated.positions, light.simulated.positions)


def test_torque_limits_hold_behind_the_gears(loaded, swing):
    """The torque that accelerates a rotor does not count against the maker's limit."""
    light = lt.simulate(loaded, swing, disturbances=IDEAL)
    heavy = lt.simulate(loaded, swing, disturbances=disturbed(rotor_inertia=20.0))
    assert heavy.ok, str(heavy)
    assert np.abs(heavy.torques - light.torques).max() < 1e-6


def test_friction_that_the_urdf_states_replaces_the_tables():
    arm = lt.Arm.from_urdf(MIMICKED.format(mimic=""))
    made = drives_of(arm, Disturbances(), 0.001)
    assert made.friction == pytest.approx([0.2, 0.013 * 50.0])
    assert made.damping == pytest.approx([0.3, 0.008 * 50.0])


@pytest.mark.parametrize("ideal", [True, False])
def test_an_arm_of_which_a_joint_turns_no_mass_is_simulated(ideal):
    """The PhantomX Pincher's last joint: rounding sent it to a torque of 90 times its limit."""
    arm = lt.Arm.from_urdf(urdf_in_package("rtb-data", "pincher_arm.urdf"), tip="gripper_link")
    rise = minimum_jerk(np.linspace(0.0, 1.0, 101))
    motion = lt.JointTrajectory(np.linspace(0.0, 3.0, 101), 0.3 + np.outer(rise, np.full(5, 0.2)))
    unknown = IDEAL if ideal else None
    report = lt.simulate(arm, motion, disturbances=unknown, rate=200.0)
    assert report.ok, str(report)
    assert report.torque_fractions.max() < 0.1


def test_an_arm_of_which_a_joint_turns_no_mass_is_unstable_under_a_stiff_tip():
    """Its mass matrix could not be inverted."""
    arm = lt.Arm.from_urdf(urdf_in_package("rtb-data", "pincher_arm.urdf"), tip="gripper_link")
    motion = lt.JointTrajectory([0.0, 1.0], np.full((2, 5), 0.3))
    report = lt.simulate(arm, motion, controller=CartesianImpedance(), disturbances=IDEAL)
    assert [each.kind for each in report.findings] == ["unstable"]


def test_an_unstable_arm_is_called_that_and_the_joint_named(loaded, swing):
    """A stiff spring of joint 6 alone, measured ten periods late."""
    springs = np.full(7, 500.0)
    springs[5] = 5e4
    late = disturbed(delay=0.01)
    report = lt.simulate(loaded, swing, controller=JointImpedance(springs), disturbances=late)
    assert [(each.kind, each.joint) for each in report.findings] == [("unstable", "panda_joint6")]
    assert "unstable: panda_joint6 runs away" in str(report)

import dataclasses

import numpy as np
import pytest
from refusals import refused

import leadthrough as lt

ARM = lt.Arm.load("ur3")
TIMES = np.linspace(0.0, 2.0, 50)
Q = np.array([0, -1.2, 1.4, -1.7, -1.5, 0.3]) + 0.2 * np.sin(TIMES)[:, None]
JOINTS = lt.JointTrajectory(TIMES, Q)
MOTION = lt.PoseTrajectory(TIMES, *ARM.forward_kinematics(Q))

OFFSET = 0.01 * np.eye(6)


def test_a_trajectory_on_its_own_poses_has_no_error():
    report = ARM.path_report(JOINTS, MOTION)
    assert report.position_error.max() < 1e-12
    assert report.orientation_error.max() < 1e-12
    np.testing.assert_allclose(report.condition_number, ARM.condition_number(Q))


def test_shares_are_those_of_positions_that_are_run_straight():
    report = ARM.path_report(JOINTS, MOTION)
    judged = lt.check_limits(JOINTS, ARM.limits, linear_rate=49.0 / 2.0)
    np.testing.assert_allclose(report.velocity_ratio.max(), judged.velocity.ratio)
    np.testing.assert_allclose(report.acceleration_ratio.max(), judged.acceleration.ratio)
    lower, upper = ARM.limits.lower[:5], ARM.limits.upper[:5]  # the last joint turns freely
    margin = np.minimum(Q[:, :5] - lower, upper - Q[:, :5]) / (upper - lower)
    np.testing.assert_allclose(report.margin, margin.min(axis=1))


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"positions": Q + OFFSET[0]}, "position error"),
        ({"positions": Q + OFFSET[5]}, "orientation error"),
        ({"times": TIMES / 100}, "velocity"),
        ({"positions": Q + 700 * OFFSET[0]}, "margin"),
    ],
)
def test_what_is_wrong_is_not_ok(change, text):
    report = ARM.path_report(dataclasses.replace(JOINTS, **change), MOTION)
    assert not report.ok
    assert text in report.summary()
    assert "not ok" in report.summary()


def test_a_slow_trajectory_is_ok():
    report = ARM.path_report(lt.JointTrajectory(10 * TIMES, Q), MOTION)
    assert report.ok
    assert report.summary().startswith("50 samples, ok")


def test_points_ask_for_no_orientation_and_unknown_accelerations_for_none():
    limits = dataclasses.replace(ARM.limits, acceleration=None)
    arm = lt.Arm(ARM.document, ARM.base, ARM.tip, limits)
    report = arm.path_report(JOINTS, lt.Trajectory(TIMES, MOTION.positions))
    assert report.acceleration_ratio is None
    assert (report.orientation_error == 0.0).all()
    assert "acceleration" not in report.summary()
    one = arm.path_report(
        lt.JointTrajectory([0.0], Q[:1]), lt.Trajectory([0.0], MOTION.positions[:1])
    )
    assert one.velocity_ratio.shape == (1,)
    assert one.ok


@pytest.mark.parametrize(
    ("joints", "motion", "options", "name"),
    [
        (None, MOTION, {}, "trajectory"),
        (Q, MOTION, {}, "trajectory"),
        (lt.JointTrajectory(TIMES[1:], Q[1:]), MOTION, {}, "trajectory"),
        (lt.JointTrajectory(TIMES, Q[:, 1:]), MOTION, {}, "trajectory"),
        (JOINTS, JOINTS, {}, "motion"),
        (JOINTS, MOTION, {"position_tolerance": 0.0}, "position_tolerance"),
    ],
)
def test_other_motions_and_tolerances_are_refused(joints, motion, options, name):
    refused(name, ARM.path_report, joints, motion, **options)

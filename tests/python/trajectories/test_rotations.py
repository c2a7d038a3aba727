"""Curves of rotations and of poses."""

import numpy as np
import pytest
from refusals import refused

from leadthrough import PoseTrajectory, rotations, trajectories as tr
from leadthrough.errors import InvalidInput

TIMES = np.array([0.0, 0.7, 1.5, 1.9, 3.0, 4.0])
Q = rotations.exp(np.cumsum(np.random.default_rng(0).normal(size=(6, 3)) * 0.5, axis=0))
START, END = np.array([0.1, 0.2, 0.3]), np.array([0.0, 0.5, 0.0])
CURVES = {
    "Slerp": lambda q: tr.Slerp(TIMES, q),
    "Squad": lambda q: tr.Squad(TIMES, q),
    "RotationBezier": lambda q: tr.RotationBezier(q, (0.0, 4.0)),
    "RotationSpline": lambda q: tr.RotationSpline(TIMES, q, START, END),
}


@pytest.fixture(params=CURVES)
def make(request):
    return CURVES[request.param]


def inner_times(curve):
    t = np.linspace(*curve.domain, 60)[1:-1]
    return t[np.abs(t[:, None] - curve.knots).min(axis=1) > 0.02]


def test_the_ends_are_met_and_quaternions_have_unit_length(make):
    curve = make(Q)
    q = curve.evaluate(np.linspace(0.0, 4.0, 100))
    np.testing.assert_allclose(np.linalg.norm(q, axis=1), 1.0, rtol=1e-12)
    assert (np.sum(q[1:] * q[:-1], axis=1) > 0.9).all()
    assert rotations.distance(curve.evaluate([0.0, 4.0]), Q[[0, -1]]).max() < 1e-7


def eighth_order(f, t, h):
    """The derivative of f at t, with an error of h^8."""
    weights = (4 / 5, -1 / 5, 4 / 105, -1 / 280)
    return sum(w * (f(t + k * h) - f(t - k * h)) for k, w in enumerate(weights, 1)) / h


def test_angular_rates_are_those_of_the_rotations(make):
    curve = make(Q)

    def matrix(t):
        return rotations.to_matrix(curve.evaluate(np.atleast_1d(t)))

    t = inner_times(curve)
    spin = eighth_order(matrix, t, 4e-3) @ matrix(t).transpose(0, 2, 1)
    velocities = np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], axis=1)
    np.testing.assert_allclose(curve.evaluate(t, 1), velocities, atol=1e-9)
    accelerations = eighth_order(lambda s: curve.evaluate(s, 1), t, 4e-3)
    np.testing.assert_allclose(curve.evaluate(t, 2), accelerations, atol=1e-8)


def test_turning_all_rotations_turns_the_curve(make):
    turn = np.tile(rotations.exp([[0.3, -1.0, 0.4]]), (6, 1))
    curve, t = make(Q), np.linspace(0.0, 4.0, 50)
    if isinstance(curve, tr.RotationSpline):
        rotate = rotations.to_matrix(turn[:1])[0]
        turned = tr.RotationSpline(TIMES, rotations.compose(turn, Q), rotate @ START, rotate @ END)
    else:
        turned = make(rotations.compose(turn, Q))
    expected = rotations.compose(np.tile(turn[:1], (50, 1)), curve.evaluate(t))
    assert rotations.distance(turned.evaluate(t), expected).max() < 1e-7


def test_the_spline_meets_its_samples_and_is_twice_continuous():
    spline = CURVES["RotationSpline"](Q)
    assert rotations.distance(spline.evaluate(TIMES), Q).max() < 1e-7
    np.testing.assert_allclose(spline.evaluate([0.0, 4.0], 1), [START, END], atol=1e-12)
    for order in (1, 2):
        before, after = (spline.evaluate(TIMES[1:-1] + h, order) for h in (-1e-9, 1e-9))
        np.testing.assert_allclose(before, after, atol=1e-7)


def test_about_one_axis_the_spline_is_the_cubic_one():
    angles = np.array([0.0, 0.5, 0.2, 1.0, 1.4, 0.9])
    spline = tr.RotationSpline(TIMES, rotations.exp(np.outer(angles, [0.0, 0.0, 1.0])))
    cubic = tr.clamped_cubic(TIMES, angles)
    t = np.linspace(0.0, 4.0, 80)
    np.testing.assert_allclose(spline.evaluate(t, 1)[:, 2], cubic.evaluate(t, 1)[:, 0], atol=1e-9)
    np.testing.assert_allclose(spline.evaluate(t, 2)[:, 2], cubic.evaluate(t, 2)[:, 0], atol=1e-7)


def test_two_samples_are_enough():
    assert tr.RotationSpline([0.0, 1.0], Q[:2]).evaluate(0.5).shape == (4,)


def test_slerp_keeps_the_axis_and_euler_angles_do_not():
    """The notes' example: a third of a turn about (1, 1, 1)."""
    end = rotations.from_matrix(np.array([[[0.0, 0, 1], [1, 0, 0], [0, 1, 0]]]))
    curve = tr.Slerp([0.0, 1.0], np.vstack([[1.0, 0, 0, 0], end[0]]))
    rates = curve.evaluate(np.linspace(0.0, 1.0, 11), 1)
    np.testing.assert_allclose(rates, np.full((11, 3), 2 * np.pi / 3 / 3**0.5), atol=1e-12)
    t = np.linspace(0.0, 1.0, 1001)
    by_angles = rotations.from_euler(np.outer(t, [np.pi / 2, 0.0, np.pi / 2]), convention="ZYX")
    turning = rotations.angular_velocity(t, by_angles)
    directions = turning / np.linalg.norm(turning, axis=1, keepdims=True)
    np.testing.assert_allclose(directions[0], np.array([1.0, 0.0, 1.0]) / 2**0.5, atol=1e-3)
    np.testing.assert_allclose(directions[-1], np.array([0.0, 1.0, 1.0]) / 2**0.5, atol=1e-3)


def test_poses_combine_positions_and_rotations():
    positions = tr.natural_cubic(TIMES, np.random.default_rng(2).normal(size=(6, 3)))
    pose = tr.PoseCurve(positions, CURVES["RotationSpline"](Q))
    t = np.linspace(0.0, 4.0, 9)
    motion = pose.sampled(t)
    assert isinstance(motion, PoseTrajectory)
    np.testing.assert_allclose(motion.positions, positions.evaluate(t))
    linear, angular = pose.evaluate(t, 1)
    assert linear.shape == angular.shape == (9, 3)


def test_wrong_rotations_and_times_are_refused(make):
    for wrong in (np.zeros((6, 4)), np.full((6, 4), np.nan), Q[:, :3], "q"):
        with pytest.raises(InvalidInput):
            make(wrong)
    curve = make(Q)
    for order in (3, -1):
        refused("derivative", curve.evaluate, 1.0, order)
    refused("t:", curve.evaluate, 5.0)
    for build in [tr.Slerp, tr.Squad, tr.RotationSpline]:
        for times in [[0, 1, 1, 2, 3, 4], [0, 2, 1, 3, 4, 5], [0, np.nan, 1, 2, 3, 4], []]:
            with pytest.raises(InvalidInput):
                build(times, Q)


def test_rotations_that_are_all_the_same_stand_still(make):
    curve, t = make(np.tile(Q[:1], (6, 1))), np.linspace(0.1, 3.9, 20)
    if isinstance(curve, tr.RotationSpline):
        curve = tr.RotationSpline(TIMES, np.tile(Q[:1], (6, 1)))
    assert rotations.distance(curve.evaluate(t), np.tile(Q[:1], (20, 1))).max() < 1e-7
    np.testing.assert_allclose(curve.evaluate(t, 1), 0.0, atol=1e-12)
    np.testing.assert_allclose(curve.evaluate(t, 2), 0.0, atol=1e-12)

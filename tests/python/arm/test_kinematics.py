"""Poses, Jacobians, their derivatives and measures of dexterity, against Pinocchio and formulas."""

import numpy as np
import pytest
from hypothesis import given, strategies as st
from motions import arm as robot_arm, configurations
from pinocchio_peer import Peer
from refusals import refused
from scipy.spatial.transform import Rotation
from urdfs import one_joint

import leadthrough as lt
from leadthrough.errors import InvalidInput

ANGLES = st.lists(st.floats(-3.0, 3.0), min_size=7, max_size=7)


def test_kinematics_agree_with_pinocchio(robot):
    _, arm, path, _ = robot
    peer = Peer(arm, path, {})
    rates = np.random.default_rng(0).uniform(-2.0, 2.0, (20, len(arm.joint_names)))
    for q, qd in zip(configurations(arm, 20, 1), rates, strict=True):
        truth = peer.pose(q)
        position, (w, x, y, z) = arm.forward_kinematics(q)
        np.testing.assert_allclose(position, truth.translation, atol=1e-12)
        np.testing.assert_allclose(
            Rotation.from_quat([x, y, z, w]).as_matrix(), truth.rotation, atol=1e-12
        )
        np.testing.assert_allclose(arm.jacobian(q), peer.jacobian(q), atol=1e-12)
        derivative = peer.jacobian_derivative(q, qd)
        np.testing.assert_allclose(arm.jacobian_derivative(q, qd), derivative, atol=1e-12)


@pytest.mark.parametrize(
    ("method", "arguments", "shape"),
    [
        ("jacobian", 1, (6, -1)),
        ("jacobian_derivative", 2, (6, -1)),
        ("jacobian_second_derivative", 3, (6, -1)),
        ("manipulability", 1, ()),
        ("condition_number", 1, ()),
    ],
)
def test_a_batch_is_its_rows_one_by_one(arm, method, arguments, shape):
    ask = getattr(arm, method)
    shape = tuple(len(arm.joint_names) if size < 0 else size for size in shape)
    motion = random_motion(arm, 3, rows=(4,))[:arguments]
    batch = ask(*motion)
    assert batch.shape == (4, *shape)
    for i in range(4):
        np.testing.assert_allclose(batch[i], ask(*motion[:, i]), rtol=1e-9 if not shape else 0.0)
    assert ask(*motion[:, :0]).shape == (0, *shape)


def test_poses_of_a_batch_are_those_of_its_rows_in_any_memory(arm):
    q = configurations(arm, 5, 2)
    positions, orientations = arm.forward_kinematics(q)
    assert positions.shape == (5, 3)
    assert orientations.shape == (5, 4)
    for i in range(5):
        for same in (q[i], list(q[i]), q[i].astype(np.longdouble), np.repeat(q[i], 2)[::2]):
            position, orientation = arm.forward_kinematics(same)
            np.testing.assert_array_equal(position, positions[i])
            np.testing.assert_array_equal(orientation, orientations[i])
            np.testing.assert_array_equal(arm.jacobian(same), arm.jacobian(q)[i])


def random_motion(arm, seed, rows=()):
    rng = np.random.default_rng(seed)
    return rng.uniform(-2.0, 2.0, (3, *rows, len(arm.joint_names)))


def slope(function, step):
    """Derivative at 0 by central differences of eighth order."""
    weights = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
    return sum(w * function(k * step) for w, k in zip(weights, range(-4, 5), strict=True)) / step


def test_the_second_derivative_is_that_of_a_motion_in_time(arm):
    q, qd, qdd = random_motion(arm, 1)

    def at(t):
        return q + t * qd + 0.5 * t**2 * qdd, qd + t * qdd

    np.testing.assert_allclose(
        arm.jacobian_second_derivative(q, qd, qdd),
        slope(lambda t: arm.jacobian_derivative(*at(t)), 1e-2),
        atol=1e-9,
    )


def test_manipulability_is_the_volume_of_the_velocities(arm, posture):
    jacobian = arm.jacobian(posture)
    volume = np.sqrt(np.linalg.det(jacobian @ jacobian.T))
    np.testing.assert_allclose(arm.manipulability(posture), volume, rtol=1e-9)


def test_the_condition_number_weighs_rotations(arm, posture):
    jacobian = arm.jacobian(posture)
    weighted = np.diag([1, 1, 1, 0.3, 0.3, 0.3]) @ jacobian
    np.testing.assert_allclose(arm.condition_number(posture), np.linalg.cond(weighted))
    np.testing.assert_allclose(
        arm.condition_number(posture, rotation_weight=1.0), np.linalg.cond(jacobian)
    )


@given(ANGLES)
def test_both_measures_hold_at_any_configuration(q):
    assert robot_arm("panda").manipulability(q) >= 0.0
    assert robot_arm("panda").condition_number(q) >= 1.0


def test_at_a_singularity_the_one_is_zero_and_the_other_infinite():
    ur3 = robot_arm("ur3")
    straight = [0.3, -1.0, 0.0, -0.4, 0.0, 0.2]  # elbow stretched, wrist aligned
    assert ur3.manipulability(straight) < 1e-15
    assert ur3.condition_number(straight) == np.inf


def test_an_arm_of_one_joint_is_as_well_conditioned_as_can_be():
    one = lt.Arm.from_urdf(one_joint())
    assert one.condition_number([0.2]) == 1.0
    assert one.manipulability([0.2]) == 1.0


MALFORMED = [np.zeros(3), "q", None, np.zeros((2, 2, 2)), [[1.0], [1.0, 2.0]]]


def test_wrong_configurations_and_rates_are_refused_by_name(arm, posture):
    for bad in [*MALFORMED, np.zeros((2, 3)), np.nan]:
        for ask in (arm.forward_kinematics, arm.jacobian, arm.condition_number, arm.manipulability):
            refused("q: ", ask, bad)
    for bad in MALFORMED:
        refused("qd", arm.jacobian_derivative, posture, bad)
        refused("qdd", arm.jacobian_second_derivative, posture, posture, bad)


def test_numbers_that_cannot_be_computed_with_are_refused(arm, posture):
    with pytest.raises(InvalidInput, match="finite"):
        arm.forward_kinematics(np.where(np.arange(len(posture)) == 2, np.nan, posture))
    with pytest.raises(InvalidInput, match="too large"):
        arm.jacobian_second_derivative(posture, 1e200 * np.ones_like(posture), posture)
    for weight in (0.0, -1.0, np.nan, np.inf, "heavy", None):
        with pytest.raises(InvalidInput):
            arm.condition_number(posture, rotation_weight=weight)

import numpy as np
import pinocchio as pin
import pytest

from leadthrough.errors import InvalidInput


def random_motion(arm, seed, rows=()):
    rng = np.random.default_rng(seed)
    return rng.uniform(-2.0, 2.0, (3, *rows, len(arm.joint_names)))


def pinocchio_derivative(arm, path, q, qd):
    """The Jacobian's derivative in time, by Pinocchio; the robots' bases are not turned."""
    model = pin.buildModelFromUrdf(str(path))
    data = model.createData()
    full, speed, columns = pin.neutral(model), np.zeros(model.nv), []
    for name, value, velocity in zip(arm.joint_names, q, qd, strict=True):
        joint = model.joints[model.getJointId(name)]
        columns.append(joint.idx_v)
        speed[joint.idx_v] = velocity
        full[joint.idx_q : joint.idx_q + joint.nq] = (
            value if joint.nq == 1 else (np.cos(value), np.sin(value))
        )
    pin.computeJointJacobiansTimeVariation(model, data, full, speed)
    pin.updateFramePlacements(model, data)
    tip = model.getFrameId(arm.tip)
    derivative = pin.getFrameJacobianTimeVariation(model, data, tip, pin.LOCAL_WORLD_ALIGNED)
    return derivative[:, columns]


def slope(function, step):
    """Derivative at 0 by central differences of eighth order."""
    weights = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
    return sum(w * function(k * step) for w, k in zip(weights, range(-4, 5), strict=True)) / step


def test_the_derivative_agrees_with_pinocchio(robot):
    _, arm, path, _ = robot
    for seed in range(20):
        q, qd, _ = random_motion(arm, seed)
        expected = pinocchio_derivative(arm, path, q, qd)
        np.testing.assert_allclose(arm.jacobian_derivative(q, qd), expected, atol=1e-12)


def test_the_derivatives_are_those_of_a_motion_in_time(arm):
    q, qd, qdd = random_motion(arm, 1)

    def at(t):
        return q + t * qd + 0.5 * t**2 * qdd, qd + t * qdd

    np.testing.assert_allclose(
        arm.jacobian_derivative(q, qd), slope(lambda t: arm.jacobian(at(t)[0]), 1e-2), atol=1e-9
    )
    np.testing.assert_allclose(
        arm.jacobian_second_derivative(q, qd, qdd),
        slope(lambda t: arm.jacobian_derivative(*at(t)), 1e-2),
        atol=1e-9,
    )


def test_they_give_the_acceleration_and_the_jerk_of_the_tip(arm):
    q, qd, qdd = random_motion(arm, 2)

    def velocity(t):
        return arm.jacobian(q + t * qd + 0.5 * t**2 * qdd) @ (qd + t * qdd)

    def acceleration(t):
        now = q + t * qd + 0.5 * t**2 * qdd
        derivative = arm.jacobian_derivative(now, qd + t * qdd)
        return arm.jacobian(now) @ qdd + derivative @ (qd + t * qdd)

    np.testing.assert_allclose(acceleration(0.0), slope(velocity, 1e-2), atol=1e-9)
    jerk = (
        2 * arm.jacobian_derivative(q, qd) @ qdd + arm.jacobian_second_derivative(q, qd, qdd) @ qd
    )
    np.testing.assert_allclose(jerk, slope(acceleration, 1e-2), atol=1e-8)


def test_a_batch_of_matrices_is_its_rows_one_by_one(arm):
    q, qd, qdd = random_motion(arm, 3, rows=(4,))
    batches = (
        arm.jacobian(q),
        arm.jacobian_derivative(q, qd),
        arm.jacobian_second_derivative(q, qd, qdd),
    )
    for i in range(4):
        rows = (
            arm.jacobian(q[i]),
            arm.jacobian_derivative(q[i], qd[i]),
            arm.jacobian_second_derivative(q[i], qd[i], qdd[i]),
        )
        for batch, row in zip(batches, rows, strict=True):
            assert batch.shape == (4, 6, len(arm.joint_names))
            np.testing.assert_array_equal(batch[i], row)


def test_no_rows_give_no_matrices(arm):
    none = np.empty((0, len(arm.joint_names)))
    assert arm.jacobian_derivative(none, none).shape == (0, 6, len(arm.joint_names))


@pytest.mark.parametrize("bad", [np.zeros(3), "q", None, np.zeros((2, 2, 2)), [[1.0], [1.0, 2.0]]])
def test_rates_that_do_not_fit_are_refused_by_name(arm, posture, bad):
    with pytest.raises(InvalidInput, match="qd"):
        arm.jacobian_derivative(posture, bad)
    with pytest.raises(InvalidInput, match="qdd"):
        arm.jacobian_second_derivative(posture, posture, bad)
    with pytest.raises(InvalidInput, match="q: "):
        arm.jacobian(bad)


def test_rates_too_large_to_compute_with_are_refused(arm, posture):
    with pytest.raises(InvalidInput, match="too large"):
        arm.jacobian_second_derivative(posture, 1e200 * np.ones_like(posture), posture)

import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation

import leadthrough as lt
from leadthrough.errors import InvalidInput


def pinocchio_tip(arm, path, q):
    """Pose and Jacobian of the tip in the base's frame, by Pinocchio."""
    model = pin.buildModelFromUrdf(str(path))
    data = model.createData()
    full = pin.neutral(model)
    columns = []
    for name, value in zip(arm.joint_names, q, strict=True):
        joint = model.joints[model.getJointId(name)]
        columns.append(joint.idx_v)
        if joint.nq == 2:
            full[joint.idx_q : joint.idx_q + 2] = np.cos(value), np.sin(value)
        else:
            full[joint.idx_q] = value
    pin.computeJointJacobians(model, data, full)
    pin.updateFramePlacements(model, data)
    tip, base = model.getFrameId(arm.tip), model.getFrameId(arm.base)
    T_base_tip = data.oMf[base].actInv(data.oMf[tip])
    world = pin.getFrameJacobian(model, data, tip, pin.LOCAL_WORLD_ALIGNED)[:, columns]
    turn = np.kron(np.eye(2), data.oMf[base].rotation.T)
    return T_base_tip, turn @ world


def test_kinematics_agree_with_pinocchio(robot, random_configurations):
    _, arm, path, _ = robot
    for q in random_configurations(arm, 20, 1):
        truth, jacobian = pinocchio_tip(arm, path, q)
        position, (w, x, y, z) = arm.forward_kinematics(q)
        np.testing.assert_allclose(position, truth.translation, atol=1e-12)
        np.testing.assert_allclose(
            Rotation.from_quat([x, y, z, w]).as_matrix(), truth.rotation, atol=1e-12
        )
        np.testing.assert_allclose(arm.jacobian(q), jacobian, atol=1e-12)


def test_a_batch_is_its_rows_one_by_one(arm, random_configurations):
    q = random_configurations(arm, 5, 2)
    positions, orientations = arm.forward_kinematics(q)
    assert positions.shape == (5, 3)
    assert orientations.shape == (5, 4)
    for i in range(5):
        position, orientation = arm.forward_kinematics(q[i])
        np.testing.assert_array_equal(position, positions[i])
        np.testing.assert_array_equal(orientation, orientations[i])
        jacobian = arm.jacobian(q)[i]
        for same in (q[i], list(q[i]), q[i].astype(np.longdouble), np.repeat(q[i], 2)[::2]):
            np.testing.assert_array_equal(arm.jacobian(same), jacobian)
            np.testing.assert_array_equal(arm.forward_kinematics(same)[0], positions[i])


def test_the_jacobian_is_the_derivative_of_the_pose(arm, posture):
    step = 1e-6
    jacobian = arm.jacobian(posture)
    for i in range(len(posture)):
        ends = posture + np.outer([-step, step], np.eye(len(posture))[i])
        positions, orientations = arm.forward_kinematics(ends)
        turn = lt.rotations.compose(
            orientations[1:], orientations[:1] * np.array([1.0, -1, -1, -1])
        )
        np.testing.assert_allclose(
            jacobian[:3, i], (positions[1] - positions[0]) / (2 * step), atol=1e-8
        )
        np.testing.assert_allclose(
            jacobian[3:, i], lt.rotations.log(turn)[0] / (2 * step), atol=1e-8
        )


@pytest.mark.parametrize("bad", [np.zeros(3), np.zeros((2, 3)), "q", None, np.zeros((2, 2, 2))])
def test_a_wrong_configuration_is_refused(arm, bad):
    with pytest.raises(InvalidInput):
        arm.forward_kinematics(bad)
    with pytest.raises(InvalidInput):
        arm.jacobian(bad)


def test_nan_is_refused(arm, posture):
    posture[2] = np.nan
    with pytest.raises(InvalidInput, match="finite"):
        arm.forward_kinematics(posture)

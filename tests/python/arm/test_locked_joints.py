import numpy as np
import pytest
from motions import configurations
from refusals import refused
from urdfs import one_joint

import leadthrough as lt
from leadthrough.errors import InvalidRobot


@pytest.fixture
def tiago():
    return lt.Arm.load("tiago")


def test_a_held_joint_leaves_the_arm_and_its_limits(tiago):
    locked = tiago.lock_joints({"torso_lift_joint": 0.2})
    assert locked.joint_names == tiago.joint_names[1:]
    assert locked.locked_joints == {"torso_lift_joint": 0.2}
    for name in ("lower", "upper", "velocity", "acceleration", "jerk", "effort"):
        np.testing.assert_array_equal(getattr(locked.limits, name), getattr(tiago.limits, name)[1:])


def test_kinematics_and_dynamics_are_those_of_the_whole_arm(arm):
    """With two joints locked: one in the middle, one at the end."""
    kept = [i for i in range(len(arm.joint_names)) if i not in (2, 5)]
    for q in configurations(arm, 5, 1):
        locked = arm.lock_joints({arm.joint_names[2]: q[2]}).lock_joints({arm.joint_names[5]: q[5]})
        for ours, truth in zip(
            locked.forward_kinematics(q[kept]), arm.forward_kinematics(q), strict=True
        ):
            np.testing.assert_allclose(ours, truth * np.sign(ours @ truth), atol=1e-13)
        np.testing.assert_allclose(locked.jacobian(q[kept]), arm.jacobian(q)[:, kept], atol=1e-13)
        np.testing.assert_allclose(
            locked.gravity_torques(q[kept]), arm.gravity_torques(q)[kept], atol=1e-11
        )
        np.testing.assert_allclose(
            locked.mass_matrix(q[kept]), arm.mass_matrix(q)[np.ix_(kept, kept)], atol=1e-12
        )


def test_joints_are_held_from_the_start_or_later(robot):
    _, arm, path, posture = robot
    name, value = arm.joint_names[3], posture[3]
    first = lt.Arm.from_urdf(path, base=arm.base, tip=arm.tip, locked_joints={name: value})
    later = arm.lock_joints({name: value})
    assert first.joint_names == later.joint_names
    q = np.delete(posture, 3)
    np.testing.assert_array_equal(first.jacobian(q), later.jacobian(q))


def test_inverse_kinematics_uses_the_joints_that_are_left(tiago):
    locked = tiago.lock_joints({"torso_lift_joint": 0.2})
    q = locked.limits.lower + 0.4 * (locked.limits.upper - locked.limits.lower)
    position, orientation = locked.forward_kinematics(q)
    result = locked.inverse_kinematics(position, orientation)
    assert result.success
    np.testing.assert_allclose(tiago.forward_kinematics([0.2, *result.q])[0], position, atol=2e-6)


def test_locked_joints_are_not_the_callers_dictionary(tiago):
    values = {"torso_lift_joint": 0.2}
    locked = tiago.lock_joints(values)
    values["torso_lift_joint"] = 9.0
    assert locked.locked_joints["torso_lift_joint"] == 0.2
    with pytest.raises(TypeError):
        locked.locked_joints["torso_lift_joint"] = 9.0


def test_joints_that_cannot_be_locked_are_refused(tiago):
    for values, message in [
        ({"torso_lift_joint": 0.4}, "torso_lift_joint: expected a value inside its limits 0 to"),
        ({"torso_lift_joint": -1e-3}, "torso_lift_joint"),
        ({"torso_lift_joint": np.nan}, "torso_lift_joint"),
        ({"torso_lift_joint": "up"}, "torso_lift_joint"),
        ({"knee": 0.1}, "'knee': does not exist"),
        ({3: 0.1}, "joint's name"),
        ([("torso_lift_joint", 0.1)], "names"),
        (None, "names"),
    ]:
        refused(message, tiago.lock_joints, values)
    torso = {"torso_lift_joint": 0.1}
    refused("at least one", tiago.lock_joints, dict.fromkeys(tiago.joint_names, 0.1))
    refused(r"locked at 0\.1", tiago.lock_joints(torso).lock_joints, {"torso_lift_joint": 0.2})
    refused("limits", lt.Arm, tiago.document, tiago.base, tiago.tip, tiago.limits, torso)
    with pytest.raises(InvalidRobot, match="no joint moves"):
        lt.Arm.from_urdf(one_joint(), locked_joints={"j": 0.1})
    refused("j", lt.Arm.from_urdf, one_joint(), locked_joints={"j": np.inf})

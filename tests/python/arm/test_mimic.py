"""Arms some of whose joints mimic others, against Pinocchio's model of all joints by themselves."""

import numpy as np
import pinocchio as pin
import pytest
from urdfs import two_wheels

import leadthrough as lt
from leadthrough.errors import InvalidInput, InvalidRobot

# joint: type, origin, axis, the rest. "lead" drives "curl", which comes after it, and "rail",
# which comes before it and slides.
JOINTS = {
    "turn": ("continuous", "0 0 0.3", "0 0 1", ""),
    "rail": (
        "prismatic",
        "0.1 0 0.1",
        "0 1 0",
        '<limit lower="-0.2" upper="0.3" velocity="0.5" effort="9"/>'
        '<mimic joint="lead" multiplier="-0.25" offset="0.05"/>',
    ),
    "lift": ("revolute", "0 0.1 0.2", "0 1 0", "{limit}"),
    "lead": ("revolute", "0.3 0 0", "0 1 1", "{limit}"),
    "curl": ("revolute", "0.2 0 0.1", "1 0 0", '{limit}<mimic joint="lead" multiplier="1.5"/>'),
    "wrist": ("revolute", "0.1 0.1 0", "0 0 -1", "{limit}"),
}
FREE = ("turn", "lift", "lead", "wrist")
LIMIT = '<limit lower="-1.5" upper="1.2" velocity="2" effort="50"/>'
# Values of all joints from those of the free ones: SPREAD q + OFFSET.
SPREAD = np.array(
    [[1, 0, 0, 0], [0, 0, -0.25, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 1.5, 0], [0, 0, 0, 1]]
)
OFFSET = np.array([0, 0.05, 0, 0, 0, 0])
Q = np.random.default_rng(1).uniform(-0.7, 0.7, (20, 3, 4))


def document(**changes):
    text = '<robot name="linked"><link name="link0"/>'
    for i, (name, (kind, origin, axis, rest)) in enumerate((JOINTS | changes).items()):
        text += (
            f'<link name="link{i + 1}"><inertial><origin xyz="0.1 0.05 0.02" rpy="0.1 0.2 0.3"/>'
            f'<mass value="{1 + i}"/><inertia ixx="0.02" ixy="0.001" ixz="0" iyy="0.03" iyz="0" '
            'izz="0.04"/></inertial></link>'
            f'<joint name="{name}" type="{kind}"><parent link="link{i}"/>'
            f'<child link="link{i + 1}"/><origin xyz="{origin}" rpy="0.3 0.1 0.2"/>'
            f'<axis xyz="{axis}"/>{rest.format(limit=LIMIT)}</joint>'
        )
    return text + "</robot>"


@pytest.fixture
def arm():
    return lt.Arm.from_urdf(document())


@pytest.fixture
def model():
    return pin.buildModelFromXML(document())


def whole(model, values):
    place = pin.neutral(model)
    place[:2] = np.cos(values[0]), np.sin(values[0])  # the joint without limits comes first
    place[2:] = values[1:]
    return place


def test_only_joints_that_mimic_none_are_commanded(arm):
    assert arm.joint_names == FREE


def test_limits_of_joints_that_mimic_narrow_those_of_their_leader(arm):
    i = FREE.index("lead")
    np.testing.assert_allclose(arm.limits.lower[i], -1.0)  # curl's -1.5 and rail's 0.3
    np.testing.assert_allclose(arm.limits.upper[i], 0.8)  # curl's 1.2
    np.testing.assert_allclose(arm.limits.velocity[i], 2 / 1.5)


def test_kinematics_agree_with_pinocchio(arm, model):
    data = model.createData()
    tip = model.getFrameId("link6")
    for q, qd, _ in Q:
        place = whole(model, SPREAD @ q + OFFSET)
        pin.computeJointJacobiansTimeVariation(model, data, place, SPREAD @ qd)
        pin.updateFramePlacements(model, data)
        jacobian = pin.getFrameJacobian(model, data, tip, pin.LOCAL_WORLD_ALIGNED)
        derivative = pin.getFrameJacobianTimeVariation(model, data, tip, pin.LOCAL_WORLD_ALIGNED)
        position, _ = arm.forward_kinematics(q)
        np.testing.assert_allclose(position, data.oMf[tip].translation, atol=1e-13)
        np.testing.assert_allclose(arm.jacobian(q), jacobian @ SPREAD, atol=1e-13)
        np.testing.assert_allclose(arm.jacobian_derivative(q, qd), derivative @ SPREAD, atol=1e-13)


def test_the_second_derivative_is_that_of_a_motion(arm):
    q, qd, qdd = Q[0]
    step = 1e-4

    def derivative(t):
        return arm.jacobian_derivative(q + t * qd + 0.5 * t**2 * qdd, qd + t * qdd)

    np.testing.assert_allclose(
        arm.jacobian_second_derivative(q, qd, qdd),
        (derivative(step) - derivative(-step)) / (2 * step),
        atol=1e-7,
    )


def test_dynamics_agree_with_pinocchio(arm, model):
    data = model.createData()
    for q, qd, qdd in Q:
        place = whole(model, SPREAD @ q + OFFSET)
        torques = pin.rnea(model, data, place, SPREAD @ qd, SPREAD @ qdd)
        np.testing.assert_allclose(arm.inverse_dynamics(q, qd, qdd), SPREAD.T @ torques, atol=1e-11)
        upper = np.triu(pin.crba(model, data, place))
        mass = upper + np.triu(upper, 1).T
        np.testing.assert_allclose(arm.mass_matrix(q), SPREAD.T @ mass @ SPREAD, atol=1e-11)


def test_inverse_kinematics_keeps_the_limits_of_all_joints(arm):
    for q, *_ in Q:
        position, _ = arm.forward_kinematics(q)
        result = arm.inverse_kinematics(position)
        assert result.success
        values = SPREAD @ result.q + OFFSET
        assert (np.abs(values[2:]) <= 1.5 + 1e-12).all()
        assert -0.2 - 1e-12 <= values[1] <= 0.3 + 1e-12


def test_a_joint_wraps_only_where_a_turn_changes_nothing():
    """A wheel that drives another one half as fast is where it was after two turns."""
    for multiplier in (2, 0.5):
        wheels = two_wheels(f'multiplier="{multiplier}"', elbow='<origin xyz="1 0 0"/>')
        arm = lt.Arm.from_urdf(wheels).with_tool((1, 0, 0))
        q = np.array([7.5])
        target, _ = arm.forward_kinematics(q)
        for seed in (7.0, 0.5):
            result = arm.inverse_kinematics(target, q0=[seed])
            if result.success:
                np.testing.assert_allclose(arm.forward_kinematics(result.q)[0], target, atol=1e-5)
        assert arm.inverse_kinematics(target, q0=[7.0]).success


def test_a_leader_outside_the_arm_must_be_locked():
    text = document(wrist=("revolute", "0.1 0.1 0", "0 0 -1", '{limit}<mimic joint="turn"/>'))
    with pytest.raises(InvalidRobot, match="lock") as refusal:
        lt.Arm.from_urdf(text, base="link1")
    assert refusal.value.where == "joint 'wrist'"
    locked = lt.Arm.from_urdf(text, base="link1", locked_joints={"turn": 0.4})
    assert locked.joint_names == ("lift", "lead")
    bent = lt.Arm.from_urdf(document(), base="link1").with_tool((0.0, 0.0, 0.0))
    for q in Q[:3, 0, 1:3]:
        straight = bent.forward_kinematics([*q, 0.4])
        for ours, truth in zip(locked.forward_kinematics(q), straight, strict=True):
            np.testing.assert_allclose(ours, truth, atol=1e-14)


@pytest.mark.parametrize(
    ("name", "mimic", "message"),
    [
        ("lift", 'joint="lift"', "itself"),
        ("lead", 'joint="curl"', "itself"),
        ("wrist", 'joint="lead" offset="9"', "leave no value"),
        ("wrist", 'joint="lead" offset="nan"', "finite"),
        ("wrist", 'joint="lead" multiplier="0" offset="9"', "outside"),
    ],
)
def test_contradictory_mimics_are_refused(name, mimic, message):
    changed = ("revolute", "0 0 0", "0 1 0", f"{{limit}}<mimic {mimic}/>")
    with pytest.raises(InvalidRobot, match=message):
        lt.Arm.from_urdf(document(**{name: changed}))


def test_a_joint_that_mimics_cannot_be_locked(arm):
    with pytest.raises(InvalidInput, match="'lead'; lock that one"):
        arm.lock_joints({"curl": 0.1})


def test_locking_the_leader_locks_its_followers(arm):
    locked = arm.lock_joints({"lead": 0.4})
    assert locked.joint_names == ("turn", "lift", "wrist")
    for q, *_ in Q[:5]:
        q[2] = 0.4
        for ours, truth in zip(
            locked.forward_kinematics(q[[0, 1, 3]]), arm.forward_kinematics(q), strict=True
        ):
            np.testing.assert_allclose(ours, truth, atol=1e-14)
    np.testing.assert_allclose(
        locked.gravity_torques([0.1, 0.2, 0.3]),
        arm.gravity_torques([0.1, 0.2, 0.4, 0.3])[[0, 1, 3]],
        atol=1e-12,
    )

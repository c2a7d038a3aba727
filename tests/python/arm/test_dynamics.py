import pickle
import re
from concurrent.futures import ThreadPoolExecutor
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
import pytest
from foreign_arms import urdf_in_package
from pinocchio_peer import Peer
from refusals import raised, refused
from urdfs import one_joint

import leadthrough as lt
from leadthrough.errors import InvalidRobot

INERTIA = [[0.03, 0.004, -0.002], [0.004, 0.04, 0.003], [-0.002, 0.003, 0.05]]


def others(path, arm):
    """A value inside the limits for every joint outside the arm that moves by itself."""
    values = {}
    for joint in ElementTree.parse(path).getroot().findall("joint"):
        name, limit = joint.get("name"), joint.find("limit")
        outside = joint.get("type") != "fixed" and joint.find("mimic") is None
        if not outside or name in arm.joint_names:
            continue
        bounded = joint.get("type") != "continuous"
        lower, upper = (float(limit.get(key)) if bounded else 0.0 for key in ("lower", "upper"))
        values[name] = 0.3 * lower + 0.7 * upper
    return values


@pytest.fixture
def held(robot):
    """An arm all of whose robot's other joints are held, and its peer."""
    _, arm, path, _ = robot
    values = others(path, arm)
    whole = lt.Arm.from_urdf(path, base=arm.base, tip=arm.tip, locked_joints=values)
    return whole, Peer(arm, path, values)


@pytest.fixture
def motions(arm):
    return np.random.default_rng(1).uniform(-2.0, 2.0, (20, 3, len(arm.joint_names)))


def assert_same_dynamics(arm, peer, motions):
    for q, qd, qdd in motions:
        for gravity in ((0.0, 0.0, -9.81), (3.0, -4.0, 5.0)):
            np.testing.assert_allclose(
                arm.inverse_dynamics(q, qd, qdd, gravity=gravity),
                peer.torques(q, qd, qdd, gravity),
                atol=1e-10,
            )
        peer.model.gravity.linear = np.array([0.0, 0.0, -9.81])
        np.testing.assert_allclose(arm.gravity_torques(q), peer.gravity(q), atol=1e-10)
        np.testing.assert_allclose(arm.mass_matrix(q), peer.mass_matrix(q), atol=1e-11)


def test_dynamics_agree_with_pinocchio(held, motions):
    assert_same_dynamics(*held, motions)


def test_gravity_pulls_down_in_the_frame_of_the_root_where_the_base_is_turned():
    path = urdf_in_package("example-robot-data", "icub.urdf")
    torso = {"torso_pitch": 0.6, "torso_roll": 0.5, "torso_yaw": 0.8}
    ends = {"base": "chest", "tip": "l_hand"}
    arm = lt.Arm.from_urdf(path, **ends)
    held = lt.Arm.from_urdf(path, **ends, locked_joints=torso)
    q = np.random.default_rng(3).uniform(-1.0, 1.0, (5, len(arm.joint_names)))
    peer = Peer(held, path, torso)
    np.testing.assert_allclose(
        held.gravity_torques(q), [peer.gravity(each) for each in q], atol=1e-10
    )
    np.testing.assert_array_equal(arm.gravity, (0.0, 0.0, -9.81))  # the torso may stand anyhow


@pytest.mark.parametrize(
    ("urdf", "base", "tip"),
    [("icub.urdf", "chest", "l_hand"), ("z1.urdf", "link00", "link06")],
)
def test_motors_bear_the_friction_that_pinocchio_reads(urdf, base, tip):
    path = urdf_in_package("example-robot-data", urdf)
    arm = lt.Arm.from_urdf(path, base=base, tip=tip)
    arm = lt.Arm.from_urdf(path, base=base, tip=tip, locked_joints=others(path, arm))
    peer = Peer(arm, path, arm.locked_joints)
    q, qd, qdd = np.random.default_rng(4).uniform(-1.0, 1.0, (3, 5, len(arm.joint_names)))
    qd[0] = 0.0
    damping, dry = peer.model.damping[peer.order], peer.model.upperDryFrictionLimit[peer.order]
    assert damping.any()
    needed = [peer.torques(*row) for row in zip(q, qd, qdd, strict=True)]
    needed += damping * qd + dry * np.sign(qd)
    np.testing.assert_allclose(arm.motor_torques(q, qd, qdd), needed, atol=1e-10)
    np.testing.assert_array_equal(
        arm.motor_torques(q[1], qd[1], qdd[1]), arm.motor_torques(q, qd, qdd)[1]
    )


def test_dynamics_of_the_bundled_robots_agree_with_pinocchio(robots_by_name):
    for arm, path in robots_by_name:
        motions = np.random.default_rng(2).uniform(-2, 2, (5, 3, len(arm.joint_names)))
        assert_same_dynamics(arm, Peer(arm, path, {}), motions)


def test_loads_and_tools_count(held, motions):
    arm, peer = held
    turn = np.array([0.8, 0.0, 0.6, 0.0])
    tool = pin.SE3(pin.Quaternion(0.8, 0.0, 0.6, 0.0).matrix(), np.array([0.1, 0.2, 0.3]))
    loaded = arm.with_payload(1.5, (0.0, 0.1, 0.2), INERTIA)
    loaded = loaded.with_tool((0.1, 0.2, 0.3), turn).with_payload(0.7, (0.0, 0.0, 0.4), INERTIA)
    peer.add_load(1.5, (0.0, 0.1, 0.2), INERTIA)
    peer.add_load(0.7, (0.0, 0.0, 0.4), INERTIA, tool)
    assert_same_dynamics(loaded, peer, motions)
    assert_same_dynamics(pickle.loads(pickle.dumps(loaded)), peer, motions[:1])


def test_what_moves_by_joints_outside_the_arm_does_not_count_until_held(robot):
    name, arm, path, posture = robot
    held = lt.Arm.from_urdf(path, base=arm.base, tip=arm.tip, locked_joints=others(path, arm))
    same = np.array_equal(arm.gravity_torques(posture), held.gravity_torques(posture))
    assert same == (name == "ur3")  # the Panda's fingers, TIAGo's head


def test_the_law_of_motion_holds(arm, posture):
    rng = np.random.default_rng(3)
    qd, qdd = rng.uniform(-2.0, 2.0, (2, len(posture)))
    mass = arm.mass_matrix(posture)
    assert (np.linalg.eigvalsh(mass) > 0).all()
    bias = arm.inverse_dynamics(posture, qd, np.zeros_like(qd))
    np.testing.assert_allclose(
        arm.inverse_dynamics(posture, qd, qdd), mass @ qdd + bias, atol=1e-11
    )
    lifted = arm.inverse_dynamics(posture, 0 * qd, 0 * qd, gravity=(0.0, 0.0, 0.0))
    np.testing.assert_allclose(lifted, 0.0, atol=1e-12)


def test_batches_are_their_rows_also_from_several_threads(arm, motions):
    q, qd, qdd = np.moveaxis(motions, 1, 0)
    torques, mass = arm.inverse_dynamics(q, qd, qdd), arm.mass_matrix(q)
    for i in range(3):
        np.testing.assert_array_equal(torques[i], arm.inverse_dynamics(q[i], qd[i], qdd[i]))
        np.testing.assert_array_equal(mass[i], arm.mass_matrix(q[i]))
    np.testing.assert_array_equal(arm.gravity_torques(q), [arm.gravity_torques(row) for row in q])
    with ThreadPoolExecutor(4) as pool:
        for again in pool.map(lambda _: arm.inverse_dynamics(q, qd, qdd), range(8)):
            np.testing.assert_array_equal(again, torques)


def test_a_robot_without_masses_is_refused():
    arm = lt.Arm.from_urdf(one_joint()).with_payload(1.0)
    for compute in (arm.gravity_torques, arm.mass_matrix):
        assert "mass" in str(raised(InvalidRobot, compute, [0.1]))


@pytest.mark.parametrize("bad", [np.zeros(3), "q", None, [[1.0], [1.0, 2.0]], np.nan])
def test_what_does_not_fit_is_refused_by_name(arm, posture, bad):
    refused("qd", arm.inverse_dynamics, posture, bad, posture)
    refused("q: ", arm.mass_matrix, bad)
    refused("gravity", arm.gravity_torques, posture, gravity=(0.0, -9.81))
    refused("too large", arm.inverse_dynamics, posture, np.full_like(posture, 1e200), posture)


FILLED = """<robot name="two"><link name="base"/>
  <link name="upper">{upper}<collision><origin xyz="0.1 0 0.2" rpy="0 0.5 0"/><geometry>
    <box size="0.1 0.2 0.3"/></geometry></collision></link>
  <link name="lower">{lower}<visual><origin xyz="0 0 0.3"/><geometry><sphere radius="0.1"/>
    </geometry></visual></link>
  <joint name="a" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/>
    <limit lower="-2" upper="2" velocity="1" effort="0"/></joint>
  <joint name="b" type="revolute"><origin xyz="0 0 0.4"/><parent link="upper"/><child link="lower"/>
    <axis xyz="0 1 0"/><limit lower="-2" upper="2" velocity="1" effort="0"/></joint></robot>"""
INERTIAL = """<inertial><origin xyz="{}" rpy="{}"/><mass value="{}"/>
  <inertia ixx="{}" iyy="{}" izz="{}" ixy="0" ixz="0" iyz="0"/></inertial>"""


def test_links_without_masses_are_filled_shapes_at_a_density():
    """As with the masses and inertias of a box and a ball of twice the density of water."""
    box, ball = 2000.0 * 0.1 * 0.2 * 0.3, 2000.0 * 4.0 / 3.0 * np.pi * 0.1**3
    moments = [box / 12.0 * (a**2 + b**2) for a, b in ((0.2, 0.3), (0.1, 0.3), (0.1, 0.2))]
    upper = INERTIAL.format("0.1 0 0.2", "0 0.5 0", box, *moments)
    lower = INERTIAL.format("0 0 0.3", "0 0 0", ball, *[0.4 * ball * 0.1**2] * 3)
    stated = lt.Arm.from_urdf(FILLED.format(upper=upper, lower=lower))
    assumed = lt.Arm.from_urdf(FILLED.format(upper="", lower="")).with_density(2000.0)
    partly = lt.Arm.from_urdf(FILLED.format(upper="", lower=lower)).with_density(2000.0)
    again = assumed.with_density(1.0).with_density(2000.0)  # the last one counts
    q, qd, qdd = np.random.default_rng(0).uniform(-2.0, 2.0, (3, 20, 2))
    np.testing.assert_array_equal(again.mass_matrix(q), assumed.mass_matrix(q))
    expected = stated.inverse_dynamics(q, qd, qdd)
    for arm, tolerance in ((partly, 1e-12), (pickle.loads(pickle.dumps(assumed)), 0.02)):
        within = tolerance * np.abs(expected).max()
        np.testing.assert_allclose(arm.inverse_dynamics(q, qd, qdd), expected, atol=within)


def test_a_density_needs_shapes_and_is_positive():
    shapeless = FILLED.replace("collision", "ignored").replace("visual", "ignored")
    bare = lt.Arm.from_urdf(shapeless.format(upper="", lower=""))
    words = "no link that the arm moves has a mass.*arm.with_density"
    assert re.search(words, str(raised(InvalidRobot, bare.gravity_torques, [0.0, 0.0])))
    assert "has a shape to be filled" in str(raised(InvalidRobot, bare.with_density))
    for wrong in (0.0, -1.0, np.nan, np.inf, "water"):
        refused("density", bare.with_density, wrong)

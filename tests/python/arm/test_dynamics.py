import pickle
from concurrent.futures import ThreadPoolExecutor
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
import pytest

import leadthrough as lt
from leadthrough.errors import InvalidInput, InvalidRobot

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


def followers(path, values):
    """The values of the joints that mimic these."""
    joints = ElementTree.parse(path).getroot().findall("joint[mimic]")
    mimics = {joint.get("name"): joint.find("mimic").attrib for joint in joints}
    return {
        name: float(mimic.get("multiplier", 1)) * values[mimic["joint"]]
        + float(mimic.get("offset", 0))
        for name, mimic in mimics.items()
        if mimic["joint"] in values
    }


class Peer:
    """Pinocchio's model of a robot in which nothing but the arm moves."""

    def __init__(self, arm, path, held):
        whole = pin.buildModelFromUrdf(str(path))
        place = pin.neutral(whole)
        standing = held | followers(path, held)
        for name, value in standing.items():
            self.put(whole, place, name, value)
        locked = [whole.getJointId(name) for name in standing]
        self.model = pin.buildReducedModel(whole, locked, place)
        self.data = self.model.createData()
        self.names = arm.joint_names
        self.order = [self.model.joints[self.model.getJointId(name)].idx_v for name in self.names]
        self.tip = arm.tip

    @staticmethod
    def put(model, place, name, value):
        joint = model.joints[model.getJointId(name)]
        whole = value if joint.nq == 1 else (np.cos(value), np.sin(value))
        place[joint.idx_q : joint.idx_q + joint.nq] = whole

    def add_load(self, mass, center, inertia, tool=None):
        frame = self.model.frames[self.model.getFrameId(self.tip)]
        placement = frame.placement if tool is None else frame.placement * tool
        body = pin.Inertia(mass, np.array(center, float), np.array(inertia, float))
        self.model.appendBodyToJoint(frame.parentJoint, body, placement)
        self.data = self.model.createData()

    def configuration(self, q):
        place = pin.neutral(self.model)
        for name, value in zip(self.names, q, strict=True):
            self.put(self.model, place, name, value)
        return place

    def rates(self, values):
        speeds = np.zeros(self.model.nv)
        speeds[self.order] = values
        return speeds

    def torques(self, q, qd, qdd, gravity=(0.0, 0.0, -9.81)):
        self.model.gravity.linear = np.array(gravity, float)
        place = self.configuration(q)
        return pin.rnea(self.model, self.data, place, self.rates(qd), self.rates(qdd))[self.order]

    def gravity(self, q):
        place = self.configuration(q)
        return pin.computeGeneralizedGravity(self.model, self.data, place)[self.order]

    def mass_matrix(self, q):
        upper = np.triu(pin.crba(self.model, self.data, self.configuration(q)))
        return (upper + np.triu(upper, 1).T)[np.ix_(self.order, self.order)]


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
    document = (
        '<robot name="light"><link name="a"/><link name="b"/>'
        '<joint name="turn" type="continuous"><parent link="a"/><child link="b"/></joint></robot>'
    )
    arm = lt.Arm.from_urdf(document).with_payload(1.0)
    for compute in (arm.gravity_torques, arm.mass_matrix):
        with pytest.raises(InvalidRobot, match="mass"):
            compute([0.1])


@pytest.mark.parametrize("bad", [np.zeros(3), "q", None, [[1.0], [1.0, 2.0]], np.nan])
def test_what_does_not_fit_is_refused_by_name(arm, posture, bad):
    with pytest.raises(InvalidInput, match="qd"):
        arm.inverse_dynamics(posture, bad, posture)
    with pytest.raises(InvalidInput, match="q: "):
        arm.mass_matrix(bad)
    with pytest.raises(InvalidInput, match="gravity"):
        arm.gravity_torques(posture, gravity=(0.0, -9.81))
    with pytest.raises(InvalidInput, match="too large"):
        arm.inverse_dynamics(posture, np.full_like(posture, 1e200), posture)

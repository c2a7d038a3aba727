"""Our robot descriptions against published ones, physics and a real robot's recordings."""

import csv
import tomllib
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np
import pinocchio
import pytest

QUANTITIES = {"position", "velocity", "acceleration", "jerk", "effort", "inertia"}


class Robot(NamedTuple):
    name: str
    published: str
    base: str
    tip: str
    joints: tuple[str, ...]


UR_PARTS = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
UR3 = Robot(
    "ur3",
    "ur_description/urdf/ur3_robot.urdf",
    "base_link",
    "tool0",
    tuple(f"{part}_joint" for part in UR_PARTS),
)
PANDA = Robot(
    "panda",
    "panda_description/urdf/panda.urdf",
    "panda_link0",
    "panda_hand_tcp",
    tuple(f"panda_joint{i}" for i in range(1, 8)),
)
TIAGO = Robot(
    "tiago",
    "tiago_description/robots/tiago.urdf",
    "base_footprint",
    "arm_7_link",
    ("torso_lift_joint", *(f"arm_{i}_joint" for i in range(1, 8))),
)


@pytest.fixture(params=[UR3, PANDA, TIAGO], ids=lambda robot: robot.name)
def robot(request):
    return request.param


def urdf(robots, robot):
    return robots / robot.name / f"{robot.name}.urdf"


@pytest.fixture
def root(robots, robot):
    """The robot's description."""
    return ElementTree.parse(urdf(robots, robot)).getroot()


def limits(robots, robot):
    return tomllib.loads((robots / robot.name / "limits.toml").read_text())


class Kinematics:
    """Pose and Jacobian of a robot's tip in its base frame, by Pinocchio."""

    def __init__(self, path, robot):
        self.model = pinocchio.buildModelFromUrdf(str(path))
        self.data = self.model.createData()
        self.joints = [self.model.joints[self.model.getJointId(name)] for name in robot.joints]
        self.base, self.tip = (self.model.getFrameId(name) for name in (robot.base, robot.tip))

    def __call__(self, q):
        configuration = pinocchio.neutral(self.model)
        for joint, angle in zip(self.joints, q, strict=True):
            # Pinocchio holds a continuous joint as cosine and sine.
            value = angle if joint.nq == 1 else (np.cos(angle), np.sin(angle))
            configuration[joint.idx_q : joint.idx_q + joint.nq] = value
        pinocchio.computeJointJacobians(self.model, self.data, configuration)
        pinocchio.updateFramePlacements(self.model, self.data)
        jacobian = pinocchio.getFrameJacobian(
            self.model, self.data, self.tip, pinocchio.LOCAL_WORLD_ALIGNED
        )
        T_world_base, T_world_tip = self.data.oMf[self.base], self.data.oMf[self.tip]
        into_base = np.kron(np.eye(2), T_world_base.rotation.T)
        columns = [joint.idx_v for joint in self.joints]
        return T_world_base.actInv(T_world_tip).homogeneous, into_base @ jacobian[:, columns]


def test_pose_and_jacobian_are_those_of_the_published_description(robots, published, robot):
    ours = Kinematics(urdf(robots, robot), robot)
    theirs = Kinematics(published / robot.published, robot)
    for q in np.random.default_rng(0).uniform(-3.0, 3.0, (200, len(robot.joints))):
        for value, expected in zip(ours(q), theirs(q), strict=True):
            # The published files write a right angle with eleven decimals.
            np.testing.assert_allclose(value, expected, rtol=0, atol=1e-9)


def test_a_robot_is_one_chain_from_its_base_to_its_tip(robot, root):
    child_of = {
        joint.find("parent").get("link"): joint.find("child").get("link")
        for joint in root.findall("joint")
    }
    assert len(child_of) == len(root.findall("joint")) == len(root.findall("link")) - 1
    link = robot.base
    while link in child_of:
        link = child_of[link]
    assert link == robot.tip
    moving = [j.get("name") for j in root.findall("joint") if j.get("type") != "fixed"]
    assert tuple(moving) == robot.joints


def test_inertias_are_those_of_real_bodies(robots, robot):
    model = pinocchio.buildModelFromUrdf(str(urdf(robots, robot)))
    assert model.njoints == len(robot.joints) + 1
    for inertia in list(model.inertias)[1:]:
        moments = np.linalg.eigvalsh(inertia.inertia)
        assert inertia.mass > 0
        assert moments[0] > 0
        assert moments[0] + moments[1] >= moments[2]


def test_every_joint_has_position_velocity_and_effort_limits(robot, root):
    for name in robot.joints:
        joint = root.find(f"joint[@name='{name}']")
        limit = {key: float(value) for key, value in joint.find("limit").attrib.items()}
        assert limit["velocity"] > 0
        assert limit["effort"] > 0
        assert joint.get("type") == "continuous" or limit["lower"] < limit["upper"]


def test_only_the_last_wrist_joint_of_the_ur3_turns_without_end(robots):
    joints = ElementTree.parse(urdf(robots, UR3)).getroot().findall("joint[@type='continuous']")
    assert [joint.get("name") for joint in joints] == ["wrist_3_joint"]


def test_limits_name_every_joint_and_the_source_of_every_quantity(robots, robot):
    table = limits(robots, robot)
    assert table["robot"] == robot.name
    assert set(table["sources"]) == QUANTITIES
    assert all(len(source) > 20 for source in table["sources"].values())
    assert tuple(table["joints"]) == robot.joints
    for values in table["joints"].values():
        assert set(values) >= {"velocity", "acceleration", "jerk"}
        assert all(value > 0 for value in values.values())


def test_limits_and_urdf_state_the_same_velocity(robots, robot, root):
    for name, values in limits(robots, robot)["joints"].items():
        limit = root.find(f"joint[@name='{name}']/limit")
        assert float(limit.get("velocity")) == values["velocity"]


@pytest.mark.parametrize("recording", ["trial1.csv", "trial2.csv"])
def test_the_panda_stands_where_a_real_one_says_it_stands(robots, recordings, recording):
    with (recordings / "panda_execution" / recording).open() as file:
        rows = list(csv.DictReader(file))
    tip = Kinematics(urdf(robots, PANDA), PANDA)
    joints = [[float(row[f"joint_{i}"]) for i in range(1, 8)] for row in rows]
    recorded = [[float(row[f"current_pos_{axis}"]) for axis in "xyz"] for row in rows]
    turned = [[float(row[f"current_orientation_{part}"]) for part in "xyzw"] for row in rows]
    poses = np.array([tip(q)[0] for q in joints])
    difference = poses[:, :3, 3] - np.array(recorded)
    # Pose and joints are not recorded at the same instant: single rows differ, the mean does not.
    assert np.abs(difference.mean(axis=0)).max() < 1e-4
    assert difference.std(axis=0).max() < 1e-3
    rotations = [pinocchio.Quaternion(np.array(q)).normalized().matrix() for q in turned]
    angles = [
        np.linalg.norm(pinocchio.log3(pose[:3, :3].T @ rotation))
        for pose, rotation in zip(poses, rotations, strict=True)
    ]
    assert np.median(angles) < 1e-3

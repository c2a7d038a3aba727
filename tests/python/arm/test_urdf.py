"""URDFs: meshes, joints that mimic others, and files that are damaged or hostile."""

import coal
import numpy as np
import pinocchio as pin
import pytest
from foreign_arms import urdf_in_package
from refusals import raised
from urdfs import CUBE, one_joint, two_wheels, with_mesh

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


class Hulls:
    """coal's convex hulls of a robot's meshes."""

    def __init__(self, urdf):
        folders = [str(place) for place in urdf.parents if place.name == "share"]
        self.model = pin.buildModelFromUrdf(str(urdf))
        self.geometry = pin.buildGeomFromUrdf(
            self.model, str(urdf), pin.GeometryType.COLLISION, package_dirs=folders
        )
        self.data, self.geometry_data = self.model.createData(), self.geometry.createData()
        self.shapes = {}
        for shape in self.geometry.geometryObjects:
            is_mesh = isinstance(shape.geometry, coal.BVHModelBase)
            if is_mesh:
                shape.geometry.buildConvexHull(True, "Qt")
            body = shape.geometry.convex if is_mesh else shape.geometry
            self.shapes[shape.name.rpartition("_")[0]] = shape.name, body

    def distance(self, q, pair):
        pin.updateGeometryPlacements(self.model, self.data, self.geometry, self.geometry_data, q)
        placed = []
        for name, body in (self.shapes[link] for link in pair):
            pose = self.geometry_data.oMg[self.geometry.getGeometryId(name)]
            placed += [body, coal.Transform3s(pose.rotation, pose.translation)]
        return coal.distance(*placed, coal.DistanceRequest(), coal.DistanceResult())


def test_meshes_are_found_beside_the_urdf_and_count_as_their_hulls():
    urdf = urdf_in_package("example-robot-data", "panda.urdf")
    arm = lt.Arm.from_urdf(urdf, base="panda_link0", tip="panda_hand")
    peer = Hulls(urdf)
    rows = np.random.default_rng(1).uniform(-np.pi, np.pi, (40, 7))
    for q, ours in zip(rows, arm.self_distance(rows), strict=True):
        whole = np.append(q, [0.0, 0.0])  # the fingers
        theirs = min(peer.distance(whole, pair) for pair in arm.collision_pairs.checked)
        if theirs > 0:
            assert ours == pytest.approx(theirs, abs=1e-5)
        else:
            assert theirs - 1e-3 < ours < 1e-6
    assert arm.check(0.1 * rows, [lt.Box((0.1, 0.1, 0.1), (0, 0, 5))]).obstacles.first is None


@pytest.mark.parametrize(
    "name", ["package://parts/meshes/cube.obj", "meshes/cube.obj", "file://{folder}/cube.obj"]
)
def test_a_mesh_is_scaled_and_found_by_package_path_or_address(tmp_path, name):
    folder = tmp_path / "parts" / "meshes"
    folder.mkdir(parents=True)
    (folder / "cube.obj").write_text(CUBE)
    document = with_mesh(name.format(folder=folder), scale="0.1 0.1 -0.1")
    arm = lt.Arm.from_urdf(document, mesh_folders=[tmp_path / "parts"])
    below = lt.Sphere(0.1, (0.05, 0.05, -0.4))
    assert arm.distance([0.0], [below]) == pytest.approx(0.2)


def test_a_mesh_that_is_missing_is_named_when_it_is_needed(tmp_path):
    arm = lt.Arm.from_urdf(with_mesh("package://parts/gone.stl"), mesh_folders=[tmp_path])
    assert arm.forward_kinematics([0.0])[0] is not None
    with pytest.raises(InvalidRobot, match=r"link 'b': mesh 'package://parts/gone.stl'"):
        arm.check([[0.0]])


@pytest.mark.parametrize("content", ["v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n", "v 0 0 0\n", "x"])
def test_a_mesh_without_a_volume_is_refused(tmp_path, content):
    (tmp_path / "flat.obj").write_text(content)
    arm = lt.Arm.from_urdf(with_mesh("flat.obj"), mesh_folders=[tmp_path])
    assert "link 'b'" in str(raised(InvalidRobot, arm.self_distance, [0.0]))


@pytest.mark.parametrize("folders", ["here", 3, [3], None])
def test_wrong_folders_are_refused(folders):
    with pytest.raises(InvalidInput, match="mesh_folders"):
        lt.Arm.from_urdf(with_mesh("a.stl"), mesh_folders=folders)


def robot(inside="", link="", velocity="1"):
    limit = f'<limit lower="-1" upper="1" velocity="{velocity}" effort="1e308"/>'
    return one_joint(inside + limit, kind="revolute", link=link)


def refused(document, message):
    with pytest.raises(InvalidRobot, match=message):
        lt.Arm.from_urdf(document)


def test_an_element_of_a_million_attributes_is_refused():
    many = "".join(f' a{i}="1"' for i in range(1_000_000))
    refused(f'<robot name="r"{many}><link name="a"/></robot>', "more than 64 attributes")


def test_many_capsules_are_read_as_fast_as_other_elements():
    shapes = '<collision><geometry><capsule radius="1" length="1"/></geometry></collision>' * 60_000
    assert lt.Arm.from_urdf(robot(link=shapes)).robot.collisions == {"b": 60_000}


def test_entities_are_not_expanded():
    laughs = "".join(f'<!ENTITY l{i} "{10 * f"&l{i - 1};"}">' for i in range(1, 12))
    head = f'<!DOCTYPE robot [<!ENTITY l0 "ha">{laughs}]>'
    refused(head + robot().replace('"one"', '"&l11;"'), "unsupported markup")
    refused('<!DOCTYPE r [<!ENTITY x SYSTEM "file:///etc/passwd">]>' + robot(), "unsupported")


@pytest.mark.parametrize(
    ("inside", "link", "named"),
    [
        ('<origin xyz="1e308 0 0"/>', "", "joint 'j': origin xyz"),
        ('<origin rpy="0 1e308 0"/>', "", "joint 'j': origin rpy"),
        ('<mimic joint="j" multiplier="1e300"/>', "", "joint 'j'"),
        ("", '<inertial><mass value="1e308"/></inertial>', "link 'b': mass value"),
        ("", '<inertial><origin xyz="0 0 -1e12"/><mass value="1"/></inertial>', "link 'b': origin"),
        ("", '<collision><geometry><sphere radius="1e308"/></geometry></collision>', "link 'b'"),
        ("", '<collision><geometry><box size="1 1e200 1"/></geometry></collision>', "link 'b'"),
    ],
)
def test_sizes_that_no_robot_has_are_refused(inside, link, named):
    refused(robot(inside, link), named)


def test_what_is_accepted_stays_finite():
    arm = lt.Arm.from_urdf(robot('<origin xyz="1e9 -1e9 1e9" rpy="1e9 0 0"/>', velocity="1e308"))
    position, orientation = arm.forward_kinematics([0.5])
    assert np.isfinite(position).all()
    assert np.linalg.norm(orientation) == pytest.approx(1.0)
    assert np.isfinite(arm.jacobian([0.5])).all()
    assert arm.limits.velocity[0] == 1e308


def test_a_mesh_outside_is_named_with_what_to_do(tmp_path):
    (tmp_path / "cube.obj").write_text(CUBE)
    document = with_mesh(tmp_path / "cube.obj")
    arm = lt.Arm.from_urdf(document)
    assert "name its folder in mesh_folders" in str(raised(InvalidRobot, arm.check, [[0.0]]))
    arm = lt.Arm.from_urdf(document, mesh_folders=[tmp_path])
    assert arm.check([[0.0]]).ok


@pytest.mark.parametrize("path", ["a\0b.toml", "\ud800.toml", "/dev/zero", "."])
def test_limits_that_no_file_can_be_are_refused(path):
    with pytest.raises(InvalidInput, match="limits"):
        lt.Arm.from_urdf(robot(), limits=path)


def test_limits_that_nest_deep_are_refused(tmp_path):
    (tmp_path / "deep.toml").write_text("a = " + "[" * 100_000)
    with pytest.raises(InvalidInput, match="not a TOML document"):
        lt.Arm.from_urdf(robot(), limits=tmp_path / "deep.toml")


@pytest.mark.parametrize("folder", ["a\0b", "\ud800"])
def test_folders_of_meshes_that_cannot_be_are_refused(folder):
    with pytest.raises(InvalidInput, match="mesh_folders"):
        lt.Arm.from_urdf(robot(), mesh_folders=[folder])

"""Links: their poses, surfaces and convex parts, and the files of robots."""

import numpy as np
import pytest
from motions import configurations
from refusals import refused
from urdfs import CUBE

import leadthrough as lt
from leadthrough import _core
from leadthrough.arm import link_geometry
from leadthrough.arm.link_geometry import link_poses
from leadthrough.arm.robot_files import find_mesh
from leadthrough.errors import InvalidInput, InvalidRobot

ROBOT = """<robot name="r"><material name="sky"><color rgba="0.1 0.2 0.9 1"/></material>
<link name="a"><visual><origin xyz="1 0 0" rpy="0 0 1.5707963267948966"/>
<geometry><box size="2 4 6"/></geometry><material name="sky"/></visual>
<collision><geometry><sphere radius="9"/></geometry></collision></link>
<link name="b"><visual><geometry><mesh filename="{mesh}" scale="2 2 2"/></geometry>
<material name=""><color rgba="1 0 0 1"/></material></visual>
<collision><origin xyz="0 0 1" rpy="0 0 0"/><geometry><{round} radius="0.5" length="{length}"/>
</geometry></collision></link><link name="bare"/>
<joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint>
<joint name="k" type="fixed"><parent link="b"/><child link="bare"/></joint></robot>"""
OBJ = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nf 1/1 2/2 3/3 4/4\nf -1 1 2\n"


def robot(mesh="none.stl", kind="cylinder", length=1):
    return _core.Robot(ROBOT.format(mesh=mesh, round=kind, length=length))


def surfaces(mesh="none.stl", folders=()):
    return link_geometry.surfaces(robot(mesh), folders)


def test_visual_geometry_is_placed_and_coloured():
    (part,) = surfaces()[0]["a"]
    assert np.allclose(part.surface.vertices.max(axis=0), [3.0, 1.0, 3.0])
    assert part.colour == (0.1, 0.2, 0.9)


def test_mesh_is_read_scaled_and_its_polygons_become_triangles(tmp_path):
    (tmp_path / "part.obj").write_text(OBJ)
    found, remarks = surfaces("part.obj", (str(tmp_path),))
    (part,) = found["b"]
    assert part.surface.vertices.max() == 2.0
    assert part.surface.faces.tolist() == [[0, 1, 2], [0, 2, 3], [4, 0, 1]]
    assert part.colour == (1.0, 0.0, 0.0)
    assert remarks == ()


def test_collision_geometry_stands_in_for_a_mesh_that_is_not_there(tmp_path):
    (tmp_path / "broken.obj").write_text("v 0 0 0\nf 1 2 3\n")
    for mesh in ("none.stl", "broken.obj", "unknown.xyz"):
        (part,) = surfaces(mesh, (str(tmp_path),))[0]["b"]
        assert np.allclose(part.surface.vertices.max(axis=0), [0.5, 0.5, 1.5], atol=1e-2)


def test_link_without_geometry_is_left_out():
    assert "bare" not in surfaces()[0]


def test_a_mesh_that_cannot_be_shown_is_reported():
    _, (remark,) = surfaces()
    assert remark == "link b: mesh: none.stl is not found; its collision shape is shown"


def test_convex_parts_are_those_of_the_collision_geometry():
    parts = link_geometry.convex_parts(robot(), ())
    assert [part.kind for part in parts["a"]] == ["sphere"]
    (part,) = parts["b"]
    assert (part.kind, part.half_sizes) == ("cylinder", (0.5, 0.5))
    assert part.position.tolist() == [0.0, 0.0, 1.0]
    (ball,) = link_geometry.convex_parts(robot(kind="capsule", length=0), ())["b"]
    assert (ball.kind, ball.half_sizes) == ("sphere", (0.5,))
    assert parts["bare"] == []


MIMICRY = """<robot name="r"><link name="a"/><link name="b"/><link name="c"/><link name="side"/>
<joint name="slide" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
<origin xyz="0.1 0 0" rpy="0 0.5 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="turn" type="revolute"><parent link="b"/><child link="c"/><axis xyz="1 0 0"/>
<limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
<joint name="finger" type="prismatic"><parent link="c"/><child link="side"/><axis xyz="0 1 0"/>
<limit lower="-9" upper="9" effort="1" velocity="1"/>
<mimic joint="turn" multiplier="0.5" offset="0.25"/></joint></robot>"""


@pytest.mark.parametrize("name", ["panda", "ur3", "tiago"])
def test_links_are_where_kinematics_put_them(name):
    arm = lt.Arm.load(name)
    q = configurations(arm, 20, 0)
    poses = link_poses(arm, q)
    compared = 0
    for link, (turned, position) in poses.items():
        try:
            shorter = lt.Arm.from_urdf(arm.document, base=arm.base, tip=link)
        except (InvalidRobot, InvalidInput):  # no joint in between, or a joint outside the arm
            continue
        own = [arm.joint_names.index(joint) for joint in shorter.joint_names]
        x, orientation = shorter.forward_kinematics(q[:, own])
        assert np.allclose(position, x, atol=1e-12)
        assert np.allclose(turned, lt.rotations.to_matrix(orientation), atol=1e-12)
        compared += 1
    assert compared >= 6


def test_base_link_stays_at_the_origin_of_its_own_frame():
    arm = lt.Arm.from_urdf(MIMICRY, base="b", tip="c")
    turned, position = link_poses(arm, configurations(arm, 5, 0))["b"]
    assert np.allclose(position, 0.0)
    assert np.allclose(turned, np.eye(3))


def test_joint_that_mimics_moves_its_link():
    arm = lt.Arm.from_urdf(MIMICRY, tip="c")
    poses = link_poses(arm, np.array([[0.3, 0.0], [0.3, 1.0]]))
    (turned, at), (_, finger) = poses["c"], poses["side"]
    local = np.einsum("nji,nj->ni", turned, finger - at)
    assert np.allclose(local, [[0.0, 0.25, 0.0], [0.0, 0.75, 0.0]])


def test_locked_joint_stays_at_its_value():
    arm = lt.Arm.from_urdf(MIMICRY, tip="c", locked_joints={"slide": 0.4})
    _, position = link_poses(arm, np.zeros((1, 1)))["b"]
    assert np.allclose(position, [[0.1 + 0.4 * np.sin(0.5), 0.0, 0.4 * np.cos(0.5)]])


def test_names_of_no_file_find_nothing(tmp_path):
    for name in ("http://example.org/a.stl", "package://", "", "package://../../a.stl"):
        assert find_mesh(name, [str(tmp_path)]) is None


@pytest.mark.parametrize("layout", ["urdf", "package", "plain"])
def test_meshes_outside_of_the_robots_folders_are_not_read(tmp_path, layout):
    home = tmp_path / "home"
    own = home / "robot" / ("urdf" if layout == "urdf" else "description")
    for folder in (own, home / "robot" / "meshes", home / "secret"):
        folder.mkdir(parents=True)
        (folder / "cube.obj").write_text(CUBE)
    if layout == "package":
        (home / "robot" / "package.xml").touch()
    folders = [str(own)]
    assert find_mesh("cube.obj", folders) == own / "cube.obj"
    beside = find_mesh("../meshes/cube.obj", folders)
    assert (beside is not None) == (layout != "plain")
    for slashes in ("//", "///"):  # some exporters write three
        assert find_mesh(f"package:{slashes}robot/meshes/cube.obj", folders) is not None
    secret = home / "secret" / "cube.obj"
    for name in (
        "../../secret/cube.obj", str(secret), secret.as_uri(), "package://robot/../secret/cube.obj",
        "package://../secret/cube.obj", "package:///../secret/cube.obj", "cube.obj\0", "file://[",
        "package://./secret/cube.obj", "meshes/../../../secret/cube.obj",
    ):  # fmt: skip
        assert find_mesh(name, folders) is None, name
    assert find_mesh(str(secret), [*folders, str(home / "secret")]) == secret


def test_a_robot_that_cannot_be_downloaded_names_the_cure(monkeypatch):
    def failing(_):
        raise OSError("no route to host")

    files = "leadthrough.arm.robot_files."
    monkeypatch.setattr(f"{files}find_spec", lambda _: object())
    monkeypatch.setattr(f"{files}import_module", failing)
    monkeypatch.setattr(f"{files}_own", lambda _: None)
    monkeypatch.setattr(f"{files}_of_example_robot_data", lambda _: None)
    refused("load it once with a network, or name its URDF", lt.Arm.load, "gen3")

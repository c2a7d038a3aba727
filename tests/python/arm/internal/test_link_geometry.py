"""Surfaces and convex parts of links, by their visual or collision geometry."""

import numpy as np

from leadthrough import _core
from leadthrough.arm import link_geometry

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

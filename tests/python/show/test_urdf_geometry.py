"""What links look like, by their visual or collision geometry."""

import numpy as np

from leadthrough.show.urdf_geometry import parts_by_link

ROBOT = """<robot name="r"><material name="sky"><color rgba="0.1 0.2 0.9 1"/></material>
<link name="a"><visual><origin xyz="1 0 0" rpy="0 0 1.5707963267948966"/>
<geometry><box size="2 4 6"/></geometry><material name="sky"/></visual>
<collision><geometry><sphere radius="9"/></geometry></collision></link>
<link name="b"><visual><geometry><mesh filename="{mesh}" scale="2 2 2"/></geometry>
<material name=""><color rgba="1 0 0 1"/></material></visual>
<collision><geometry><cylinder radius="0.5" length="1"/></geometry></collision></link>
<link name="bare"/></robot>"""
OBJ = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nf 1/1 2/2 3/3 4/4\nf -1 1 2\n"


def test_visual_geometry_is_placed_and_coloured():
    (part,) = parts_by_link(ROBOT.format(mesh="none.stl"), ())[0]["a"]
    assert np.allclose(part.mesh.vertices.max(axis=0), [3.0, 1.0, 3.0])
    assert part.colour == (0.1, 0.2, 0.9)


def test_mesh_is_read_scaled_and_its_polygons_become_triangles(tmp_path):
    (tmp_path / "part.obj").write_text(OBJ)
    (part,) = parts_by_link(ROBOT.format(mesh="part.obj"), (str(tmp_path),))[0]["b"]
    assert part.mesh.vertices.max() == 2.0
    assert part.mesh.faces.tolist() == [[0, 1, 2], [0, 2, 3], [4, 0, 1]]
    assert part.colour == (1.0, 0.0, 0.0)


def test_collision_geometry_stands_in_for_a_mesh_that_is_not_there(tmp_path):
    (tmp_path / "broken.obj").write_text("v 0 0 0\nf 1 2 3\n")
    for mesh in ("none.stl", "broken.obj", "unknown.xyz"):
        (part,) = parts_by_link(ROBOT.format(mesh=mesh), (str(tmp_path),))[0]["b"]
        assert np.allclose(part.mesh.vertices.max(axis=0), [0.5, 0.5, 0.5], atol=1e-2)


def test_link_without_geometry_is_left_out():
    assert "bare" not in parts_by_link(ROBOT.format(mesh="none.stl"), ())[0]


def test_a_mesh_that_cannot_be_shown_is_told(tmp_path):
    (tmp_path / "part.obj").write_text(OBJ)
    assert parts_by_link(ROBOT.format(mesh="part.obj"), (str(tmp_path),))[1] == ()
    _, (remark,) = parts_by_link(ROBOT.format(mesh="none.stl"), ())
    assert remark == "link b: mesh: none.stl is not found; its collision shape is shown"

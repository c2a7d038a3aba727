"""Points and meshes from files, as obstacles."""

import numpy as np
import pytest
from refusals import refused

import leadthrough as lt
from leadthrough.cli import parse
from leadthrough.errors import InvalidInput

POINTS = np.array([[0.1, 0.2, 0.3], [-1.5, 0.25, 2.0], [4.0, 5.0, -6.0]])
CUBE = """\
v 0 0 0
v 100 0 0
v 100 100 0
v 0 100 0
v 0 0 100
v 100 0 100
v 100 100 100
v 0 100 100
f 1 2 3 4
f 5 6 7 8
f 1 2 6 5
f 3 4 8 7
f 2 3 7 6
f 1 4 8 5
"""


def ply(form, body, fields="property float x\nproperty uchar red\nproperty float y\n"):
    head = (
        f"ply\nformat {form} 1.0\ncomment seen\nelement vertex 3\n{fields}property double z\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    )
    return head.encode() + body


def pcd(form, body, count=4):
    return (
        "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z normal rgb\nSIZE 4 4 4 4 4\nTYPE F F F F U\n"
        f"COUNT 1 1 1 3 1\nWIDTH {count}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {count}\n"
        f"DATA {form}\n"
    ).encode() + body


def rows(dtype, count=3):
    table = np.zeros(count, dtype)
    for axis, name in enumerate("xyz"):
        table[name][:3] = POINTS[:, axis]
        table[name][3:] = np.nan
    return table.tobytes()


def text(points=POINTS, between=" ", last=""):
    return "\n".join(between.join(map(str, point)) + last for point in points).encode()


PLY_ROW = [("x", "<f4"), ("red", "u1"), ("y", "<f4"), ("z", "<f8")]
PCD_ROW = [("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("n", "<f4", 3), ("rgb", "<u4")]
FILES = {
    "plain.xyz": text(),
    "plain.txt": text(between="\t"),
    "table.csv": b"x,y,z\n" + text(between=","),
    "other.csv": b"id,y,z,x\n" + text(np.insert(POINTS[:, [1, 2, 0]], 0, 7, axis=1), ","),
    "windows.csv": b"\xef\xbb\xbfX;Y;Z\r\n" + text(between=";").replace(b"\n", b"\r\n"),
    "seen.xyz": text(np.vstack([POINTS, [np.nan] * 3])),
    "ascii.ply": ply("ascii", b"0.1 9 0.2 0.3\n-1.5 9 0.25 2.0\n4 9 5 -6\n3 0 1 2\n"),
    "little.ply": ply("binary_little_endian", rows(PLY_ROW) + b"\3" + bytes(12)),
    "big.ply": ply(
        "binary_big_endian", rows([(n, t.replace("<", ">")) for n, t in PLY_ROW]) + b"\3"
    ),
    "ascii.pcd": pcd("ascii", text(last=" 0 0 1 255") + b"\nnan nan nan 0 0 0 0\n"),
    "binary.pcd": pcd("binary", rows(PCD_ROW, 4)),
}


@pytest.mark.parametrize("name", FILES)
def test_points_are_read_from_every_format(tmp_path, name):
    path = tmp_path / name
    path.write_bytes(FILES[name])
    cloud = lt.read_point_cloud(path, 0.01, position=(1, 2, 3))
    np.testing.assert_allclose(cloud.points, POINTS, atol=1e-6)
    assert cloud.radius == 0.01
    np.testing.assert_array_equal(cloud.position, (1, 2, 3))


def test_arrays_of_numpy_are_points(tmp_path):
    np.save(tmp_path / "seen.npy", np.hstack([1000 * POINTS, np.ones((3, 1))]).astype(np.float32))
    cloud = lt.read_point_cloud(tmp_path / "seen.npy", 0.01, scale=1e-3)
    np.testing.assert_allclose(cloud.points, POINTS, atol=1e-6)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("none.xyz", b"", "expected finite points, got 0"),
        ("none.csv", b"x,y,z\n", "expected finite points, got 0"),
        ("two.xyz", b"1 2\n", "not a readable file of points"),
        ("inf.xyz", b"1 2 inf\n", "expected finite points"),
        ("words.xyz", b"1 2 here\n", "not a readable file of points"),
        ("odd.stl", b"solid", "expected a file .pcd, .ply"),
        ("cut.ply", ply("binary_little_endian", b"12"), "expected 51 bytes of points, got 2"),
        ("no.ply", b"ply\nformat ascii 1.0\n", "expected a header that ends with end_header"),
        ("flat.ply", ply("ascii", b"", "property float x\n"), "expected fields x, y and z"),
        ("list.ply", ply("ascii", b"", "property list uchar int x\n"), "without lists"),
        ("odd.ply", ply("ascii", b"", "property quad x\nproperty quad y\n"), "not a readable"),
        ("packed.pcd", pcd("binary_compressed", b""), "save it uncompressed"),
        ("cut.pcd", pcd("binary", b"1234"), "expected 112 bytes"),
        ("huge.pcd", pcd("binary", b"", 10**15), "at most"),
        ("less.pcd", pcd("binary", b"", -3), "expected a number"),
        ("bare.pcd", b"DATA ascii\n1 2 3\n", "not a readable"),
        ("pickled.npy", b"\x80\x04]\x94.", "not a readable"),
    ],
)
def test_damaged_files_are_refused_with_their_name(tmp_path, name, content, message):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(InvalidInput, match=message) as error:
        lt.read_point_cloud(tmp_path / name, 0.01)
    assert name in str(error.value)


def test_a_mesh_file_is_an_obstacle_of_its_unit(tmp_path):
    (tmp_path / "cube.obj").write_text(CUBE)
    mesh = lt.read_mesh(tmp_path / "cube.obj", scale=1e-3, position=(1, 0, 0))
    np.testing.assert_allclose(mesh.distance([[1.05, 0.05, 0.05], [2, 0, 0]]), [-0.05, 0.9])
    refused("scale: ", lt.read_mesh, tmp_path / "cube.obj", scale=0.0)
    refused(r"none\.obj", lt.read_mesh, tmp_path / "none.obj")


def test_commands_take_meshes_and_clouds(tmp_path):
    (tmp_path / "a,1@b.obj").write_text(CUBE)
    (tmp_path / "seen.xyz").write_bytes(FILES["plain.xyz"])
    mesh = parse.obstacle(f"mesh:{tmp_path}/a,1@b.obj,0.001@1,0,0/0,1,0,0")
    np.testing.assert_allclose(mesh.distance([[1.05, -0.05, -0.05]]), [-0.05])
    assert parse.obstacle(f"mesh:{tmp_path}/a,1@b.obj").half_extents[0] == 50.0
    cloud = parse.obstacle(f"cloud:{tmp_path}/seen.xyz,0.01@0,0,1e-1")
    np.testing.assert_allclose(cloud.position, (0, 0, 0.1))
    for wrong, told in (
        (f"cloud:{tmp_path}/seen.xyz", "expected a radius"),
        (f"cloud:{tmp_path}/none.xyz,0.01", r"none\.xyz"),
        ("mesh:", "mesh:"),
        ("cube:1@0,0,0", r"cloud:FILE,R\[@X,Y,Z\]"),
    ):
        refused(told, parse.obstacle, wrong)

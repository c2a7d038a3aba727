import sys

import numpy as np
import pytest
from refusals import refused

from leadthrough.errors import MissingDependency
from leadthrough.io.mesh import read_triangles, read_vertices

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]], float)
FACES = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]


def binary_stl(header=b""):
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    triangles = np.zeros(len(FACES), record)
    triangles["corners"] = CORNERS[np.array(FACES)]
    return header.ljust(80, b" ") + np.uint32(len(FACES)).tobytes() + triangles.tobytes()


def text_stl():
    facets = "".join(
        "facet normal 0 0 0\nouter loop\n"
        + "".join(f"  vertex {x:e} {y:e} {z:e}\n" for x, y, z in CORNERS[list(face)])
        + "endloop\nendfacet\n"
        for face in FACES
    )
    return f"solid tetrahedron\n{facets}endsolid tetrahedron\n".encode()


def obj():
    lines = [f"v {x} {y} {z}" for x, y, z in CORNERS]
    lines += ["vn 0 0 1"] + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in FACES]
    return "\n".join(lines).encode()


def collada():
    numbers = " ".join(str(x) for x in CORNERS.ravel())
    faces = " ".join(str(i) for face in FACES for i in face)
    return f"""<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><up_axis>Z_UP</up_axis></asset><library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="12">{numbers}</float_array><technique_common>
<accessor source="#pa" count="4" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/><p>{faces}</p></triangles>
</mesh></geometry></library_geometries><library_visual_scenes><visual_scene id="s"><node id="n">
<instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>""".encode()


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.stl", binary_stl()),
        ("solid.STL", binary_stl(b"solid, but not a text")),
        ("text.stl", text_stl()),
        ("a.obj", obj()),
        ("a.dae", collada()),
    ],
)
def test_vertices_are_those_of_the_file(tmp_path, name, content):
    path = tmp_path / name
    path.write_bytes(content)
    vertices, _ = read_vertices(path)
    assert vertices.dtype == np.float64
    np.testing.assert_allclose(np.unique(vertices, axis=0), np.unique(CORNERS, axis=0), atol=1e-6)


@pytest.mark.parametrize(
    ("name", "content"),
    [("a.stl", binary_stl()), ("t.stl", text_stl()), ("a.obj", obj()), ("a.dae", collada())],
)
def test_triangles_are_those_of_the_file(tmp_path, name, content):
    (tmp_path / name).write_bytes(content)
    vertices, faces = read_triangles(tmp_path / name)
    found = {tuple(map(tuple, np.roll(c, -np.lexsort(c.T)[0], axis=0))) for c in vertices[faces]}
    wanted = CORNERS[np.array(FACES)]
    assert found == {tuple(map(tuple, np.roll(c, -np.lexsort(c.T)[0], axis=0))) for c in wanted}


@pytest.mark.parametrize("faces", ["", "f 1 2 5", "f 0 1 2", "f 1 2 -9", "f 1 two 3"])
def test_triangles_between_vertices_that_are_not_there_are_refused(tmp_path, faces):
    (tmp_path / "a.obj").write_text(f"v 0 0 0\nv 1 0 0\nv 0 1 0\n{faces}\n")
    refused(r"a\.obj", read_triangles, tmp_path / "a.obj")


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("empty.stl", b""),
        ("cut.stl", binary_stl()[:-9]),
        ("words.stl", b"solid\nvertex one two three\n"),
        ("short.obj", b"v 1 2\nv 3 4 5\n"),
        ("nan.obj", b"v 1 2 nan\n"),
        ("empty.obj", b""),
        ("broken.dae", b"<COLLADA>"),
    ],
)
def test_damaged_files_are_refused(tmp_path, name, content):
    path = tmp_path / name
    path.write_bytes(content)
    refused(name, read_vertices, path)


def test_missing_files_are_refused(tmp_path):
    refused("nowhere", read_vertices, tmp_path / "nowhere.stl")


def test_other_formats_name_the_extra_that_reads_them(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "coal", None)
    with pytest.raises(MissingDependency, match=r"leadthrough\[mesh\]"):
        read_vertices(tmp_path / "a.dae")

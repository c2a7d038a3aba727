"""Convex hulls of the links' meshes."""

import pytest
from urdfs import CUBE, with_mesh

import leadthrough as lt
from leadthrough.io import mesh as mesh_files


def test_the_hull_of_a_mesh_is_computed_once_for_each_file_that_is_written(tmp_path, monkeypatch):
    read, own = [], mesh_files.read_vertices
    monkeypatch.setattr(mesh_files, "read_vertices", lambda path: read.append(path) or own(path))
    below = lt.Sphere(0.1, (0.02, 0.02, -0.4))
    for edge, distance in (("1", 0.2), ("0.5", 0.25)):
        (tmp_path / "cube.obj").write_text(CUBE.replace("1", edge))
        for _ in range(2):
            arm = lt.Arm.from_urdf(
                with_mesh("cube.obj", scale="0.1 0.1 -0.1"), mesh_folders=[tmp_path]
            )
            assert arm.distance([0.0], [below]) == pytest.approx(distance)
    assert len(read) == 2

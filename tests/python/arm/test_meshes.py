"""Robots whose collision geometry is meshes."""

import coal
import numpy as np
import pinocchio as pin
import pytest
from foreign_arms import urdf_in_package
from urdfs import CUBE, with_mesh

import leadthrough as lt
from leadthrough.errors import InvalidInput, InvalidRobot


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
    urdf = urdf_in_package("example-robot-data", "ur5_robot.urdf")
    arm = lt.Arm.from_urdf(urdf, base="base_link", tip="tool0")
    peer = Hulls(urdf)
    rows = np.random.default_rng(1).uniform(-np.pi, np.pi, (40, 6))
    for q, ours in zip(rows, arm.self_distance(rows), strict=True):
        theirs = min(peer.distance(q, pair) for pair in arm.collision_pairs.checked)
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
    with pytest.raises(InvalidRobot, match="link 'b'"):
        arm.self_distance([0.0])


@pytest.mark.parametrize("folders", ["here", 3, [3], None])
def test_wrong_folders_are_refused(folders):
    with pytest.raises(InvalidInput, match="mesh_folders"):
        lt.Arm.from_urdf(with_mesh("a.stl"), mesh_folders=folders)

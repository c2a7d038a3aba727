"""The robots' collision shapes against the surfaces of the makers' models."""

from xml.etree import ElementTree

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import leadthrough as lt
from leadthrough.arm.link_geometry import surfaces
from leadthrough.io.mesh import read_triangles

COVERED_WITHIN = 0.008  # m that the maker's surface may stand out of our shapes
TIGHT_WITHIN = 0.03  # m that our shapes may reach beyond the maker's surface along an axis
DRAWN_WITHIN = 0.001  # m of the outlines of the makers' visual models

UR = "ur_description/meshes/ur3/collision"
FRANKA = "panda_description/meshes/collision"
PAL = "tiago_description/meshes"
SURFACES = [
    *(
        ("ur3", f"{link}_link", f"{UR}/{link.replace('_', '')}.stl")
        for link in ("base", "shoulder", "upper_arm", "forearm", "wrist_1", "wrist_2", "wrist_3")
    ),
    *(("panda", f"panda_link{i}", f"{FRANKA}/link{i}.stl") for i in range(8)),
    *(("tiago", f"arm_{i}_link", f"{PAL}/arm/arm_{i}.stl") for i in range(1, 7)),
]


def numbers(element, key):
    text = "0 0 0" if element is None else element.get(key, "0 0 0")
    return np.array(text.split(), dtype=float)


def read_shape(collision):
    origin, solid = collision.find("origin"), collision.find("geometry")[0]
    # URDF turns about fixed x, then y, then z.
    turned = Rotation.from_euler("xyz", numbers(origin, "rpy")).as_quat(scalar_first=True)
    pose = (numbers(origin, "xyz"), turned)
    if solid.tag == "box":
        return lt.Box(numbers(solid, "size"), *pose)
    assert solid.tag == "cylinder"
    return lt.Cylinder(float(solid.get("radius")), float(solid.get("length")), *pose)


def shapes_of(robots, robot, link):
    root = ElementTree.parse(robots / robot / f"{robot}.urdf").getroot()
    return [read_shape(c) for c in root.findall(f"link[@name='{link}']/collision")]


def read_surface(path):
    """Corners and centres of a binary STL file's triangles."""
    facet = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    corners = np.frombuffer(path.read_bytes(), facet, offset=84)["corners"].astype(float)
    return np.vstack([corners.reshape(-1, 3), corners.mean(axis=1)])


def uncovered(shapes, points):
    return np.min([shape.distance(points) for shape in shapes], axis=0).max()


@pytest.mark.parametrize("robot", ["ur3", "panda", "tiago"])
def test_every_link_with_a_mass_has_a_shape_and_none_is_a_mesh(robots, robot):
    root = ElementTree.parse(robots / robot / f"{robot}.urdf").getroot()
    for link in root.findall("link[inertial]"):
        assert shapes_of(robots, robot, link.get("name")), link.get("name")
    assert not root.findall("link/collision/geometry/mesh")


@pytest.mark.parametrize(("robot", "link", "surface"), SURFACES)
def test_shapes_fit_the_makers_surface_tightly(robots, published, robot, link, surface):
    shapes = shapes_of(robots, robot, link)
    points = read_surface(published / surface)
    assert uncovered(shapes, points) < COVERED_WITHIN
    lowest = np.min([shape.middle - shape.half_extents for shape in shapes], axis=0)
    highest = np.max([shape.middle + shape.half_extents for shape in shapes], axis=0)
    assert (lowest > points.min(axis=0) - TIGHT_WITHIN).all()
    assert (highest < points.max(axis=0) + TIGHT_WITHIN).all()


@pytest.mark.parametrize(
    ("robot", "link", "surface"), [each for each in SURFACES if each[0] != "tiago"]
)
def test_visual_meshes_are_the_makers(published, robot, link, surface):
    arm = lt.Arm.load(robot)
    parts, remarks = surfaces(arm.robot, arm.mesh_folders)
    assert remarks == ()
    drawn = np.vstack([part.surface.vertices for part in parts[link]])
    path = (published / surface.replace("collision", "visual")).with_suffix(".dae")
    makers, _ = read_triangles(path)
    np.testing.assert_allclose(drawn.min(axis=0), makers.min(axis=0), atol=DRAWN_WITHIN)
    np.testing.assert_allclose(drawn.max(axis=0), makers.max(axis=0), atol=DRAWN_WITHIN)


def test_visual_meshes_are_drawn_whatever_their_format(published, monkeypatch):
    """COLLADA beside collision shapes of STL; without its reader these, and the reason."""
    arm = lt.Arm.from_urdf(published / "ur_description/urdf/ur3_robot.urdf", tip="tool0")
    makers, faces = read_triangles(published / "ur_description/meshes/ur3/visual/forearm.dae")
    parts, remarks = surfaces(arm.robot, arm.mesh_folders)
    assert remarks == ()
    (drawn,) = parts["forearm_link"]
    assert len(drawn.surface.faces) == len(faces)
    np.testing.assert_allclose(drawn.surface.vertices, makers, atol=1e-12)

    def missing(name, *, extra):
        raise lt.errors.MissingDependency(name, extra=extra)

    monkeypatch.setattr("leadthrough.io.reader_process.require", missing)
    parts, remarks = surfaces(arm.robot, arm.mesh_folders)
    hull = read_surface(published / f"{UR}/forearm.stl")
    assert len(parts["forearm_link"][0].surface.faces) == len(hull) // 4  # corners and centres
    assert "coal is not installed" in remarks[0]
    assert remarks[0].endswith("its collision shape is shown")


@pytest.mark.parametrize("robot", ["ur3", "panda"])
def test_visual_meshes_are_small_and_found_in_a_copy_of_the_urdf_too(robots, robot, tmp_path):
    folder = robots / robot / "visual"
    assert (folder / "LICENSE").is_file()
    assert sum(file.stat().st_size for file in folder.iterdir()) < 1.5e6
    copy = tmp_path / "mine.urdf"
    copy.write_text((robots / robot / f"{robot}.urdf").read_text())
    arm = lt.Arm.from_urdf(copy)
    parts, remarks = surfaces(arm.robot, arm.mesh_folders)
    assert remarks == ()
    assert sum(len(part.surface.faces) for own in parts.values() for part in own) > 5000


@pytest.mark.parametrize("opening", [0.0, 0.02, 0.04])
def test_the_hand_holds_its_fingers_however_far_they_are_open(robots, published, opening):
    shapes = shapes_of(robots, "panda", "panda_hand")
    assert uncovered(shapes, read_surface(published / FRANKA / "hand.stl")) < COVERED_WITHIN
    finger = read_surface(published / FRANKA / "finger.stl")
    left = finger + np.array([0.0, opening, 0.0584])
    assert uncovered(shapes, left) < COVERED_WITHIN
    assert uncovered(shapes, left * [-1.0, -1.0, 1.0]) < COVERED_WITHIN

"""Meshes as the hulls of their parts, against boxes and coal."""

import coal
import numpy as np
import pytest
from refusals import refused
from shapes.meshes import bin_of, mesh_of

import leadthrough as lt
from leadthrough import rotations
from leadthrough.planning import occupied

TURN = rotations.exp([[0.3, -0.7, 1.1]])[0]
PLACE = np.array([0.4, -0.2, 0.9])
QUERIES = PLACE + np.random.default_rng(2).uniform(-1, 1, (400, 3))


def test_a_mesh_of_a_box_is_as_far_as_the_box():
    size = np.array([0.4, 0.6, 1.0])
    box, mesh = (
        lt.Box(size, PLACE, TURN),
        mesh_of(lt.Box(size, np.zeros(3)), place=PLACE, turn=TURN),
    )
    np.testing.assert_allclose(mesh.distance(QUERIES), box.distance(QUERIES), atol=1e-7)
    np.testing.assert_allclose(mesh.middle, box.middle, atol=1e-12)
    np.testing.assert_allclose(mesh.half_extents, box.half_extents, atol=1e-12)
    assert mesh.bounding_radius == pytest.approx(box.bounding_radius)


def test_distance_of_a_hull_is_that_of_coal():
    points = np.random.default_rng(3).normal(size=(40, 3)) * (0.3, 0.2, 0.1)
    faces = np.arange(39)[:, None] + (0, 1, 1)  # a chain: one part
    mesh = lt.Mesh(points, faces, PLACE, TURN)
    theirs = coal.StdVec_Vec3s()
    theirs.extend(list(points))
    hull = coal.ConvexBase.convexHull(theirs, False, "")
    pose = coal.Transform3s(rotations.to_matrix(TURN[None])[0], PLACE)
    for query, ours in zip(QUERIES, mesh.distance(QUERIES), strict=True):
        result = coal.DistanceResult()
        ball = coal.Transform3s(np.eye(3), query)
        coal.distance(hull, pose, coal.Sphere(1e-3), ball, coal.DistanceRequest(), result)
        assert ours - 1e-3 == pytest.approx(result.min_distance, abs=1e-5)


def test_room_between_parts_stays_free_and_inside_a_part_does_not():
    shelf = mesh_of(*(lt.Box((0.5, 0.5, 0.02), (0, 0, z)) for z in (0, 0.4)))
    assert len(shelf.parts) == 2
    np.testing.assert_allclose(shelf.distance([[0, 0, 0.2], [0, 0, 0.4]]), [0.19, -0.01], atol=1e-7)
    joined = mesh_of(lt.Box((0.5, 0.02, 0.02), (0, 0, 0)), lt.Box((0.02, 0.5, 0.02), (0, 0, 0)))
    faces = np.concatenate([joined.faces, [[0, 8, 9]]])
    (part,) = lt.Mesh(joined.vertices, faces).parts
    assert lt.Mesh(part.vertices, part.faces).distance([[0.1, 0.1, 0.0]])[0] < 0.0


@pytest.mark.parametrize("flipped", [False, True])
@pytest.mark.parametrize("frame", [(1.0, 0.0, 0.0, 0.0), TURN])
def test_a_bin_of_one_closed_surface_is_as_its_five_boards(frame, flipped):
    vertices, faces = bin_of((0.4, 0.3, 0.2), 0.005)
    turn = rotations.to_matrix(np.array([frame]))[0]
    line = [[0, 0, 1], [4, 0, 4]]  # such faces are in files, and close nothing
    whole = lt.Mesh(vertices @ turn.T, np.vstack([faces[:, ::-1] if flipped else faces, line]))
    low = np.array([[0, 0, 0], [0, 0, 0], [0.395, 0, 0], [0, 0, 0], [0, 0.295, 0]])
    high = np.array([[0.4, 0.3, 0.005], [0.005, 0.3, 0.2], *[[0.4, 0.3, 0.2]] * 3])
    high[3, 1] = 0.005
    boards = [
        lt.Box(size, middle) for size, middle in zip(high - low, (low + high) / 2, strict=True)
    ]
    queries = np.random.default_rng(4).uniform(-0.1, 0.5, (500, 3))
    truth = np.min([board.distance(queries) for board in boards], axis=0)
    ours = whole.distance(queries @ turn.T)
    np.testing.assert_allclose(np.maximum(ours, 0.0), np.maximum(truth, 0.0), atol=1e-6)
    assert (ours < 0.0).tolist() == (truth < 0.0).tolist()
    opened = lt.Mesh(vertices, faces[2:])  # without its bottom it has no inside
    assert opened.distance([[0.2, 0.15, 0.1]])[0] < 0.0


def test_rounded_edges_of_a_bin_are_filled_by_three_millimetres_at_most():
    vertices, faces = bin_of((0.4, 0.3, 0.2), 0.005, 0.01, 7)
    mesh = lt.Mesh(vertices, faces)
    assert 1 < len(mesh.parts) < 64
    model, corners = coal.BVHModelOBBRSS(), coal.StdVec_Vec3s()
    triangles = coal.StdVec_Triangle()
    corners.extend(list(vertices))
    triangles.extend([coal.Triangle(*map(int, face)) for face in faces])
    model.beginModel(len(faces), len(vertices))
    model.addSubModel(corners, triangles)
    model.endModel()
    for query in np.random.default_rng(4).uniform(0.02, (0.38, 0.28, 0.2), (100, 3)):
        result, place = coal.DistanceResult(), coal.Transform3s(np.eye(3), query)
        pair = (model, coal.Transform3s(), coal.Sphere(1e-3), place)
        coal.distance(*pair, coal.DistanceRequest(), result)
        assert -0.003 < mesh.distance([query])[0] - 1e-3 - result.min_distance < 1e-6


def around(cells):
    """Corners and faces of the surface around the unit cells that are set."""
    corners, faces = [], []
    for cell in np.argwhere(cells):
        for axis in range(3):
            for side in (0, 1):
                beside = cell + (2 * side - 1) * np.eye(3, dtype=int)[axis]
                if ((beside >= 0) & (beside < cells.shape)).all() and cells[tuple(beside)]:
                    continue
                u, v = np.eye(3)[[(axis + 1 + side) % 3, (axis + 2 - side) % 3]][::-1]
                base = cell + side * np.eye(3)[axis]
                faces += [(len(corners) + np.array(f)) for f in ((0, 1, 2), (0, 2, 3))]
                corners += [base, base + u, base + u + v, base + v]
    return np.array(corners), np.array(faces)


def test_surfaces_around_cells_are_occupied_in_these_alone():
    """Also where planes divide the inside into pieces that no face reaches."""
    closed = 0
    for seed in range(100):
        cells = np.random.default_rng(seed).random((3, 3, 3)) < 0.8
        corners, faces = around(cells)
        middles = corners[faces] + corners[np.roll(faces, 1, axis=1)]
        _, shared = np.unique(middles.reshape(-1, 3), axis=0, return_counts=True)
        if (shared != 2).any():  # cells that meet in an edge alone do not close a surface
            continue
        points = np.random.default_rng(seed).uniform(0.0, 3.0, (300, 3))
        occupied = cells[tuple(points.astype(int).T)]
        assert ((lt.Mesh(corners, faces).distance(points) < 0.0) == occupied).all()
        closed += 1
    assert closed > 20


def test_vertices_at_one_place_are_one_as_in_stl_files():
    box = mesh_of(lt.Box((0.4, 0.6, 1.0), (0, 0, 0)), place=PLACE, turn=TURN)
    triangles = box.vertices[box.faces].reshape(-1, 3)
    mesh = lt.Mesh(triangles, np.arange(len(triangles)).reshape(-1, 3), PLACE, TURN)
    assert len(mesh.parts) == 1
    np.testing.assert_allclose(mesh.distance(QUERIES), box.distance(QUERIES), atol=1e-8)


@pytest.mark.parametrize(
    "corners",
    [
        [(0, 0, 0), (1, 0, 0), (0, 1, 0)],  # a sheet
        [(0, 0, 0), (1, 0, 0), (2, 0, 0)],  # a wire
        [(0, 0, 0), (0, 0, 0), (0, 0, 0)],  # a point
    ],
)
def test_what_is_flat_is_a_millimetre_thick(corners):
    thin = lt.Mesh(corners, [(0, 1, 2)])
    on_it = np.asarray(corners, float).mean(axis=0)
    np.testing.assert_allclose(thin.distance([on_it]), -0.0005, atol=1e-7)
    np.testing.assert_allclose(thin.distance([on_it + np.array([0, 0, 0.1])]), 0.0995, atol=1e-7)


def test_hulls_face_outwards_and_contain_their_part():
    points = np.random.default_rng(5).normal(size=(60, 3))
    (hull,) = lt.Mesh(points, np.arange(59)[:, None] + (0, 1, 1)).parts
    a, b, c = (hull.vertices[hull.faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    offsets = np.einsum("ij,ij->i", normals, a)
    assert (points @ normals.T <= offsets + 1e-9).all()


CORNERS = np.eye(4, 3)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: lt.Mesh(CORNERS, [[0, 1, 4]]), "faces: expected indices 0 to 3, got 0 to 4"),
        (lambda: lt.Mesh(CORNERS, [[0, 1, -1]]), "faces: "),
        (lambda: lt.Mesh(CORNERS, [[0, 1, 1.5]]), "faces: expected whole numbers"),
        (lambda: lt.Mesh(CORNERS, np.zeros((0, 3))), "faces: "),
        (lambda: lt.Mesh(CORNERS, [[0, 1]]), "faces: "),
        (lambda: lt.Mesh(CORNERS * 2e6, [[0, 1, 2]]), "vertices: expected coordinates within 1e"),
        (lambda: lt.Mesh([[0, 0, np.nan]], [[0, 0, 0]]), "vertices: "),
        (lambda: lt.Mesh(CORNERS, [[0, 1, 2]], (0, 0)), "position: "),
        (
            lambda: lt.Mesh(np.arange(9009.0).reshape(-1, 3), np.arange(3003).reshape(-1, 3)),
            "faces: expected at most 1,000 connected parts, got 1,001",
        ),
    ],
)
def test_impossible_meshes_are_refused(call, message):
    refused(message, call)


POINTS = np.random.default_rng(1).uniform(-0.5, 0.5, (300, 3))
CLOUD = lt.PointCloud(POINTS, 0.05, PLACE, TURN)


def centres(cloud):
    return cloud.points @ rotations.to_matrix(cloud.orientation[None])[0].T + cloud.position


def test_distance_is_that_of_the_nearest_ball():
    queries = PLACE + np.random.default_rng(2).uniform(-1, 1, (400, 3))
    each = [lt.Sphere(0.05, centre).distance(queries) for centre in centres(CLOUD)]
    np.testing.assert_allclose(CLOUD.distance(queries), np.min(each, axis=0), atol=1e-12)
    assert (CLOUD.distance(centres(CLOUD)) < -0.049).all()


def test_bounds_hold_every_ball():
    away = np.abs(centres(CLOUD) - CLOUD.middle)
    np.testing.assert_allclose(away.max(axis=0) + 0.05, CLOUD.half_extents)
    reached = np.linalg.norm(away, axis=1).max() + 0.05
    assert CLOUD.bounding_radius == pytest.approx(reached)


def test_a_cloud_is_represented_by_its_size():
    assert "array (300, 3)" in repr(CLOUD)


def test_one_point_is_a_ball():
    one, ball = lt.PointCloud([PLACE], 0.1), lt.Sphere(0.1, PLACE)
    queries = np.random.default_rng(4).uniform(-1, 1, (50, 3))
    np.testing.assert_allclose(one.distance(queries), ball.distance(queries), atol=1e-15)
    np.testing.assert_allclose(one.half_extents, ball.half_extents)


def test_cells_of_a_map_are_occupied_by_the_balls():
    grid = lt.Grid((-0.4, -1.1, 0.1), 0.08, (20, 20, 20))
    expected = CLOUD.distance(grid.centres().reshape(-1, 3)) <= 0.02
    actual = occupied(grid, [CLOUD], margin=0.02)
    np.testing.assert_array_equal(actual, expected.reshape(grid.shape))
    assert 0 < actual.sum() < actual.size


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: lt.PointCloud([], 0.1), "points: "),
        (lambda: lt.PointCloud(np.zeros((0, 3)), 0.1), "points: expected 1 to 1,000,000 points"),
        (lambda: lt.PointCloud(np.zeros((1_000_001, 3)), 0.1), "points: .* keep one point per"),
        (lambda: lt.PointCloud([[0, 0, np.nan]], 0.1), "points: "),
        (lambda: lt.PointCloud([[0, np.inf, 0]], 0.1), "points: "),
        (lambda: lt.PointCloud([[0, 0]], 0.1), "points: "),
        (lambda: lt.PointCloud([[0, 0, 0]], 0.0), "radius: "),
        (lambda: lt.PointCloud([[0, 0, 0]], np.nan), "radius: "),
        (lambda: lt.PointCloud([[0, 0, 0]], 0.1, (0, 0)), "position: "),
        (lambda: lt.PointCloud([[0, 0, 0]], 0.1, PLACE, (0, 0, 0, 0)), "orientation: "),
        (lambda: CLOUD.distance([0, 0, 0]), "points: "),
    ],
)
def test_impossible_clouds_are_refused(call, message):
    refused(message, call)

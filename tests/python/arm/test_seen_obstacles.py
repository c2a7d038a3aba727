"""Arms among point clouds and meshes, as cameras and drawings show what stands around."""

import coal
import numpy as np
import pinocchio as pin
import pytest
from motions import configurations
from refusals import refused

import leadthrough as lt
from leadthrough import rotations
from leadthrough.shapes import surface
from leadthrough_studies.coal_arm import CoalArm

TURN = rotations.exp([[0.3, -0.7, 1.1]])[0]
Y = np.array([0.0, 1.0, 0.0])
HOME = np.array([0.0, -0.5, 0.0, -2.2, 0.0, 1.7, 0.8])


@pytest.fixture(scope="module", params=("panda", "ur3"))
def arm(request):
    return lt.Arm.load(request.param)


def scattered(count, seed=1):
    """Points of a table, a wall and a pile beside an arm."""
    random = np.random.default_rng(seed)
    points = random.uniform((-0.8, -0.8, 0.0), (0.8, 0.8, 1.0), (count, 3))
    points[::3, 2] = 0.02
    points[1::3, 0] = 0.6
    points[2::3] = 0.2 * points[2::3] + (-0.5, 0.4, 0.0)
    return points


def test_a_cloud_is_as_far_as_its_nearest_ball(arm):
    points, rows = scattered(60), configurations(arm, 40, 2)
    cloud = lt.PointCloud(points, 0.02, (0.1, 0.0, 0.05), TURN)
    balls = points @ rotations.to_matrix(TURN[None])[0].T + cloud.position
    each = [lt.Sphere(0.02, place) for place in balls]
    np.testing.assert_allclose(arm.distance(rows, [cloud]), arm.distance(rows, each), atol=2e-8)


def test_distance_to_a_cloud_and_a_mesh_is_that_of_coal(arm):
    points, rows = scattered(40), configurations(arm, 25, 3)
    peer = CoalArm(arm)
    corners = np.random.default_rng(4).normal(size=(30, 3)) * (0.1, 0.2, 0.15)
    mesh = lt.Mesh(corners, np.arange(29)[:, None] + (0, 1, 1), (0.4, 0.2, 0.5), TURN)
    vertices = coal.StdVec_Vec3s()
    vertices.extend(list(corners))
    hull = coal.ConvexBase.convexHull(vertices, False, "")
    matrix = rotations.to_matrix(TURN[None])[0]
    to_mesh, to_cloud = (
        arm.distance(rows, [mesh]),
        arm.distance(rows, [lt.PointCloud(points, 0.02)]),
    )
    for q, hull_gap, cloud_gap in zip(rows, to_mesh, to_cloud, strict=True):
        peer.place(q)
        moving = peer.moving_links()
        theirs = peer.distance_to(moving, hull, pin.SE3(matrix, mesh.position))
        ball = coal.Sphere(0.02)
        places = [pin.SE3(np.eye(3), place) for place in points]
        balls = min(peer.distance_to(moving, ball, place) for place in places)
        for ours, wanted in ((hull_gap, theirs), (cloud_gap, balls)):
            # Of bodies that overlap, coal finds now and then another direction than the shallowest.
            assert ours == pytest.approx(wanted, abs=1e-5) if wanted > 0 else ours < 1e-5


def test_clear_is_what_distances_say(arm):
    rows = configurations(arm, 400, 5)
    rows = rows[arm.self_distance(rows) > 1e-6]
    room = [lt.PointCloud(scattered(3000), 0.01), shelf((0.5, 0.1, 0.4))]
    distances = arm.distance(rows, room)
    clear = arm.is_clear(rows, lt.Scene(room, 0.02))
    np.testing.assert_array_equal(clear, distances >= 0.02)
    assert 0 < clear.sum() < len(rows)


def shelf(place):
    boards = [surface.box(np.array([0.3, 0.4, 0.02])).moved(np.array([0, 0, z])) for z in (0, 0.3)]
    whole = surface.merged(boards)
    return lt.Mesh(whole.vertices, whole.faces, place)


def test_a_sheet_of_points_between_two_samples_is_found(panda):
    start, end = HOME.copy(), HOME.copy()
    start[0], end[0] = -0.9, 0.9
    y, z = np.meshgrid(np.linspace(0.35, 0.8, 91), np.linspace(0.0, 0.9, 181))
    sheet = np.column_stack([y.ravel(), np.zeros(y.size), z.ravel()])
    cloud = lt.PointCloud(sheet, 0.003)
    report = panda.check([start, end], [shelf((9.0, 0.0, 0.0)), cloud])
    assert (report.obstacles.distances > 0.05).all()
    assert not report.ok
    assert report.first.bodies[0] == "obstacle 1"
    wall = lt.Box((0.456, 0.006, 0.906), (0.575, 0.0, 0.45))
    same = panda.check([start, end], [wall])
    assert report.first.sample == pytest.approx(same.first.sample, abs=5e-3)
    rows = np.linspace(start, end, 3000)
    before = rows[: int(report.first.sample * 2999)]
    assert panda.distance(before, [cloud]).min() > -report.tolerance


def test_the_elbow_goes_around_a_cloud_and_a_mesh_while_the_tip_keeps_its_path(panda):
    u = np.linspace(0.0, 1.0, 101)
    side = 0.35 - 0.7 * lt.trajectories.minimum_jerk_time_scaling(u)
    line = np.column_stack([np.full(101, 0.45), side, np.full(101, 0.35)])
    motion = lt.PoseTrajectory(3.0 * u, line, [(0.0, 1.0, 0.0, 0.0)] * 101)
    seed = [0.6, -0.5, 0.0, -2.4, 0.0, 2.0, 1.4]
    blind = panda.follow(motion, q0=seed)
    box = surface.box(np.array([0.1, 0.4, 0.2])).moved(np.array([-0.15, 0.0, 0.65]))
    steps = np.linspace(-0.5, 0.5, 21)
    grid = np.stack(np.meshgrid(steps, steps, steps), axis=-1).reshape(-1, 3) * (0.1, 0.4, 0.2)
    for there in (lt.Mesh(box.vertices, box.faces), lt.PointCloud(grid, 0.012, (-0.15, 0.0, 0.65))):
        assert not panda.check(blind, [there]).ok
        around = panda.follow(motion, scene=lt.Scene([there], 0.01), q0=seed)
        assert panda.check(around, lt.Scene([there], 0.005)).ok
        tip, _ = panda.forward_kinematics(around.positions)
        np.testing.assert_allclose(tip, line, atol=2e-4)


def test_planners_keep_clear_of_clouds_and_meshes():
    t = np.linspace(0.0, 2.0, 101)
    line = np.column_stack(
        [0.4 * lt.trajectories.minimum_jerk_time_scaling(t / 2), 0 * t, 0 * t + 0.2]
    )
    shown = [lt.Demonstration(lt.Trajectory(t, line + off * Y)) for off in (-0.01, 0.0, 0.01)]
    ball = surface.sphere(0.05).moved(np.array([0.2, 0.01, 0.2]))
    mesh = lt.Mesh(ball.vertices, ball.faces)
    cloud = lt.PointCloud(ball.vertices, 0.01)
    for model in (lt.FastMarching(resolution=0.02), lt.DMP()):
        for there in (mesh, cloud):
            made = model.fit(shown).generate(obstacles=[there])
            assert there.distance(made.positions).min() > 0.0
            np.testing.assert_allclose(made.positions[-1], line[-1], atol=0.02)


def test_a_task_keeps_a_point_away_from_a_cloud(panda):
    position, _ = panda.forward_kinematics(HOME)
    cloud = lt.PointCloud([(0.1, 0.0, 0.0), (0.0, 0.3, 0.0)], 0.02, position)
    task = lt.arm.ObstacleTask(cloud, 0.1)
    solution = lt.arm.TaskStack(panda, [task]).solve(HOME)
    assert solution.report.error[0] == pytest.approx(0.02, abs=1e-9)


def test_a_held_mesh_counts_and_weighs_as_its_hull(panda):
    size = np.array([0.1, 0.25, 0.4])
    box, outside = lt.Box(size, (0.02, 0.03, 0.3), TURN), surface.box(size)
    mesh = lt.Mesh(outside.vertices, outside.faces, box.position, TURN)
    ours, theirs = (panda.with_attached(each, 2.0) for each in (mesh, box))
    np.testing.assert_allclose(
        ours.attachment.loads[0].inertia, theirs.attachment.loads[0].inertia, atol=1e-12
    )
    np.testing.assert_allclose(
        ours.attachment.loads[0].center, theirs.attachment.loads[0].center, atol=1e-12
    )
    rows, wall = configurations(panda, 20, 6), [lt.Box((0.1, 2, 2), (0.9, 0, 0))]
    np.testing.assert_allclose(ours.distance(rows, wall), theirs.distance(rows, wall), atol=1e-7)
    refused("shape: expected a Box", panda.with_attached, lt.PointCloud([(0, 0, 0)], 0.1))


def test_a_cloud_in_millimetres_is_warned_of(panda):
    with pytest.warns(lt.sanity.ImplausibleInputWarning, match=r"obstacles\[0\]"):
        panda.distance(HOME, [lt.PointCloud(1000 * scattered(10), 5.0)])


def test_the_same_cloud_has_the_same_bits_with_any_threads(panda):
    rows, cloud = configurations(panda, 200, 7), lt.PointCloud(scattered(2000), 0.01)
    once = panda.distance(rows, [cloud])
    np.testing.assert_array_equal(panda.distance(rows, [cloud], threads=3), once)
    again = lt.PointCloud(scattered(2000), 0.01)
    np.testing.assert_array_equal(panda.distance(rows, [again]), once)

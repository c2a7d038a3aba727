"""Collisions of the whole arm: distances, verdicts, and obstacles as seen by cameras."""

import pickle

import coal
import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings, strategies as st
from motions import configurations
from refusals import raised, refused
from shapes.meshes import mesh_of
from urdfs import one_joint

import leadthrough as lt
from leadthrough import rotations
from leadthrough.errors import InvalidRobot
from leadthrough_studies.coal_arm import CoalArm

BUNDLED = ("panda", "ur3", "tiago")
TURN = (0.5, 0.5, 0.5, 0.5)


@pytest.fixture(scope="module", params=BUNDLED)
def bundled(request):
    arm = lt.Arm.load(request.param)
    return arm, CoalArm(arm)


def agrees(ours, theirs):
    # Of bodies that overlap, coal finds now and then a direction that is not the shallowest.
    return ours == pytest.approx(theirs, abs=1e-5) if theirs > 0 else theirs - 1e-3 < ours < 1e-6


def test_self_distance_is_that_of_coal_over_the_checked_pairs(bundled):
    arm, peer = bundled
    rows = configurations(arm, 40, 1)
    for q, ours in zip(rows, arm.self_distance(rows), strict=True):
        peer.place(q)
        theirs = min(peer.link_distance(*pair) for pair in arm.collision_pairs.checked)
        assert agrees(ours, theirs)


def test_distance_to_obstacles_is_that_of_coal(bundled):
    arm, peer = bundled
    rows = configurations(arm, 60, 3)
    obstacles = [
        lt.Box((0.2, 0.1, 0.4), (0.4, 0.2, 0.5), TURN),
        lt.Capsule(0.05, 0.3, (0.2, -0.3, 0.4), TURN),
        lt.Sphere(0.1, (-0.3, -0.3, 0.4)),
        lt.Cylinder(0.08, 0.25, (-0.3, 0.3, 0.6), TURN),
    ]
    solids = [peer.solid(shape) for shape in obstacles]
    for q, ours in zip(rows, arm.distance(rows, obstacles), strict=True):
        peer.place(q)
        assert agrees(ours, min(peer.distance_to(peer.moving_links(), *each) for each in solids))


def test_among_shelves_and_cans_distance_and_verdict_are_those_of_coal(panda):
    peer, rng = CoalArm(panda), np.random.default_rng(6)
    boards = [lt.Box((0.3, 0.8, 0.02), (0.6, 0.0, z)) for z in (0.2, 0.5, 0.8)]
    cans = [lt.Cylinder(0.03, 0.12, (0.55, y, 0.27), TURN) for y in (-0.2, 0.15)]
    shelf = [peer.solid(shape) for shape in boards + cans]
    rows = rng.uniform(panda.limits.lower, panda.limits.upper, (120, 7))
    clear = panda.is_clear(rows, boards + cans)
    for q, ours, verdict in zip(rows, panda.distance(rows, boards + cans), clear, strict=True):
        peer.place(q)
        theirs = min(peer.distance_to(peer.moving_links(), *each) for each in shelf)
        itself = min(peer.link_distance(*pair) for pair in panda.collision_pairs.checked)
        assert agrees(ours, theirs)
        assert verdict == (min(theirs, itself) > -1e-6)
    assert 10 < clear.sum() < 110


def test_what_touches_by_rounding_is_clear(panda):
    """Two links of the Panda meet at its wrist, in the URDF, whatever the joints."""
    rows = configurations(panda, 3000, 7)
    touching = np.abs(panda.self_distance(rows)) < 1e-6
    assert touching.sum() > 100
    assert panda.is_clear(rows[touching]).all()


def test_no_pair_that_coal_finds_to_touch_now_and_then_is_left_out(bundled):
    arm, peer = bundled
    left_out = arm.collision_pairs.left_out
    for q in configurations(arm, 300, 4):
        peer.place(q)
        for pair, why in left_out.items():
            if why != "adjacent":
                assert (peer.link_distance(*pair) < 0) == (why == "always"), pair


def test_a_robot_has_every_pair_either_checked_or_left_out(bundled):
    arm, _ = bundled
    pairs = arm.collision_pairs
    names = [frozenset(pair) for pair in (*pairs.checked, *pairs.left_out)]
    assert len(set(names)) == len(names)
    assert set(pairs.left_out.values()) <= {"adjacent", "never", "always"}


LIMIT = '<limit lower="-3" upper="3" velocity="2" effort="3"/>'


def swing(reach=1.0, radius=0.02):
    """One joint about z; a ball at the end of a link without other shapes."""
    ball = f'<origin xyz="{reach} 0 0"/><geometry><sphere radius="{radius}"/></geometry>'
    link = f"<collision>{ball}</collision>"
    return lt.Arm.from_urdf(one_joint(LIMIT, kind="revolute", link=link))


WALL = lt.Box((0.2, 0.001, 0.2), (1.0, 0.0, 0.0))  # across the way, 1 mm thick


def test_a_thin_wall_between_two_samples_is_found():
    report = swing().check([[-1.0], [1.0]], lt.Scene([WALL], margin=0.0))
    assert (report.distances > 0.4).all()
    assert not report.ok
    assert report.first.bodies == ("obstacle 0", "b")
    # The ball touches the wall's face where sin(angle) = -(radius + half the thickness).
    contact = 0.5 * (1.0 - np.arcsin(0.0205))
    assert report.first.sample == pytest.approx(contact, abs=1e-3)
    assert report.first.distance < 0.0
    assert report.minimum_distance <= -0.02
    assert report.closest.sample == pytest.approx(0.5, abs=2e-3)


def test_past_the_wall_the_motion_is_clear_and_a_margin_is_kept_between_samples():
    beyond = lt.Box((0.2, 0.001, 0.2), (1.2, 0.0, 0.0))  # passed by at 8 cm
    arm = swing()
    report = arm.check([[-1.0], [1.0]], [beyond])
    assert report.ok
    assert report.first is None
    assert report.minimum_distance == pytest.approx(0.1 - 0.02, abs=1e-3)
    assert arm.check([[-1.0], [1.0]], lt.Scene([beyond], 0.075)).ok
    assert not arm.check([[-1.0], [1.0]], lt.Scene([beyond], 0.085)).ok


def test_what_touches_is_no_hit():
    table = lt.Box((4.0, 4.0, 1.0), (0.0, 0.0, -0.52))
    report = swing().check([[-1.0], [1.0]], lt.Scene([table], margin=0.0))
    assert report.ok
    assert report.minimum_distance == pytest.approx(0.0, abs=1e-7)


def test_times_of_a_trajectory_are_told():
    motion = lt.JointTrajectory([2.0, 4.0], [[-1.0], [1.0]], joint_names=("j",))
    report = swing().check(motion, [WALL])
    assert report.first.time == pytest.approx(2.0 + 2.0 * report.first.sample)
    assert "hit" in str(report)
    assert "clear" in str(swing().check(motion))


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10**6), st.sampled_from(BUNDLED))
def test_nothing_between_samples_is_nearer_than_reported(seed, name):
    arm = lt.Arm.load(name)
    rng = np.random.default_rng(seed)
    ends = configurations(arm, 2, seed)
    ends[1] = ends[0] + 0.4 * (ends[1] - ends[0])
    boxes = [lt.Box(rng.uniform(0.02, 0.2, 3), rng.uniform(-0.6, 0.6, 3), TURN) for _ in range(3)]
    report = arm.check(ends, lt.Scene(boxes, 0.02))
    between = ends[0] + np.linspace(0.0, 1.0, 400)[:, None] * (ends[1] - ends[0])
    for found, sampled in (
        (report.obstacles, arm.distance(between, boxes)),
        (report.itself, arm.self_distance(between)),
    ):
        lowest = max(found.minimum_distance, found.margin)
        assert sampled.min() >= min(lowest, found.minimum_distance) - report.tolerance
        hits = np.flatnonzero(sampled < found.margin - report.tolerance)
        if len(hits):
            assert found.first.sample <= hits[0] / 399


def test_samples_are_those_of_single_configurations(panda):
    rows = configurations(panda, 6, 5)
    boxes = [lt.Box((0.1, 0.1, 0.1), (0.4, 0.0, 0.4))]
    report = panda.check(rows, boxes)
    np.testing.assert_array_equal(report.obstacles.distances, panda.distance(rows, boxes))
    np.testing.assert_array_equal(report.itself.distances, panda.self_distance(rows))
    assert panda.self_distance(rows[2]) == report.itself.distances[2]
    assert report.minimum_distance <= report.distances.min()


def test_distance_points_lie_on_the_bodies(panda):
    q = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7])
    box = lt.Box((0.1, 0.1, 0.1), (0.4, 0.3, 0.4))
    closest = panda.check(q[None], [box]).obstacles.closest
    on_box, on_arm = closest.points
    assert closest.distance == pytest.approx(np.linalg.norm(on_box - on_arm), abs=1e-9)
    assert box.distance([on_box])[0] == pytest.approx(0.0, abs=1e-9)
    assert box.distance([on_arm])[0] == pytest.approx(closest.distance, abs=1e-9)


@settings(max_examples=20, deadline=None)
@given(st.floats(-1.0, 1.0), st.integers(0, 1000))
def test_turning_arm_and_obstacle_together_changes_nothing(angle, seed):
    arm = lt.Arm.load("panda")
    q = 0.5 * configurations(arm, 1, seed)[0]
    turned = q + angle * np.eye(7)[0]
    x, y, z = np.random.default_rng(seed).uniform(-0.8, 0.8, 3)
    cosine, sine = np.cos(angle), np.sin(angle)
    here = lt.Box((0.1, 0.2, 0.3), (x, y, z))
    there = lt.Box(
        (0.1, 0.2, 0.3),
        (cosine * x - sine * y, sine * x + cosine * y, z),
        (np.cos(angle / 2), 0, 0, np.sin(angle / 2)),
    )
    assert arm.distance(turned, [there]) == pytest.approx(arm.distance(q, [here]), abs=1e-7)


def test_larger_or_more_obstacles_are_never_farther(panda):
    rows = configurations(panda, 200, 6)
    small = lt.Box((0.1, 0.2, 0.3), (0.4, 0.1, 0.5), TURN)
    large = lt.Box((0.15, 0.25, 0.35), (0.4, 0.1, 0.5), TURN)
    other = lt.Sphere(0.1, (0.0, 0.5, 0.3))
    alone = panda.distance(rows, [small])
    assert (panda.distance(rows, [large]) <= alone + 1e-8).all()
    both = panda.distance(rows, [small, other])
    np.testing.assert_allclose(both, np.minimum(alone, panda.distance(rows, [other])), atol=1e-8)


def test_what_is_attached_is_checked(panda):
    q = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7])
    rod = panda.with_attached(lt.Capsule(0.01, 0.2, (0.0, 0.0, 0.1)))
    position, _ = panda.forward_kinematics(q)
    below = lt.Sphere(0.02, position - np.array([0.0, 0.0, 0.2]))
    report = rod.check(q[None], [below])
    assert report.first.bodies == ("obstacle 0", "attached")
    assert panda.check(q[None], [below]).ok
    assert any("attached" in pair for pair in rod.collision_pairs.checked)


def test_a_held_joint_is_where_it_is_held(panda):
    q = 0.5 * configurations(panda, 1, 8)[0]
    held = panda.lock_joints({"panda_joint4": q[3]})
    box = lt.Box((0.1, 0.1, 0.1), (0.5, 0.0, 0.3))
    assert held.distance(np.delete(q, 3), [box]) == panda.distance(q, [box])


def test_a_mimicking_joint_moves_what_hangs_from_it():
    joints = "".join(
        f'<joint name="j{i}" type="revolute"><parent link="l{i}"/><child link="l{i + 1}"/>'
        f'<origin xyz="{0.5 * (i > 0)} 0 0"/><axis xyz="0 0 1"/>{LIMIT}{mimic}</joint>'
        for i, mimic in enumerate(["", '<mimic joint="j0" multiplier="-2" offset="0.1"/>'])
    )
    links = '<link name="l0"/><link name="l1"/><link name="l2"><collision><origin xyz="0.5 0 0"/>'
    ball = "<geometry><sphere radius='0.01'/></geometry></collision></link>"
    arm = lt.Arm.from_urdf(f'<robot name="fold">{links}{ball}{joints}</robot>')
    position, _ = arm.forward_kinematics([0.7])
    second = 0.7 - 2 * 0.7 + 0.1
    centre = position + 0.5 * np.array([np.cos(second), np.sin(second), 0.0])
    assert arm.distance([0.7], [lt.Sphere(0.02, centre)]) == pytest.approx(-0.03)
    away = lt.Sphere(0.02, centre + np.array([0.0, 0.0, 0.5]))
    assert arm.check([[0.0], [0.7]], [away]).ok


def test_threads_and_copies_give_the_same_bits(panda):
    rows = configurations(panda, 200, 9) * 0.6
    boxes = [lt.Box((0.1, 0.3, 0.1), (0.4, 0.1, 0.4), TURN)]
    one = panda.check(rows, boxes, tolerance=0.01)
    four = pickle.loads(pickle.dumps(panda)).check(rows, boxes, tolerance=0.01, threads=4)
    np.testing.assert_array_equal(one.distances, four.distances)
    assert one.minimum_distance == four.minimum_distance
    assert one.closest.sample == four.closest.sample
    assert one.first.sample == four.first.sample
    np.testing.assert_array_equal(panda.self_distance(rows, threads=3), panda.self_distance(rows))


def test_an_arm_without_collision_geometry_cannot_be_checked():
    bare = lt.Arm.from_urdf(one_joint(LIMIT, kind="revolute"))
    assert bare.forward_kinematics([0.0])[0] is not None
    assert "no link has collision geometry" in str(raised(InvalidRobot, bare.check, [[0.0]]))


def test_nothing_to_hit_is_infinitely_far():
    report = swing().check([[0.0], [1.0]])
    assert report.ok
    assert report.closest is None
    assert report.minimum_distance == np.inf
    assert swing().self_distance([0.0]) == np.inf


def test_wrong_input_of_a_check_is_refused(panda):
    for trajectory, scene, options, match in [
        (np.zeros((0, 7)), (), {}, "trajectory"),
        (np.zeros((3, 6)), (), {}, r"trajectory: expected shape \(m, 7\)"),
        (np.zeros(7), (), {}, "trajectory"),
        (np.full((2, 7), np.nan), (), {}, "trajectory"),
        ([np.zeros(7), np.full(7, 1e9)], (), {}, "trajectory: between two samples"),
        (lt.JointTrajectory([0.0], [np.zeros(7)], joint_names=list("abcdefg")), (), {}, "joints"),
        (None, (), {}, "trajectory"),
        (np.zeros((2, 7)), lt.Sphere(1, (0, 0, 0)), {}, "obstacles"),
        (np.zeros((2, 7)), ["box"], {}, "obstacles"),
        (np.zeros((2, 7)), (), {"tolerance": 0.0}, "tolerance"),
        (np.zeros((2, 7)), (), {"threads": 0}, "threads"),
    ]:
        refused(match, panda.check, trajectory, scene, **options)
    for q in [np.zeros(6), np.zeros((2, 6)), np.nan, "zero", [[np.inf] * 7]]:
        refused("q", panda.distance, q, [])
        refused("q", panda.self_distance, q)


TILT = rotations.exp([[0.3, -0.7, 1.1]])[0]
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
    cloud = lt.PointCloud(points, 0.02, (0.1, 0.0, 0.05), TILT)
    balls = points @ rotations.to_matrix(TILT[None])[0].T + cloud.position
    each = [lt.Sphere(0.02, place) for place in balls]
    np.testing.assert_allclose(arm.distance(rows, [cloud]), arm.distance(rows, each), atol=2e-8)


def test_distance_to_a_cloud_and_a_mesh_is_that_of_coal(arm):
    points, rows = scattered(40), configurations(arm, 25, 3)
    peer = CoalArm(arm)
    corners = np.random.default_rng(4).normal(size=(30, 3)) * (0.1, 0.2, 0.15)
    mesh = lt.Mesh(corners, np.arange(29)[:, None] + (0, 1, 1), (0.4, 0.2, 0.5), TILT)
    vertices = coal.StdVec_Vec3s()
    vertices.extend(list(corners))
    hull = coal.ConvexBase.convexHull(vertices, False, "")
    matrix = rotations.to_matrix(TILT[None])[0]
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
    room = [
        lt.PointCloud(scattered(3000), 0.01),
        shelf((0.5, 0.1, 0.4)),
        lt.Sphere(0.2, (0, -1, 1)),
    ]
    scene = lt.Scene(room, 0.02, self_collision_margin=0.01)
    clear = arm.is_clear(rows, scene)
    apart = (arm.distance(rows, room) >= 0.02) & (arm.self_distance(rows) >= 0.01)
    np.testing.assert_array_equal(clear, apart)
    assert 0 < clear.sum() < len(rows)
    assert arm.is_clear(rows[0], scene) is bool(clear[0])


def test_a_motion_is_clear_where_its_closest_approach_says_so(arm):
    rng = np.random.default_rng(8)
    starts = configurations(arm, 80, 8)
    ends = np.clip(starts + rng.normal(0, 0.3, starts.shape), arm.limits.lower, arm.limits.upper)
    room = [
        lt.PointCloud(scattered(3000), 0.01),
        shelf((0.5, 0.1, 0.4)),
        lt.Cylinder(0.1, 0.5, (-0.4, 0.3, 0.4), TURN),
        lt.Box((0.2, 0.1, 0.4), (0.4, -0.4, 0.5), TURN),
    ]
    verdicts = []
    for edge in np.stack([starts, ends], axis=1):
        report = arm.check(edge, lt.Scene(room, 0.02), tolerance=1e-4)
        motion = lt.JointTrajectory([0.0, 1.0], edge, joint_names=arm.joint_names)
        verdicts.append(arm.is_clear(motion, lt.Scene(room, 0.02)))
        room_left = report.obstacles.minimum_distance - 0.02
        if report.itself.first or room_left < -1e-6:
            assert not verdicts[-1]
        elif room_left > 3e-4 and not report.itself.first:
            assert verdicts[-1]
    assert 5 < sum(verdicts) < 75


def shelf(place):
    return mesh_of(*(lt.Box((0.3, 0.4, 0.02), (0, 0, z)) for z in (0, 0.3)), place=place)


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
    box = mesh_of(lt.Box((0.1, 0.4, 0.2), (-0.15, 0.0, 0.65)))
    steps = np.linspace(-0.5, 0.5, 21)
    grid = np.stack(np.meshgrid(steps, steps, steps), axis=-1).reshape(-1, 3) * (0.1, 0.4, 0.2)
    for there in (box, lt.PointCloud(grid, 0.012, (-0.15, 0.0, 0.65))):
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
    mesh = mesh_of(lt.Sphere(0.05, (0.2, 0.01, 0.2)))
    cloud = lt.PointCloud(mesh.vertices, 0.01)
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
    box = lt.Box(size, (0.02, 0.03, 0.3), TILT)
    mesh = mesh_of(lt.Box(size, np.zeros(3)), place=box.position, turn=TILT)
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

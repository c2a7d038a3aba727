"""The package's own calls of the core, on problems of a real size with plain answers.

Together they call every binding; test_bindings.py and fuzz.py record the calls and damage them.
"""

import numpy as np
import pytest
from motions import arch, ring

import leadthrough as lt
from leadthrough import _core as core, planning, preprocess, rotations, trajectories as tr
from leadthrough.arm import (
    DirectionTask,
    ElbowTask,
    IkOptions,
    JointLimitTask,
    JointState,
    ObstacleTask,
    PoseTask,
    PositionTask,
    PostureTask,
    TaskStack,
    resolve,
)
from leadthrough.motion_planning import connect_configurations
from leadthrough_studies.damped_least_squares import damped_inverse_kinematics, follow_path

HOME = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7])
U = np.linspace(0.0, 1.0, 40)
OBSTACLES = (
    lt.Sphere(0.05, (0.9, 0.1, 0.4)),
    lt.Box((0.1, 0.1, 0.1), (1.5, 0.0, 0.0)),
    lt.Capsule(0.1, 0.2, (0.0, 1.5, 0.0)),
    lt.PointCloud([[1.5, 0.0, 0.3], [1.5, 0.0, 0.4]], 0.02),
    lt.Mesh(
        [[2.0, 0, 0], [2, 1, 0], [2, 0, 1], [3, 0, 0]], [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]
    ),
)


def poses_of(panda):
    positions, orientations = panda.forward_kinematics(HOME + np.outer(0.2 * U, np.ones(7)))
    return lt.PoseTrajectory(2.0 * U, positions, rotations.align_signs(orientations))


def test_rotations_come_back():
    vectors = np.array([[0.1, 0.2, -0.3], [3.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    q = rotations.exp(vectors)
    np.testing.assert_allclose(rotations.log(q), vectors, atol=1e-12)
    np.testing.assert_allclose(
        rotations.lift(rotations.exp(np.outer(8.0 * U, [0, 0, 1])))[-1, 2], 8
    )
    again = rotations.from_matrix(rotations.to_matrix(q))
    assert rotations.distance(again, q).max() < 1e-7
    assert rotations.distance(rotations.mean(q[None, :1]), q[:1]).max() < 1e-7
    half = rotations.slerp(q[2:], q[1:2], [0.5])
    np.testing.assert_allclose(half, rotations.exp([[1.5, 0.0, 0.0]]), atol=1e-12)
    turning = np.tile([0.0, 0.0, 1.0], (40, 1))
    whole = rotations.integrate(U, turning, q[2])
    assert rotations.distance(whole[-1:], rotations.exp([[0.0, 0.0, 1.0]]))[0] < 1e-7
    product = rotations.left_jacobian(vectors) @ rotations.left_jacobian_inverse(vectors)
    np.testing.assert_allclose(product, np.tile(np.eye(3), (3, 1, 1)), atol=1e-9)


def test_an_arm_moves_as_its_derivatives_say():
    panda = lt.Arm.load("panda")
    rows = np.stack([HOME, HOME + 0.1])
    speeds = 0.1 * np.ones((2, 7))
    assert panda.jacobian(rows).shape == (2, 6, 7)
    ahead, behind = (panda.jacobian(HOME + sign * 1e-6 * speeds[0]) for sign in (1, -1))
    rate = (ahead - behind) / 2e-6
    np.testing.assert_allclose(panda.jacobian_derivative(HOME, speeds[0]), rate, atol=1e-6)
    assert panda.jacobian_second_derivative(rows, speeds, speeds).shape == (2, 6, 7)
    mass = panda.mass_matrix(HOME)
    still = panda.inverse_dynamics(HOME, np.zeros(7), np.zeros(7))
    moving = panda.inverse_dynamics(HOME, np.zeros(7), np.ones(7))
    np.testing.assert_allclose(moving - still, mass @ np.ones(7), atol=1e-9)
    laden = panda.with_payload(1.0).inverse_dynamics(HOME, np.zeros(7), np.zeros(7))
    assert np.abs(laden).max() > np.abs(still).max()


def test_postures_are_found_and_reach():
    panda = lt.Arm.load("panda")
    poses = poses_of(panda)
    position, orientation = panda.forward_kinematics(HOME)
    one = panda.inverse_kinematics(position, orientation, q0=HOME + 0.1)
    assert one.success
    assert panda.inverse_kinematics_all(position, orientation).success.all()
    assert damped_inverse_kinematics(panda, [position], [orientation], q0=HOME).success.all()
    many = poses.positions[::10], poses.orientations[::10]
    assert panda.inverse_kinematics_batch(*many, threads=2).success.all()
    assert damped_inverse_kinematics(panda, *many, q0=HOME).q.shape == (4, 7)
    freely = IkOptions(free=("rz",))
    assert panda.inverse_kinematics(position, orientation, q0=HOME, options=freely).success
    slowed = panda.follow(poses, q0=HOME)
    assert slowed.duration >= poses.duration
    strayed = panda.follow(poses, q0=HOME, on_rate_limit="deviate", deviation=(0.01, 0.05))
    assert strayed.duration == poses.duration
    exact = panda.follow(poses, q0=HOME, on_rate_limit="exceed_limits")
    damped = follow_path(panda, poses, q0=HOME)
    assert damped.position_error.max() < 0.05
    assert panda.path_report(exact, poses).position_error.max() < 1e-5
    elbow, _ = lt.Arm.load("panda", tip="panda_link4").forward_kinematics(slowed.positions[20, :4])
    trap = lt.Sphere(0.08, elbow)
    assert panda.check(panda.follow(poses, scene=[trap]), [trap]).ok


def test_priorities_are_kept():
    panda = lt.Arm.load("panda")
    position, orientation = panda.forward_kinematics(HOME)
    stack = TaskStack(
        panda,
        [
            JointLimitTask(),
            *(ObstacleTask(shape, 0.05) for shape in OBSTACLES),
            PoseTask(position + np.array([0.0, 0.01, 0.0]), orientation),
            ElbowTask("panda_link4", 0.5),
            PostureTask(HOME),
        ],
    )
    assert np.isfinite(stack.solve(HOME).motion).all()
    assert np.isfinite(stack.solve_acceleration(HOME, np.zeros(7)).motion).all()
    assert len(stack.run(HOME, duration=0.01, dt=1e-3).trajectory.times) == 11
    aimed = [PositionTask(position), DirectionTask((0, 0, 1), (0, 0, -1))]
    coned = [PositionTask(position), DirectionTask((0, 0, 1), (0, 0, -1), within=0.3)]
    for tasks in (aimed, coned):
        assert np.isfinite(TaskStack(panda, tasks).solve(HOME).motion).all()
    np.testing.assert_allclose(resolve([np.eye(2)], [np.ones(2)]), 1.0, atol=1e-6)
    after = lt.DifferentialIk(panda, dt=0.01).step(
        JointState(HOME, np.zeros(7)), position, orientation
    )
    np.testing.assert_allclose(panda.forward_kinematics(after.q)[0], position, atol=1e-4)


def test_collisions_are_seen():
    panda = lt.Arm.load("panda")
    followed = panda.follow(poses_of(panda), q0=HOME)
    report = panda.check(followed, OBSTACLES)
    assert report.minimum_distance <= panda.distance(HOME, OBSTACLES) + 1e-9
    assert panda.self_distance(HOME) > 0.0
    assert panda.is_clear(followed, OBSTACLES) == report.ok
    away = HOME + 0.3
    np.testing.assert_array_equal(connect_configurations(panda, HOME, away)[[0, -1]], [HOME, away])
    assert "<iframe" in lt.show.inline(panda, followed)._repr_html_()
    pair = lt.DualArm(panda, panda, base=((0.0, 1.5, 0.0), (1.0, 0.0, 0.0, 0.0)))
    assert pair.check(np.tile(HOME, (2, 2))).ok


def test_waves_and_ways():
    speed = np.ones((20, 15))
    speed[8:12, 5:10] = 0.0
    grid = lt.Grid((0.0, 0.0), 1.0, speed.shape)
    for dtype in (np.float32, np.float64):
        for order in (1, 2):
            times = lt.arrival_times(speed, [(2, 2)], dtype=dtype, order=order)
            assert np.isinf(times[9, 7])
        both = planning.arrival_times_batch(np.stack([speed] * 2), [[(2, 2)]] * 2, dtype=dtype)
        np.testing.assert_array_equal(both[0], both[1])
        field = planning.ArrivalField(speed, grid, (2.0, 2.0), dtype=dtype)
        field.update(np.maximum(speed, 0.5))
        assert np.isfinite(field.times).all()
    path = planning.descend(times, grid, (17.0, 12.0), (2.0, 2.0))
    np.testing.assert_allclose(path[-1], (2.0, 2.0))
    heading = planning.direction(times, grid, [(17.0, 12.0)])
    np.testing.assert_allclose(np.linalg.norm(heading), 1.0)
    labels = planning.nearest_sources(speed, [(2, 2), (17, 12)])
    assert set(np.unique(labels)) >= {0, 1}
    assert planning.distance_transform(speed == 0.0)[0, 0] > 5.0


def test_primitives_end_at_their_goals():
    shown = [
        lt.Trajectory(U, np.column_stack([U + 0.1 * i * U**2, np.sin(3.0 * U)])) for i in (0, 1, 2)
    ]
    steered = (
        lt.DMP(weights=10).fit(shown[:1]).generate(obstacles=[lt.Sphere(0.05, (0.5, 0.9, 0.0))])
    )
    np.testing.assert_allclose(steered.positions[-1], shown[0].positions[-1], atol=1e-6)
    poses = poses_of(lt.Arm.load("panda"))
    skill = lt.DMP(weights=10).fit([poses])
    turn = rotations.exp([[0.0, 0.0, 0.2]])
    goal = poses.positions[-1] + 0.05, rotations.compose(turn, poses.orientations[-1:])[0]
    made = skill.generate(goal=goal)
    assert rotations.distance(made.orientations[-1:], goal[1][None])[0] < 1e-3
    state = skill.step(skill.step(skill.begin(), 0.5), 0.01, goal=goal)
    state = skill.step(state, 0.01, measured=(poses.positions[0], poses.orientations[0]))
    assert 0.0 < state.phase < 1.0
    state = skill.step(skill.step(state, 0.01), 0.01, obstacles=[lt.Sphere(0.05, (9, 9, 9))])
    for kind in ("points", "poses"):
        rhythm = lt.RhythmicDMP(weights=10).fit([ring(kind)])
        swung = rhythm.step(rhythm.begin(), 0.1, coupling=(0.0,) * len(ring(kind).positions[0]))
        np.testing.assert_allclose(swung.position, rhythm.step(rhythm.begin(), 0.1).position)
    line = lt.DMP(weights=10).fit([arch("joints")])
    bounds = -np.ones(3), np.ones(3)
    state = line.step(line.step(line.begin(), 0.1), 0.1, goal=(0.3, 0.1, 0.0))
    assert line.step(state, 0.1, limits=bounds).phase > state.phase
    family = lt.ProMP(weights=8).fit(shown)
    via = family.condition(0.5, (0.5, 1.0), covariance=1e-6 * np.eye(2)).generate(dt=0.5)
    np.testing.assert_allclose(via.positions[1], (0.5, 1.0), atol=1e-2)
    for drawn in family.within((-9.0, -9.0), (1.1, 9.0)).sample(2, seed=0):
        assert drawn.positions[:, 0].max() <= 1.1 + 1e-6
    assert len(lt.ProMP(weights=8, basis="bspline").fit(shown).sample(2, seed=0)) == 2
    arches, ball = (
        [arch("points", shift) for shift in (-0.02, 0.0)],
        lt.Sphere(0.03, (0.15, 0.1, 0.0)),
    )
    for settings in ({}, {"method": "map"}, {"method": "map", "obstacle_map": "minimum"}):
        skill = lt.FastMarching(**settings).fit(arches)
        for made in (skill, skill.preview()):
            around = np.pad(made.generate(obstacles=[ball]).positions, ((0, 0), (0, 1)))
            assert ball.distance(around).min() > 0.0
    policy = skill.policy_to()
    place = arches[0].positions[5]
    moved = policy.step(place, 1e-3) - place
    np.testing.assert_allclose(moved, 1e-3 * policy(place), rtol=1e-6)


def test_curves_are_compared_and_timed():
    a, b = (np.column_stack([U, offset + 0.0 * U]) for offset in (0.0, 1.0))
    assert preprocess.dtw_distance(a, b) == pytest.approx(40.0)
    assert preprocess.frechet_distance(a, b) == pytest.approx(1.0)
    pair = [lt.Demonstration(lt.Trajectory(U, each)) for each in (a, b)]
    assert len(preprocess.align_by_time_warping(pair)) == 2
    limits = lt.Arm.load("panda").limits
    line = HOME + np.outer(0.2 * U, np.ones(7))
    bent = line + 0.01 * np.sin(9.0 * U)[:, None] * np.arange(7)
    for tolerance in (1e-5, 1e-2):
        timed = lt.retime(lt.JointTrajectory(U, bent), limits, rate=100, path_tolerance=tolerance)
        assert lt.check_limits(timed, limits).ok
        assert lt.timing.binding_limits(timed, limits)
    assert lt.retime(line, limits, rate=100).duration > 0.0
    assert lt.keep_timing(lt.JointTrajectory(U, bent), limits, rate=100).duration > 0.0
    jerky = tr.JerkFilter(1.0, 2.0, 10.0)
    state = tr.FilterState(np.zeros(2), np.zeros(2), np.zeros(2))
    for step in (jerky.step, jerky.step_together):
        assert (step(state, np.ones(2), 0.01).position >= 0.0).all()
    assert (jerky.durations(state, np.ones(2)) > 0.0).all()
    np.testing.assert_allclose(jerky.resting_place(state), 0.0)


def test_curves_end_at_their_points():
    points = np.column_stack([U, U**2])
    turns = rotations.exp(np.outer(U, [0.0, 0.0, 1.0]))
    for curve in (tr.Bezier(points[:4]), tr.natural_cubic(U, points)):
        assert np.isfinite(curve.evaluate(0.5)).all()
    np.testing.assert_allclose(tr.Slerp(U, turns).evaluate(1.0), turns[-1])


def test_a_guard_slows_what_is_too_fast_and_stops_before_a_wall():
    panda, rise = lt.Arm.load("panda"), tr.minimum_jerk_time_scaling(U)[1:, None]
    wall = lt.Box([0.02, 2.0, 2.0], [0.6, 0.0, 0.5])
    forwards, aside = np.array([0.0, 0.8, 0.0, 0.4, 0.0, 0.0, 0.0]), np.linspace(0.4, 2.0, 7)
    ways = ((4.0, rise * forwards), *((100.0, part * U[1:, None] * aside) for part in (0.25, 1.0)))
    for rate, ahead in ways:
        answer = lt.Guard(panda, [wall], rate=rate).admit(HOME + ahead, HOME)
        assert panda.check(answer.motion, [wall]).ok
    chunks = lt.guard.Chunks(lt.Guard(panda, rate=100.0), rate=10.0)
    chunks.start(HOME)
    chunks.put(HOME + rise[:5] * aside, 0.0)
    assert np.abs(chunks.next().q - HOME).max() < 1e-3


def test_rows_of_numbers_are_written_and_read():
    layout = core.RecordLayout(["<", "|", ">"], [2, 1], ";", 1)
    rows = np.array([[0.1, -1e-5, 3.0], [1e300, 2.0, -4.0]])
    text = core.write_records(rows, layout)
    assert text == b"<0.1;-1.0e-05|3><1.0e+300;2.0|-4>"
    values, length = core.read_records(text + b"<1;2|x>", layout)
    assert np.array_equal(values.reshape(-1, 3), rows)
    assert length == len(text)


def test_a_simulated_arm_moves_as_commanded():
    panda, rise = lt.Arm.load("panda"), tr.minimum_jerk_time_scaling(U)[:, None]
    motion = lt.JointTrajectory(U, HOME + rise * np.linspace(0.1, 0.3, 7))
    pushes = [lt.simulation.Push(0.5, (0.0, 1.0, 0.0))]
    for each in ((), pushes):  # by a law of the core, and by one of Python
        disturbances = lt.simulation.Disturbances(pushes=each)
        report = lt.simulate(panda, motion, disturbances=disturbances, rate=100.0)
        assert np.abs(report.errors).max() < 0.02
    real = lt.simulation.SimulatedArm(panda, HOME, rate=100.0)
    still = np.zeros(7)
    for _ in range(5):
        real.step(lt.guard.CommandedState(HOME, still, still))
    assert np.abs(real.q - HOME).max() < 1e-3 < np.abs(real.torques).max()
    assert real.time == 0.05
    assert np.abs(real.demanded - real.torques).max() < 1.0

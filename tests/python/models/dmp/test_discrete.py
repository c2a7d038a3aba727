"""Movement primitives of points and joints: replay, goals, steps, obstacles, limits."""

import numpy as np
import pytest
from hypothesis import given, strategies as st
from motions import minimum_jerk
from refusals import raised, refused
from scipy.integrate import solve_ivp

import leadthrough as lt
from leadthrough.errors import FitError, NoPath, UnsupportedQuery

FORMS = ("blended", "hoffmann", "ijspeert")
RATE, DECAY = 12.5, -np.log(0.01)  # alpha = 25 = 4 beta; the canonical state ends at 1 %
POINTS = st.tuples(*[st.floats(-5.0, 5.0)] * 3)


def hook(*, samples=400, duration=2.0, noise=0.0):
    t = np.linspace(0.0, duration, samples)
    s = minimum_jerk(t / duration)
    points = np.column_stack([0.3 * s, 0.1 * np.sin(2.5 * s), 0.2 * s**2 + 0.05 * np.sin(6 * s)])
    points += np.random.default_rng(0).normal(0.0, noise, points.shape)
    return lt.Trajectory(t, points)


def fitted(motion=None, **settings):
    return lt.DMP(**settings).fit([motion or hook()])


SKILL = fitted()
HOFFMANN, IJSPEERT = fitted(form="hoffmann"), fitted(form="ijspeert")


@pytest.mark.parametrize("form", FORMS)
def test_replay_is_the_demonstration(form):
    shown = hook()
    made = fitted(form=form).generate(dt=2.0 / 399)
    np.testing.assert_allclose(made.times, shown.times, atol=1e-12)
    np.testing.assert_allclose(made.positions, shown.positions, atol=2e-6)


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize("after", [0.3, 1.95, 3.0])
def test_a_goal_that_moves_underway_is_reached_whichever_way_it_moves(side, after):
    state = SKILL.step(SKILL.begin(), after)
    goal = hook().positions[-1] + side * np.array([0.1, 0.2, 0.3])
    state = SKILL.step(state, 0.01, goal=goal)
    np.testing.assert_allclose(SKILL.step(state, 2.0).position, goal, atol=1e-6)


def test_a_goal_that_moves_after_the_end_is_approached_without_haste():
    state = SKILL.step(SKILL.begin(), 1.5 * SKILL.duration)
    state = SKILL.step(state, 0.01, goal=np.add(state.position, (0.1, 0.0, 0.0)))
    fastest = 0.0
    for _ in range(100):
        state = SKILL.step(state, 0.01)
        fastest = max(fastest, np.linalg.norm(state.velocity))
    # 0.1 m of minimum jerk in at least three tenths of the motion's duration.
    assert fastest <= 1.875 * 0.1 / (0.3 * SKILL.duration) * 1.01


@pytest.mark.parametrize(("regression", "error"), [("ridge", 1e-5), ("lwr", 2.5e-3)])
def test_fits_of_the_literature_come_close(regression, error):
    made = fitted(regression=regression).generate(dt=2.0 / 399)
    np.testing.assert_allclose(made.positions, hook().positions, atol=error)


def test_noise_is_not_learned():
    made = fitted(hook(samples=100, noise=1e-3)).generate(dt=2.0 / 399)
    error = np.linalg.norm(made.positions - hook().positions, axis=1)
    assert error.mean() < 1.2e-3
    by_force = fitted(hook(samples=100, noise=1e-3), regression="lwr").generate(dt=2.0 / 399)
    assert np.linalg.norm(by_force.positions - hook().positions, axis=1).mean() > error.mean()


@given(POINTS, POINTS)
def test_any_goal_is_reached_from_any_start(start, goal):
    made = SKILL.generate(start=start, goal=goal)
    np.testing.assert_allclose(made.positions[0], start, atol=1e-12)
    np.testing.assert_allclose(made.positions[-1], goal, atol=1e-12)


@pytest.mark.parametrize("form", FORMS)
@given(goal=POINTS)
def test_springs_converge_to_the_goal_after_the_end(form, goal):
    skill = fitted(form=form)
    state = skill.step(skill.begin(goal=goal), 40.0)
    np.testing.assert_allclose(state.position, goal, atol=1e-9)
    np.testing.assert_allclose(state.velocity, 0.0, atol=1e-9)


@given(start=POINTS, goal=POINTS)
def test_forms_of_the_literature_end_as_near_the_goal_as_they_say(start, goal):
    for skill, lacking, later in ((HOFFMANN, 0.026, 3e-4), (IJSPEERT, 1e-4, 1e-4)):
        ends = skill.system.ends
        moved = np.linalg.norm(start - ends.start) + np.linalg.norm(goal - ends.goal)
        made = skill.generate(start=start, goal=goal, dt=0.5)
        assert np.linalg.norm(made.positions[-1] - goal) <= lacking * moved + 1e-4
        after = skill.step(skill.begin(start=start, goal=goal), 1.5 * skill.duration)
        assert np.linalg.norm(after.position - goal) <= later * moved + 1e-4


@given(POINTS, st.floats(0.1, 10.0), st.integers(0, 2**32 - 1))
def test_frame_and_scale_do_not_matter(shift, scale, seed):
    axis = np.random.default_rng(seed).normal(size=(1, 3))
    turn = scale * lt.rotations.to_matrix(lt.rotations.exp(axis))[0]
    shown = hook()
    moved = fitted(lt.Trajectory(shown.times, shown.positions @ turn.T + shift))
    start, goal = np.array([0.1, 0.0, -0.1]), np.array([0.4, 0.2, 0.0])
    there = moved.generate(start=turn @ start + shift, goal=turn @ goal + shift).positions
    here = SKILL.generate(start=start, goal=goal).positions
    np.testing.assert_allclose(there, here @ turn.T + shift, atol=1e-6)


@pytest.mark.parametrize("form", FORMS)
def test_slower_motion_has_the_same_shape(form):
    skill = fitted(form=form)
    quick = skill.generate(dt=0.01)
    slow = skill.generate(duration=2.0 * skill.duration, dt=0.02)
    np.testing.assert_allclose(slow.times, 2.0 * quick.times, atol=1e-12)
    np.testing.assert_allclose(slow.positions, quick.positions, atol=1e-12)


def test_motion_does_not_depend_on_the_step():
    fine, coarse = SKILL.generate(dt=0.001), SKILL.generate(dt=0.1)
    np.testing.assert_allclose(fine.positions[::100], coarse.positions, atol=1e-12)


@pytest.mark.parametrize("form", FORMS)
def test_steps_lead_where_generate_does(form):
    skill = fitted(form=form)
    goal = (0.5, 0.1, 0.0)
    made = skill.generate(goal=goal, duration=3.0, dt=0.03)
    state = skill.begin(goal=goal, duration=3.0)
    for position in made.positions[1:]:
        state = skill.step(state, 0.03)
        np.testing.assert_allclose(state.position, position, atol=1e-9)


def springs_of_the_paper(skill, phases, *, drive, gain):
    """The literature's equation, by SciPy: y'' = alpha (beta (g - y) - y') + force."""
    ends, kernels = skill.system.ends, skill.system.kernels
    features = kernels.features().T

    def rates(u, y):
        x = np.exp(-DECAY * u)
        row = [np.interp(u, kernels.phases, f) for f in features]
        force = gain * (row @ skill.system.weights) + drive * x
        return [*y[3:], *(2 * RATE * (0.5 * RATE * (ends.goal - y[:3]) - y[3:]) + force)]

    first = [*ends.start, *ends.start_slope]
    return solve_ivp(rates, (0, 1), first, t_eval=phases, rtol=1e-8, atol=1e-10).y[:3].T


def test_forms_of_the_literature_obey_their_equations():
    phases = np.linspace(0.0, 1.0, 11)
    for form in ("hoffmann", "ijspeert"):
        skill = fitted(form=form, weights=10)
        distance = skill.system.ends.goal - skill.system.ends.start
        drive, gain = (-(RATE**2) * distance, 1.0) if form == "hoffmann" else (0.0, distance)
        truth = springs_of_the_paper(skill, phases, drive=drive, gain=gain)
        made = skill.generate(duration=1.0, dt=0.1)
        np.testing.assert_allclose(made.positions, truth, atol=1e-4)


def test_goal_scaling_scales_and_the_default_does_not():
    shown = hook()
    goal = 2.0 * shown.positions[-1] - shown.positions[0]
    scaled = fitted(form="ijspeert").generate(goal=goal, dt=2.0 / 399).positions
    np.testing.assert_allclose(scaled, 2.0 * shown.positions, atol=1e-5)
    plain = SKILL.generate(goal=goal, duration=2.0, dt=2.0 / 399).positions
    assert np.abs(plain - scaled).max() > 0.01


def test_goal_scaling_needs_a_distance():
    closed = lt.Trajectory([0.0, 1.0, 2.0], [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0]])
    assert "channel 1" in str(raised(FitError, fitted, closed, form="ijspeert"))
    assert fitted(closed).generate().positions[-1] == pytest.approx([1.0, 0.0])


def test_velocities_at_both_ends_are_met():
    v0, v1 = np.array([0.1, -0.2, 0.3]), np.array([0.0, 0.4, 0.0])
    made = SKILL.generate(start_velocity=v0, final_velocity=v1, duration=4.0, dt=1e-5)
    steps = np.diff(made.positions, axis=0) / 1e-5
    np.testing.assert_allclose(steps[0], v0, atol=1e-3)
    np.testing.assert_allclose(steps[-1], v1, atol=1e-3)
    with pytest.raises(UnsupportedQuery, match="final_velocity"):
        fitted(form="hoffmann").generate(final_velocity=v1)


@pytest.mark.parametrize("form", FORMS)
def test_via_points_are_passed_in_time(form):
    via = [(0.25, (0.1, 0.2, 0.0)), (0.5, (0.2, 0.3, 0.1))]
    made = fitted(form=form).generate(via=via, goal=(0.5, 0.0, 0.0), duration=4.0, dt=0.01)
    for share, point in via:
        np.testing.assert_allclose(made.positions[int(400 * share)], point, atol=1e-9)
    steps = np.diff(made.positions, n=2, axis=0)
    assert np.abs(np.diff(steps, axis=0)).max() < 1e-4


def test_goal_that_jumps_moves_neither_position_nor_velocity_at_once():
    before = SKILL.step(SKILL.begin(), 0.9)
    after = SKILL.step(before, 1e-9, goal=(1.0, 1.0, 1.0))
    np.testing.assert_allclose(after.position, before.position, atol=1e-6)
    np.testing.assert_allclose(after.velocity, before.velocity, atol=1e-4)


def test_coupling_pushes_and_is_forgotten():
    state = free = SKILL.begin()
    for _ in range(50):
        state = SKILL.step(state, 0.01, coupling=(0.0, 0.0, 2.0))
        free = SKILL.step(free, 0.01)
    assert state.position[2] - free.position[2] > 0.01
    state = SKILL.step(state, 4.0)
    np.testing.assert_allclose(state.position, SKILL.system.ends.goal, atol=1e-9)


def test_lag_makes_the_motion_wait():
    waiting, free = SKILL.begin(), SKILL.begin()
    for _ in range(100):
        waiting = SKILL.step(waiting, 0.01, lag=1.0)
        free = SKILL.step(free, 0.005)
    assert waiting.phase == pytest.approx(0.25)
    np.testing.assert_allclose(waiting.position, free.position, atol=1e-12)


def test_motion_waits_for_a_held_arm_and_then_goes_on_as_fast_as_shown():
    """An arm that corrects its errors within 50 ms is held for a second in the middle."""
    state, arm, speeds = SKILL.begin(), SKILL.system.ends.start.copy(), []
    dt, held = 0.002, range(400, 900)
    for i in range(1600):
        before, gap = state, state.position - arm
        state = SKILL.step(state, dt, lag=float(1e5 * gap @ gap))
        speeds.append((state.phase - before.phase) / dt * SKILL.duration)
        if i not in held:
            arm = arm + (state.position - before.position) + 20.0 * dt * gap
    waiting, after = np.array(speeds[600:900]), np.array(speeds[1300:])
    assert waiting.max() < 0.05
    assert after.min() > 0.9
    assert state.phase == pytest.approx(1.1, abs=0.1)  # of 3.2 s, one was lost


def test_several_demonstrations_give_their_mean():
    shown = [hook(samples=n, duration=d) for n, d in ((300, 1.5), (400, 2.5))]
    skill = lt.DMP().fit(shown)
    assert skill.duration == 2.0
    made = skill.generate(dt=2.0 / 399)
    np.testing.assert_allclose(made.positions, hook().positions, atol=1e-5)


def test_two_samples_give_a_minimum_jerk_motion():
    made = fitted(lt.Trajectory([0.0, 1.0], [[0.0], [1.0]])).generate(dt=0.01)
    np.testing.assert_allclose(made.positions[:, 0], minimum_jerk(made.times), atol=1e-9)


def test_motions_with_more_detail_get_more_kernels():
    u = np.linspace(0.0, 1.0, 2500)

    def learned(turns, noise=0.0):
        wave = np.column_stack([np.sin(turns * u), np.cos(turns * u)])
        wave += noise * np.random.default_rng(0).normal(size=wave.shape)
        skill = lt.DMP(weights=None).fit([lt.Trajectory(60.0 * u, wave)])
        assert skill.system.weights.shape[0] == skill.model.weights
        off = np.linalg.norm(skill.generate(dt=60.0 / 2499).positions - wave, axis=1).max()
        return skill.model.weights, off

    assert learned(6.0)[0] == 50
    many, off = learned(300.0)
    assert many > 50 and off < 1e-3 * np.hypot(2.0, 2.0)
    assert learned(6.0, noise=0.05)[0] <= 100  # noise is no detail


TIMES = np.linspace(0.0, 2.0, 200)
S = minimum_jerk(TIMES / 2.0)
BOW = np.column_stack([0.4 * S, 0.05 * np.sin(np.pi * S), 0.2 + 0.0 * S])
BOWED = lt.DMP().fit([lt.Trajectory(TIMES, BOW)])
FLAT = lt.DMP().fit([lt.Trajectory(TIMES, BOW[:, :2])])
WALL = lt.Box((0.1, 0.1, 0.3), (0.2, 0.05, 0.2))  # its middle lies on the way


def shape_of(kind, seed):
    rng = np.random.default_rng(seed)
    middle = (rng.uniform(0.12, 0.28), rng.uniform(-0.05, 0.1), rng.uniform(0.15, 0.25))
    turn = lt.rotations.exp(rng.normal(size=(1, 3)))[0]
    if kind == "sphere":
        return lt.Sphere(rng.uniform(0.02, 0.08), middle)
    if kind == "box":
        return lt.Box(rng.uniform(0.02, 0.12, 3), middle, turn)
    if kind == "cylinder":
        return lt.Cylinder(rng.uniform(0.01, 0.05), rng.uniform(0.02, 0.1), middle, turn)
    return lt.Capsule(rng.uniform(0.01, 0.05), rng.uniform(0.0, 0.1), middle, turn)


@pytest.mark.parametrize("kind", ["sphere", "box", "capsule", "cylinder"])
@given(seed=st.integers(0, 2**32 - 1))
def test_obstacles_are_cleared_or_refused_and_the_goal_is_met(kind, seed):
    obstacle = shape_of(kind, seed)
    try:
        made = BOWED.generate(obstacles=[obstacle], dt=0.005)
    except NoPath as error:
        assert error.reason in {"not_cleared", "start_in_wall", "goal_in_wall"}
        return
    assert obstacle.distance(made.positions).min() > 0.0
    np.testing.assert_allclose(made.positions[[0, -1]], BOW[[0, -1]], atol=1e-9)


@pytest.mark.parametrize("kind", ["sphere", "box", "capsule", "cylinder"])
def test_one_obstacle_never_holds_the_motion_up(kind):
    for seed in range(100):
        obstacle = shape_of(kind, seed)
        made = BOWED.generate(obstacles=[obstacle], dt=0.01)
        assert obstacle.distance(made.positions).min() > 0.0


@pytest.mark.parametrize("turn", [np.pi, 2.0 * np.pi], ids=["half circle", "circle"])
def test_obstacles_on_a_curved_way_are_passed_too(turn):
    way = np.column_stack([0.2 - 0.2 * np.cos(turn * S), 0.2 * np.sin(turn * S)])
    skill = lt.DMP().fit([lt.Trajectory(TIMES, way)])
    length = np.linalg.norm(np.diff(way, axis=0), axis=1).sum()
    for middle in way[70:130:10]:
        obstacle = lt.Box((0.05, 0.1, 0.1), (*middle, 0.0), lt.rotations.exp([(0, 0, 0.5)])[0])
        made = skill.generate(obstacles=[obstacle], dt=0.01)
        assert np.linalg.norm(np.diff(made.positions, axis=0), axis=1).sum() < 1.5 * length


def test_flat_wall_across_the_way_is_passed():
    made = BOWED.generate(obstacles=[WALL], dt=0.005)
    assert WALL.distance(made.positions).min() > 0.004
    np.testing.assert_allclose(made.positions[-1], BOW[-1], atol=1e-9)


def test_drawings_pass_obstacles_in_their_plane():
    ball = lt.Sphere(0.06, (0.2, 0.05, 0.0))
    made = FLAT.generate(obstacles=[ball], dt=0.005)
    assert np.linalg.norm(made.positions - (0.2, 0.05), axis=1).min() > 0.06
    np.testing.assert_allclose(made.positions[-1], BOW[-1, :2], atol=1e-9)


def test_far_obstacles_hardly_matter():
    made = BOWED.generate(obstacles=[lt.Sphere(0.05, (0.2, 1.5, 0.2))], dt=0.01)
    np.testing.assert_allclose(made.positions, BOWED.generate(dt=0.01).positions, atol=1e-3)


def test_ends_in_an_obstacle_are_named():
    for reason, query in (
        ("start_in_wall", {"start": (0.2, 0.05, 0.2)}),
        ("goal_in_wall", {"goal": (0.2, 0.05, 0.2)}),
    ):
        assert raised(NoPath, BOWED.generate, obstacles=[WALL], **query).reason == reason


def test_tool_turns_as_shown_while_its_position_passes_an_obstacle():
    turned = lt.rotations.exp(np.outer(S, [0.0, 0.0, 2.0]))
    skill = lt.DMP().fit([lt.PoseTrajectory(TIMES, BOW, turned)])
    made = skill.generate(obstacles=[WALL], dt=0.005)
    assert WALL.distance(made.positions).min() > 0.004
    plain = skill.generate(dt=0.005)
    np.testing.assert_allclose(made.orientations, plain.orientations, atol=1e-12)


def test_steps_keep_clear_too():
    state = BOWED.begin()
    for _ in range(400):
        state = BOWED.step(state, 0.005, obstacles=[WALL])
        assert WALL.distance(state.position[None])[0] > 0.003
    assert np.linalg.norm(state.position - BOW[-1]) < 0.03
    state = BOWED.step(state, 4.0)
    np.testing.assert_allclose(state.position, BOW[-1], atol=1e-9)


@given(st.floats(0.012, 0.2), st.integers(1, 100))
def test_limits_are_kept(ceiling, milliseconds):
    lower, upper = (-1.0, -0.01, 0.0), (1.0, ceiling, 1.0)
    made = BOWED.generate(limits=(lower, upper), dt=0.001 * milliseconds)
    assert made.positions[:, 1].max() <= ceiling
    np.testing.assert_allclose(made.positions[-1], BOW[-1], atol=1e-9)


def test_joints_keep_limits_and_know_no_obstacles():
    joints = lt.JointTrajectory(TIMES, np.hstack([BOW, -BOW]))
    skill = lt.DMP().fit([joints])
    assert "obstacles" not in skill.supports
    limits = (np.full(6, -0.45), np.array([1.0, 0.03, 1.0, 1.0, 1.0, 1.0]))
    assert skill.generate(limits=limits).positions[:, 1].max() <= 0.03
    state = skill.begin()
    for _ in range(400):
        state = skill.step(state, 0.005, limits=limits)
        assert state.position[1] <= 0.03 + 1e-9
    assert "obstacles" in str(raised(UnsupportedQuery, skill.generate, obstacles=[WALL]))


def test_ends_outside_the_limits_are_refused_by_name():
    limits = ((-1.0, -1.0, 0.0), (0.3, 1.0, 1.0))
    refused("goal", BOWED.generate, limits=limits)
    refused("start", BOWED.generate, limits=limits, start=(0.5, 0.0, 0.5), goal=(0.0, 0.0, 0.5))

"""Movement primitives of points and joints."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from motions import minimum_jerk
from scipy.integrate import solve_ivp

import leadthrough as lt
from leadthrough.errors import FitError, UnsupportedQuery

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
    return lt.DMP(**settings).fit([lt.Demonstration(motion or hook())])


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


@pytest.mark.parametrize(("regression", "error"), [("ridge", 1e-5), ("lwr", 1e-2)])
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

    def rates(u, y):
        x = np.exp(-DECAY * u)
        row = [np.interp(u, kernels.phases, f) for f in kernels.features.T]
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
    assert (
        np.abs(SKILL.generate(goal=goal, duration=2.0, dt=2.0 / 399).positions - scaled).max()
        > 0.01
    )


def test_goal_scaling_needs_a_distance():
    closed = lt.Trajectory([0.0, 1.0, 2.0], [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0]])
    with pytest.raises(FitError, match="channel 1"):
        fitted(closed, form="ijspeert")
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


def test_moving_goal_is_followed():
    state = SKILL.begin()
    for i in range(200):
        state = SKILL.step(state, 0.01, goal=(0.3 + 0.002 * min(i, 100), 0.0, 0.2))
    assert np.linalg.norm(state.position - (0.5, 0.0, 0.2)) < 1e-3
    state = SKILL.step(state, 2.0)
    np.testing.assert_allclose(state.position, (0.5, 0.0, 0.2), atol=1e-6)


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
    skill = lt.DMP().fit([lt.Demonstration(motion) for motion in shown])
    assert skill.duration == 2.0
    made = skill.generate(dt=2.0 / 399)
    np.testing.assert_allclose(made.positions, hook().positions, atol=1e-5)


def test_joints_keep_names_and_velocities():
    shown = hook()
    joints = lt.JointTrajectory(shown.times, shown.positions, joint_names=("a", "b", "c"))
    made = fitted(joints).generate(dt=0.001)
    assert isinstance(made, lt.JointTrajectory)
    assert made.joint_names == ("a", "b", "c")
    differences = np.gradient(made.positions, made.times, axis=0)
    np.testing.assert_allclose(made.velocities[5:-5], differences[5:-5], atol=1e-3)


def test_two_samples_give_a_minimum_jerk_motion():
    made = fitted(lt.Trajectory([0.0, 1.0], [[0.0], [1.0]])).generate(dt=0.01)
    np.testing.assert_allclose(made.positions[:, 0], minimum_jerk(made.times), atol=1e-9)


@pytest.mark.parametrize(("duration", "count"), [(3.0, 50), (20.0, 80), (1e4, 1000)])
def test_long_motions_get_as_many_kernels_as_they_ask_for(duration, count):
    model = lt.DMP(weights=None)
    times = np.linspace(0.0, duration, 2500)
    shown = lt.Trajectory(times, np.sin(times / duration * [[1.0], [2.0]]).T)
    skill = model.fit([lt.Demonstration(shown)])
    assert skill.model == lt.DMP(weights=count)
    assert skill.system.weights.shape[0] == count

"""Movement primitives of poses: hard rotations, steps, lifted orientations, moved ends."""

import numpy as np
import pytest
from hypothesis import given, strategies as st
from models.dmp.turns import (
    DURATION,
    FIXED,
    HARD,
    HARD_AT_50_HZ,
    WAVE,
    about_turning_axis,
    across,
    angle_turned,
    demonstration,
    errors_of,
    fitted,
    moved_goal,
    noisy,
    peak_speed,
    positions,
    turn,
    turned_by,
)

import leadthrough as lt
from leadthrough import rotations
from leadthrough.errors import FitError, UnsupportedQuery
from leadthrough.preprocess import segment


@pytest.mark.parametrize(
    ("case", "noise", "mean", "most"),
    [
        *((case, 0.0, 0.03, 0.3) for case in HARD.values()),
        (turn(350, 100), 0.05, 0.03, 0.3),
        *((case, 0.1, 0.2, 1.0) for case in HARD_AT_50_HZ.values()),
    ],
    ids=[*HARD, "light noise at 100 Hz", *(f"noise, {name}" for name in HARD_AT_50_HZ)],
)
def test_hard_rotations_are_replayed_with_their_noise_averaged_out(case, noise, mean, most):
    u, q = case
    error = errors_of(fitted(u, noisy(q, noise) if noise else q), u, q)
    assert error.mean() <= mean
    assert error.max() <= most


@pytest.mark.parametrize("rate", [50, 100])
@pytest.mark.parametrize("motion", [turn, about_turning_axis])
def test_anchored_takes_strong_noise_no_worse_than_lifted(motion, rate):
    """Noise of 0.05 rad at 50 Hz: 3.5 degrees against 2.0 when the curve follows the noise."""
    u, q = motion(90, rate)
    shaken = noisy(q, np.degrees(0.05))
    ours, theirs = (
        errors_of(fitted(u, shaken, orientation=name), u, q) for name in ("anchored", "lifted")
    )
    assert ours.mean() <= 1.02 * theirs.mean() <= 2.3
    assert ours.max() <= 1.05 * theirs.max()


@pytest.mark.parametrize("orientation", ["anchored", "lifted", "log", "euler"])
def test_small_rotations_are_replayed_by_every_representation(orientation):
    u, q = turn(60, 100)
    skill = fitted(u, q, orientation=orientation)
    assert errors_of(skill, u, q).max() < 0.1
    start, goal = moved_goal(q[:1], 10), moved_goal(q, 20)
    query = {"start": ((0, 0, 0), start), "goal": ((1, 0, 0), goal)}
    made = skill.generate(**query, duration=DURATION)
    ends = rotations.distance(made.orientations[[0, -1]], np.array([start, goal]))
    np.testing.assert_allclose(ends, 0.0, atol=1e-7)
    slow = skill.generate(**query, duration=2.0 * DURATION, dt=0.02)
    np.testing.assert_allclose(slow.orientations, made.orientations, atol=1e-12)
    np.testing.assert_allclose(slow.positions, made.positions, atol=1e-12)


def test_tool_that_only_turns_or_only_moves_is_learned():
    u, q = turn(120, 100)
    still = lt.PoseTrajectory(u, np.zeros((len(u), 3)), q)
    made = lt.DMP().fit([still]).generate()
    np.testing.assert_allclose(made.positions, 0.0, atol=1e-12)
    assert rotations.distance(made.orientations[-1:], q[-1:])[0] < 1e-7
    stiff = lt.PoseTrajectory(u, positions(u), np.repeat(q[:1], len(u), axis=0))
    made = lt.DMP().fit([stiff]).generate()
    assert angle_turned(made.orientations) < 1e-6


def test_several_demonstrations_give_their_mean():
    u, q = about_turning_axis(200, 100)
    spin = rotations.exp(np.radians([[0.0, 0.0, 10.0], [0.0, 0.0, -10.0]]))
    shown = [
        demonstration(u, rotations.compose(np.repeat(each[None], len(q), axis=0), q))
        for each in spin
    ]
    made = lt.DMP().fit(shown).generate(dt=DURATION / (len(u) - 1))
    assert np.degrees(rotations.distance(made.orientations, q)).max() < 0.01
    turned = rotations.compose(q, np.repeat([[0.0, 1.0, 0.0, 0.0]], len(q), axis=0))
    with pytest.raises(FitError, match="mean orientation"):
        lt.DMP().fit([shown[0], demonstration(u, turned)])


@pytest.mark.parametrize("trial", ["trial1.csv", "trial2.csv"])
def test_motions_of_a_real_robot_are_replayed(recordings, trial):
    columns = {
        "positions": [f"current_pos_{axis}" for axis in "xyz"],
        "orientations": [f"current_orientation_{axis}" for axis in "wxyz"],
    }
    path = recordings / "panda_execution" / trial
    recording = lt.read_motion(path, columns=columns, rate=20.0)
    motions = segment(recording)
    assert len(motions) > 30
    for shown in motions:
        motion = shown.motion
        # Two motions of 20 s have more to them than 50 kernels can say.
        skill = lt.DMP(weights=max(50, int(4 * motion.duration))).fit([shown])
        made = skill.generate(dt=motion.duration / (len(motion.times) - 1))
        gaps = np.linalg.norm(made.positions - motion.positions, axis=1)
        assert np.sqrt(np.mean(gaps**2)) <= 1e-3
        angles = rotations.distance(made.orientations, motion.orientations)
        assert np.degrees(angles).mean() <= 0.2


def test_a_long_motion_of_much_detail_is_replayed_with_as_many_kernels_as_it_asks_for():
    times = np.linspace(0.0, 20.0, 401)
    waves = np.column_stack([np.sin(2.0 * np.pi * f * times) for f in (0.3, 0.7, 1.1)])
    turned = rotations.exp(0.3 * waves)
    shown = lt.PoseTrajectory(times, 0.05 * waves, turned)
    away = []
    for weights in (50, None):
        made = lt.DMP(weights).fit([shown]).generate(dt=0.05)
        away.append(np.linalg.norm(made.positions - shown.positions, axis=1).max())
    assert away[1] < 0.2 * away[0]


@pytest.mark.parametrize("orientation", ["anchored", "lifted", "log", "euler"])
def test_steps_lead_where_generate_does(orientation):
    u, q = turn(120, 100)
    skill = fitted(u, q, orientation=orientation)
    query = {"goal": ((0.4, 0.1, 0.2), moved_goal(q, 20)), "duration": 3.0}
    made = skill.generate(**query, dt=0.03)
    state = skill.begin(**query)
    for position, turned in zip(made.positions[1:], made.orientations[1:], strict=True):
        state = skill.step(state, 0.03)
        np.testing.assert_allclose(state.position, position, atol=1e-9)
        assert rotations.distance(state.orientation[None], turned[None])[0] < 1e-7


@pytest.mark.parametrize("orientation", ["anchored", "lifted", "euler"])
def test_angular_velocity_is_the_derivative_of_the_orientation(orientation):
    u, q = about_turning_axis(150, 100)
    skill = fitted(u, q, orientation=orientation)
    state = skill.begin(start=((0, 0, 0), moved_goal(q[:1], 40)), duration=3.0)
    for _ in range(10):
        state = skill.step(state, 0.25)
        ahead = skill.step(state, 1e-5)
        step = rotations.compose(
            ahead.orientation[None], rotations.inverse(state.orientation[None])
        )
        np.testing.assert_allclose(rotations.log(step)[0] / 1e-5, state.angular_velocity, atol=2e-4)


def test_goal_that_moves_is_followed_and_changes_nothing_at_once():
    u, q = about_turning_axis(720, 100)
    skill = fitted(u, q)
    before = skill.step(skill.begin(), 2.0)
    goal = ((0.5, 0.0, 0.0), moved_goal(q, 90))
    after = skill.step(before, 1e-9, goal=goal)
    np.testing.assert_allclose(after.orientation, before.orientation, atol=1e-6)
    np.testing.assert_allclose(after.angular_velocity, before.angular_velocity, atol=1e-4)
    end = skill.step(after, 12.0)
    assert rotations.distance(end.orientation[None], goal[1][None])[0] < 1e-6
    np.testing.assert_allclose(end.position, goal[0], atol=1e-6)


def test_goal_that_turns_slowly_is_never_unwound():
    u, q = turn(90, 100)
    skill = fitted(u, q)
    state, turned = skill.begin(), 0.0
    for i in range(800):
        goal = rotations.compose(rotations.exp(np.radians([[0.0, 0.0, 0.6 * i]])), q[-1:])[0]
        after = skill.step(state, 0.01, goal=((0.3, 0.1, 0.2), goal))
        turned += rotations.distance(state.orientation[None], after.orientation[None])[0]
        state = after
    assert np.degrees(turned) < 800.0
    assert np.degrees(rotations.distance(state.orientation[None], goal[None]))[0] < 60.0


def test_measured_pose_is_where_the_motion_goes_on():
    u, q = about_turning_axis(720, 100)
    skill = fitted(u, q)
    state = skill.step(skill.begin(), 1.5)
    pushed = moved_goal(state.orientation[None], 25)
    after = skill.step(state, 1e-9, measured=(state.position + 0.05, pushed))
    assert rotations.distance(after.orientation[None], pushed[None])[0] < 1e-6
    np.testing.assert_allclose(after.position, state.position + 0.05, atol=1e-6)
    end = skill.step(after, 10.0)
    assert rotations.distance(end.orientation[None], q[-1:])[0] < 1e-6


def test_angular_coupling_turns_the_tool():
    u, q = turn(90, 100)
    skill = fitted(u, q)
    state = skill.step(skill.begin(), 1.0)
    pushed = skill.step(state, 1e-3, coupling=(0, 0, 0, 0, 0, 5.0))
    free = skill.step(state, 1e-3)
    gained = (pushed.angular_velocity - free.angular_velocity) / 1e-3
    np.testing.assert_allclose(gained, (0, 0, 5.0), atol=0.05)
    only_moved = skill.step(state, 1e-3, coupling=(1.0, 0.0, 0.0))
    np.testing.assert_allclose(only_moved.orientation, free.orientation, atol=1e-15)


@pytest.mark.parametrize("case", [turn(180, 1000), turn(200, 100), turn(720, 1000)])
def test_lifted_replays_turns_about_one_axis(case):
    assert errors_of(fitted(*case, orientation="lifted"), *case).max() < 0.3


def test_log_jumps_where_lifted_does_not():
    case = turn(200, 100)
    assert errors_of(fitted(*case, orientation="log", weights=50), *case).max() > 90.0


def test_lifted_refuses_what_it_cannot_follow():
    u, q = turn(350, 100)
    for case in (about_turning_axis(720, 100), (u, noisy(q, 0.05))):
        with pytest.raises(FitError, match="anchored"):
            fitted(*case, orientation="lifted")


@pytest.mark.parametrize("degrees", [170, 200, 350, 720])
@pytest.mark.parametrize("moved_by", [20, 90, 150])
def test_lifted_never_spins_silently(degrees, moved_by):
    u, q = turn(degrees, 100)
    skill = fitted(u, q, orientation="lifted")
    goal = ((0.3, 0.1, 0.2), moved_goal(q, moved_by))
    try:
        made = skill.generate(goal=goal)
    except UnsupportedQuery:
        assert degrees > 220
    else:
        assert abs(angle_turned(made.orientations) - degrees) <= moved_by + 21.0


def random_turn(rng):
    """Phases, orientations, and how far they turn: 20 to 700 degrees, about one axis or several."""
    degrees, rate = rng.uniform(20.0, 700.0), int(rng.choice([50, 100, 200]))
    u, q = (turn if rng.random() < 0.5 else about_turning_axis)(degrees, rate)
    return u, q, degrees


def random_pose(rng, q, position):
    """A pose turned from q (4,) by up to 179 degrees about any axis, and that angle."""
    moved_by, axis = rng.uniform(0.0, 179.0), rng.normal(size=3)
    return (position, turned_by(q, moved_by, axis / np.linalg.norm(axis))), moved_by


def assert_no_spin(made, degrees, moved_by):
    """That a motion turns as far as was shown, and no quicker than all its turns together."""
    assert abs(angle_turned(made.orientations) - degrees) <= moved_by + 25.0
    assert peak_speed(made) <= 2.0 * np.radians(1.875 * (degrees + moved_by) / DURATION)


@pytest.mark.parametrize("noise", [0.0, 0.05, 0.3])
def test_lifted_is_refused_or_does_not_spin_in_random_cases(noise):
    refused = 0
    for seed in range(60):
        rng = np.random.default_rng(seed)
        u, q, degrees = random_turn(rng)
        noisy = rotations.compose(q, rotations.exp(rng.normal(0, np.radians(noise), (len(q), 3))))
        start, back = random_pose(rng, q[0], (0.0, 0.0, 0.0))
        goal, forth = random_pose(rng, q[-1], (0.3, 0.1, 0.2))
        try:
            skill = fitted(u, noisy, orientation="lifted", weights=50)
            assert errors_of(skill, u, q).max() < 25.0
            assert_no_spin(skill.generate(goal=goal, dt=0.005), degrees, forth)
            assert_no_spin(skill.generate(start=start, goal=goal, dt=0.005), degrees, back + forth)
        except (FitError, UnsupportedQuery) as error:
            assert "anchored" in str(error)
            refused += degrees < 180.0
    assert refused <= 3  # of those below half a turn


def test_lifted_is_refused_or_does_not_spin_where_its_goal_moves_on_the_way():
    followed = 0
    for seed in range(60):
        rng = np.random.default_rng(seed)
        degrees = rng.uniform(20.0, 700.0)
        u, q = turn(degrees, 100)
        skill = fitted(u, q, orientation="lifted")
        goal, moved_by = random_pose(rng, q[-1], (0.3, 0.1, 0.2))
        state, rows = skill.step(skill.begin(), rng.uniform(0.2, 3.0)), []
        try:
            state = skill.step(state, 1e-6, goal=goal)
        except UnsupportedQuery as error:
            assert "anchored" in str(error)
            continue
        while state.phase < 1.0:
            rows.append(state.orientation)
            state = skill.step(state, 0.01)
        assert angle_turned(np.array(rows)) <= degrees + moved_by + 25.0
        followed += 1
    assert followed > 20


def test_noise_of_the_samples_is_no_turn_that_lifted_lacks():
    u, q = turn(120, 600)
    noise = np.random.default_rng(0).normal(0.0, np.radians(0.1), (len(u), 3))
    noisy = rotations.compose(q, rotations.exp(noise))
    assert angle_turned(noisy) > 180
    made = fitted(u, noisy, orientation="lifted").generate()
    assert angle_turned(made.orientations) == pytest.approx(120, abs=2)


@pytest.mark.parametrize(("moved_by", "quicker"), [(20, 1.15), (90, 1.3)])
@pytest.mark.parametrize(
    ("case", "noise"),
    [*((case, 0.0) for case in (*HARD.values(), *HARD_AT_50_HZ.values())), (turn(350, 100), 0.05)],
    ids=[*HARD, *HARD_AT_50_HZ, "noisy"],
)
def test_goal_turned_off_the_axis_is_reached_without_a_spin(case, noise, moved_by, quicker):
    u, q = case
    skill, shown = fitted(u, noisy(q, noise) if noise else q), demonstration(u, q)
    for axis in across(FIXED, 12):
        goal = turned_by(q[-1], moved_by, axis)
        made = skill.generate(goal=((0.5, 0.0, 0.3), goal), dt=0.004)
        assert np.degrees(rotations.distance(made.orientations[-1:], goal[None]))[0] < 1e-6
        np.testing.assert_allclose(made.positions[-1], (0.5, 0.0, 0.3), atol=1e-9)
        assert angle_turned(made.orientations) <= 1.02 * angle_turned(q) + moved_by
        assert peak_speed(made) <= quicker * peak_speed(shown)


@given(st.integers(0, 2**32 - 1), st.floats(1.0, 179.0), st.sampled_from([90, 200, 720]))
def test_speeds_of_a_motion_and_of_its_goal_add_up(seed, moved_by, degrees):
    """About any axis: at worst, along that of the motion, both peak together."""
    u, q = turn(degrees, 100)
    axis = np.random.default_rng(seed).normal(size=3)
    goal = turned_by(q[-1], moved_by, axis / np.linalg.norm(axis))
    made = fitted(u, q).generate(goal=((0.3, 0.1, 0.2), goal))
    assert angle_turned(made.orientations) <= 1.001 * degrees + moved_by
    together = np.radians(1.875 * (degrees + moved_by) / DURATION)
    # The progress of 100 samples, by which the goal moves, peaks at up to 0.4 % more.
    assert peak_speed(made) <= 1.005 * together


@pytest.mark.parametrize("degrees", [170, 350, 720])
def test_start_turned_off_the_axis_is_left_without_a_spin(degrees):
    u, q = turn(degrees, 100)
    start = moved_goal(q[:1], 60)
    made = fitted(u, q).generate(start=((0.0, 0.1, 0.0), start))
    np.testing.assert_allclose(
        rotations.distance(made.orientations[[0]], start[None]), 0, atol=1e-9
    )
    np.testing.assert_allclose(rotations.distance(made.orientations[[-1]], q[-1:]), 0, atol=1e-9)
    assert angle_turned(made.orientations) <= 1.02 * degrees + 60


def unit_quaternions(seed, count=1):
    q = np.random.default_rng(seed).normal(size=(count, 4))
    return q / np.linalg.norm(q, axis=1)[:, None]


@given(st.integers(0, 2**32 - 1), st.floats(0.5, 20.0))
def test_any_pose_is_reached_from_any_pose(seed, duration):
    start, goal = unit_quaternions(seed, 2)
    made = WAVE.generate(
        start=((1.0, 0.0, 0.0), start), goal=((0.0, 1.0, 0.0), goal), duration=duration, dt=0.1
    )
    ends = rotations.distance(made.orientations[[0, -1]], np.array([start, goal]))
    np.testing.assert_allclose(ends, 0.0, atol=1e-7)
    np.testing.assert_allclose(made.positions[[0, -1]], [(1, 0, 0), (0, 1, 0)], atol=1e-9)
    assert made.duration == pytest.approx(duration)


@given(st.integers(0, 2**32 - 1))
def test_frame_does_not_matter(seed):
    frame = unit_quaternions(seed)
    u, q = about_turning_axis(720, 50)
    turned = rotations.compose(np.repeat(frame, len(q), axis=0), q)
    goal = moved_goal(q, 30)
    here = fitted(u, q, weights=15).generate(goal=(positions(u)[-1], goal))
    there = fitted(u, turned, weights=15).generate(
        goal=(positions(u)[-1], rotations.compose(frame, goal[None])[0])
    )
    expected = rotations.compose(np.repeat(frame, len(here.times), axis=0), here.orientations)
    assert rotations.distance(there.orientations, expected).max() < 1e-7


@given(st.integers(0, 2**32 - 1))
def test_motion_turned_as_a_whole_is_the_motion_in_another_frame(seed):
    """Also by half a turn, whose axis a rule chooses: start and goal choose the same."""
    frame = unit_quaternions(seed)
    if seed % 2:
        frame[0, 0] = 0.0
        frame /= np.linalg.norm(frame)
    plain = WAVE.generate()
    ends = rotations.compose(np.repeat(frame, 2, axis=0), plain.orientations[[0, -1]])
    made = WAVE.generate(start=(plain.positions[0], ends[0]), goal=(plain.positions[-1], -ends[1]))
    expected = rotations.compose(np.repeat(frame, len(plain.times), axis=0), plain.orientations)
    assert rotations.distance(made.orientations, expected).max() < 1e-7


def test_signs_of_quaternions_do_not_matter():
    u, q = about_turning_axis(720, 100)
    flips = np.where(np.random.default_rng(2).random(len(q)) < 0.5, -1.0, 1.0)[:, None]
    raw = demonstration(u, flips * q)
    made = lt.DMP().fit([raw]).generate(goal=((0.3, 0.1, 0.2), -q[-1]))
    expected = fitted(u, q).generate(goal=((0.3, 0.1, 0.2), q[-1]))
    assert rotations.distance(made.orientations, expected.orientations).max() < 1e-12

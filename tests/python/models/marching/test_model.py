"""Fast Marching Learning: paths, obstacles, timing and bad input."""

import numpy as np
import pytest
from hypothesis import given, strategies as st
from models.marching.paths import gaps_to
from motions import minimum_jerk
from refusals import refused

import leadthrough as lt
from leadthrough.errors import NoPath
from leadthrough.preprocess import by_arc_length
from leadthrough_studies import metrics


def wave(amplitude=0.05, *, count=200, duration=2.0, shift=0.0, scale=1.0):
    """One arch of a sine over 0.4 m, covered in minimum-jerk time."""
    t = np.linspace(0.0, 1.0, count)
    u = minimum_jerk(t)
    points = np.column_stack([0.4 * u, amplitude * np.sin(2 * np.pi * u) + shift * (1 - u)])
    return lt.Demonstration(lt.Trajectory(duration * t, scale * points))


def on_table(motion):
    return np.column_stack([motion.positions, np.zeros(len(motion.times))])


@pytest.fixture(scope="module")
def skill():
    return lt.FastMarching().fit([wave(shift=shift) for shift in (-0.01, 0.0, 0.01)])


def test_reproduction_stays_in_the_tube_of_a_single_demonstration():
    shown = wave()
    skill = lt.FastMarching().fit([shown])
    motion = skill.generate()
    off = gaps_to(shown.motion.positions, motion.positions)
    assert off.max() < skill.area_of_influence


def test_motion_starts_and_ends_at_rest_and_is_smooth(skill):
    motion = skill.generate(dt=0.01)
    velocity = np.diff(motion.positions, axis=0) / np.diff(motion.times)[:, None]
    speed = np.linalg.norm(velocity, axis=1)
    assert speed[[0, -1]].max() < 0.02 * speed.max()
    steps = np.linalg.norm(np.diff(velocity, axis=0), axis=1)
    assert steps.max() < 0.1 * speed.max()


def test_path_goes_around_a_box_and_keeps_the_area_of_influence(skill):
    box = lt.Box((0.03, 0.03, 0.1), (0.2, 0.0, 0.0))
    motion = skill.generate(obstacles=[box])
    assert box.distance(on_table(motion)).min() > 0.5 * skill.area_of_influence
    assert box.distance(on_table(skill.generate())).min() < 0.0


def test_a_small_ball_moves_the_path_only_near_itself():
    x = np.linspace(0.0, 1.0, 101)
    shown = [np.column_stack([x, bow * np.sin(np.pi * x)]) for bow in (-0.01, 0.0, 0.01)]
    skill = lt.FastMarching(
        area_of_influence=0.1, saturation=0.1, resolution=0.01, method="mean_path"
    ).fit([lt.Trajectory(2.0 * x, rows) for rows in shown])
    path = skill.generate(obstacles=[lt.Sphere(0.03, [0.5, 0.01, 0.0])]).positions
    assert np.abs(path[:, 1]).max() > 0.03
    assert np.abs(path[path[:, 0] < 0.25, 1]).max() < 1.5e-3  # a seventh of a cell


def test_three_dimensions_work_like_two():
    shown = wave().motion
    lifted = np.column_stack([shown.positions, 0.1 * shown.positions[:, 0]])
    skill = lt.FastMarching(resolution=0.006, area_of_influence=0.015).fit(
        [lt.Trajectory(shown.times, lifted)]
    )
    sphere = lt.Sphere(0.02, lifted[100])
    motion = skill.generate(obstacles=[sphere])
    assert sphere.distance(motion.positions).min() > 0.0
    np.testing.assert_allclose(motion.positions[-1], lifted[-1], atol=1e-12)


def test_kappa_is_high_on_the_demonstrations_and_the_saturation_far_from_them(skill):
    assert skill.kappa(skill.generate().positions) > 0.6
    assert skill.kappa([[0.2, 0.12]]) == pytest.approx(skill.model.saturation)


def test_without_demonstrations_the_path_is_the_shortest_one():
    skill = lt.FastMarching().fit([])
    motion = skill.generate(start=(0.0, 0.0), goal=(0.3, 0.1), duration=1.0)
    across = np.array([-0.1, 0.3]) / np.hypot(0.3, 0.1)
    assert np.abs(motion.positions @ across).max() < 2e-3
    refused("duration", skill.generate, start=(0.0, 0.0), goal=(0.3, 0.1))
    refused("start", skill.generate, duration=1.0)


def test_demonstration_asked_for_backwards_is_followed_backwards():
    shown = wave()
    for method in ("auto", "map", "start", "mean_path"):
        skill = lt.FastMarching(method=method).fit([shown])
        path = shown.motion.positions
        back = skill.generate(start=path[-1], goal=path[0])
        assert gaps_to(path, back.positions).max() < 2 * skill.area_of_influence, method
        np.testing.assert_allclose(back.positions[[0, -1]], path[[-1, 0]], atol=1e-12)


def test_new_path_far_from_the_experience_is_auto_learned(skill):
    box = lt.Box((0.06, 0.06, 0.1), (0.2, 0.0, 0.0))
    detour = skill.generate(obstacles=[box])
    taught = skill.auto_learn(detour, threshold=0.99)
    assert len(taught.learned) == 1
    assert len(taught.experience) == len(skill.experience) + 1
    assert taught.kappa(detour.positions) > skill.kappa(detour.positions)
    assert skill.auto_learn(skill.generate(), threshold=0.5) is skill
    assert not skill.learned


def test_timing_follows_the_speed_map_or_is_constant_if_asked():
    shown = [wave(shift=shift) for shift in (-0.01, 0.01)]
    speeds = {}
    for timing in ("demonstrations", "speed_map", "constant"):
        motion = lt.FastMarching(timing=timing).fit(shown).generate()
        steps = np.linalg.norm(np.diff(motion.positions, axis=0), axis=1)
        speeds[timing] = steps[15:-15] / steps.mean()
    assert np.ptp(speeds["constant"]) < 0.02
    assert np.ptp(speeds["demonstrations"]) > 0.5
    assert np.ptp(speeds["speed_map"]) < np.ptp(speeds["demonstrations"])


def figure_eight(t):
    return np.column_stack([np.sin(2 * np.pi * t), 0.5 * np.sin(4 * np.pi * t)])


def crossing_spiral(t):
    radius = 0.3 + 0.7 * t
    centre = np.column_stack([0.9 * t, np.zeros_like(t)])
    angle = 4 * np.pi * t
    return centre + radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])


def double_loop(t):
    angle = 4 * np.pi * t
    return np.column_stack([2.0 * t + 0.5 * np.sin(angle), 0.5 * np.cos(angle)])


@pytest.mark.parametrize("curve", [figure_eight, crossing_spiral, double_loop])
def test_demonstration_that_crosses_itself_is_followed_through_the_crossing(curve):
    path = curve(np.linspace(0.0, 1.0, 600))
    skill = lt.FastMarching().fit([lt.Trajectory(np.arange(600.0) / 100.0, path)])
    made = skill.generate().positions
    length = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
    assert metrics.frechet_distance(by_arc_length(path, 500), by_arc_length(made, 500)) < (
        0.02 * length
    )


def pose_wave(shift=0.0):
    """The wave in space, the tool turning by one radian about the vertical on its way."""
    flat = wave(shift=shift).motion
    positions = np.column_stack([flat.positions, np.full(len(flat.times), 0.2)])
    angle = flat.positions[:, 0] / 0.4
    turned = lt.rotations.exp(np.outer(angle, [0.0, 0.0, 1.0]))
    return lt.Demonstration(lt.PoseTrajectory(flat.times, positions, turned))


@pytest.fixture(scope="module")
def pose_skill():
    return lt.FastMarching(area_of_influence=0.02).fit([pose_wave(s) for s in (-0.01, 0.01)])


def test_pose_demonstrations_give_poses_that_turn_along_the_path_as_shown(pose_skill):
    motion = pose_skill.generate()
    assert isinstance(motion, lt.PoseTrajectory)
    shares = motion.positions[:, 0] / 0.4
    expected = lt.rotations.exp(np.outer(shares, [0.0, 0.0, 1.0]))
    assert lt.rotations.distance(motion.orientations, expected).max() < 0.05


def test_orientations_asked_for_are_met_without_an_added_turn(pose_skill):
    start = lt.rotations.exp([[0.3, 0.0, 0.0]])[0]
    goal = lt.rotations.exp([[0.0, -0.4, 1.2]])[0]
    motion = pose_skill.generate(
        start=((0.0, 0.0, 0.2), start), goal=((0.4, 0.0, 0.2), -goal), dt=0.005
    )
    ends = lt.rotations.distance(motion.orientations[[0, -1]], np.stack([start, goal]))
    assert ends.max() < 1e-9
    steps = lt.rotations.distance(motion.orientations[1:], motion.orientations[:-1])
    assert steps.sum() < 1.0 + 0.3 + 0.5
    assert steps.max() < 0.02


@given(
    centres=st.lists(
        st.tuples(st.floats(0.08, 0.32), st.floats(-0.08, 0.08)), min_size=1, max_size=4
    ),
    radius=st.floats(0.01, 0.03),
    method=st.sampled_from(["auto", "map", "start"]),
)
def test_no_point_of_a_path_lies_in_an_obstacle(centres, radius, method):
    skill = lt.FastMarching(method=method).fit([wave()])
    balls = [lt.Sphere(radius, (*centre, 0.0)) for centre in centres]
    motion = skill.generate(obstacles=balls)
    for ball in balls:
        assert ball.distance(on_table(motion)).min() > 0.0


@given(
    start=st.tuples(st.floats(-0.1, 0.5), st.floats(-0.2, 0.2)),
    goal=st.tuples(st.floats(-0.1, 0.5), st.floats(-0.2, 0.2)),
    saturation=st.floats(0.02, 1.0),
)
def test_kappa_lies_between_the_saturation_and_one(start, goal, saturation):
    skill = lt.FastMarching(saturation=saturation).fit([wave()])
    path = skill.plan(start=start, goal=goal).path
    assert saturation * (1 - 1e-12) <= skill.kappa(path) <= 1.0


def test_paths_and_map_stay_in_the_workspace():
    lower, upper = (-0.05, -0.08), (0.45, 0.08)
    skill = lt.FastMarching(workspace=(lower, upper)).fit([wave()])
    np.testing.assert_allclose(skill.grid.origin, lower, atol=float(skill.grid.spacing.max()))
    wall = lt.Box((0.02, 0.12, 1.0), (0.2, -0.02, 0.0))
    motion = skill.generate(obstacles=[wall])
    assert (motion.positions >= lower).all()
    assert (motion.positions <= np.array(upper) + skill.grid.spacing).all()
    with pytest.raises(NoPath):
        skill.generate(obstacles=[lt.Box((0.02, 0.2, 1.0), (0.2, 0.0, 0.0))])
    refused("workspace", skill.generate, start=(0.0, 0.1))


def test_pauses_do_not_count_in_kappa(skill):
    path = skill.generate(start=(0.0, 0.1)).positions
    paused = np.concatenate([np.repeat(path[:1], 500, axis=0), path])
    assert skill.kappa(paused) == pytest.approx(skill.kappa(path), rel=1e-9)


def test_mean_path_that_swings_out_of_the_workspace_is_kept_inside():
    skill = lt.FastMarching(workspace=((-0.05, -0.08), (0.45, 0.08))).fit([wave(0.07)])
    motion = skill.generate(start=(0.0, 0.06))
    assert motion.positions[:, 1].max() <= 0.08 + float(skill.grid.spacing.max())
    np.testing.assert_allclose(motion.positions[0], (0.0, 0.06), atol=1e-12)

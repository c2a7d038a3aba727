"""State-by-state policies from fast marching, live maps and previews."""

import numpy as np
import pytest
from models.marching.paths import gaps_to
from motions import minimum_jerk
from scipy.spatial import cKDTree

import leadthrough as lt


@pytest.fixture(scope="module")
def skill():
    t = np.linspace(0.0, 1.0, 200)
    u = minimum_jerk(t)
    arch = np.column_stack([0.4 * u, 0.1 * np.sin(np.pi * u)])
    return lt.FastMarching().fit([lt.Trajectory(2.0 * t, arch)])


def walk(policy, position, *, steps=4000, dt=0.005, push=None):
    points = [np.asarray(position, dtype=float)]
    for step in range(steps):
        if push is not None and step == push[0]:
            points.append(points[-1] + push[1])
        points.append(points[-1] + dt * policy(points[-1]))
    return np.array(points)


def test_policy_follows_the_demonstration_to_its_goal(skill):
    points = walk(skill.policy, (0.0, 0.0))
    np.testing.assert_allclose(points[-1], (0.4, 0.0), atol=1e-4)
    shown = skill.experience[0]
    gaps = gaps_to(shown, points)
    assert gaps.max() < skill.area_of_influence


def test_steps_of_any_control_period_reach_the_goal_and_take_rows(skill):
    tools = np.array([(0.0, 0.0), (0.1, 0.2), (0.3, -0.1)])
    np.testing.assert_array_equal(skill.step(tools, 0.1)[1], skill.step(tools[1], 0.1))
    np.testing.assert_array_equal(skill.policy(tools)[2], skill.policy(tools[2]))
    for dt in (0.02, 0.5):
        now = tools
        for _ in range(int(20.0 / dt)):
            now = skill.step(now, dt)
        np.testing.assert_allclose(now, np.tile((0.4, 0.0), (3, 1)), atol=1e-4)
    fine = walk(skill.policy, tools[0], steps=1000, dt=5e-4)
    np.testing.assert_allclose(skill.step(tools[0], 0.5), fine[-1], atol=2e-3)


def test_pushed_tool_still_arrives(skill):
    points = walk(skill.policy, (0.0, 0.0), push=(200, np.array([0.05, 0.15])))
    np.testing.assert_allclose(points[-1], (0.4, 0.0), atol=1e-4)


def test_speed_is_what_the_demonstration_taught_there(skill):
    shown = skill.experience[0]
    t = np.linspace(0.0, 2.0, len(shown))
    taught = np.linalg.norm(np.gradient(shown, t, axis=0), axis=1)
    assert taught.max() > 1.6 * taught.mean()
    for sample in range(30, 170, 10):
        speed = np.linalg.norm(skill.policy(shown[sample]))
        assert speed == pytest.approx(taught[sample], rel=0.05)


def test_motion_takes_about_as_long_as_the_demonstration(skill):
    points = walk(skill.policy, (0.0, 0.0), steps=600)
    shown = skill.experience[0]
    took = [
        duration * np.argmax(np.linalg.norm(path - (0.4, 0.0), axis=1) < 0.004) / (len(path) - 1)
        for path, duration in ((points, 3.0), (shown, 2.0))
    ]
    assert took[0] == pytest.approx(took[1], rel=0.05)


def test_speed_leaves_the_start_and_falls_near_the_goal(skill):
    mean = np.linalg.norm(np.diff(skill.experience[0], axis=0), axis=1).sum() / 2.0
    assert np.linalg.norm(skill.policy((0.0, 0.0))) == pytest.approx(0.1 * mean, rel=0.2)
    np.testing.assert_allclose(skill.policy((0.4, 0.0)), 0.0, atol=1e-12)
    speeds = [np.linalg.norm(skill.policy((0.4 - gap, 0.0))) for gap in (1e-4, 3e-4, 1e-3)]
    assert speeds == sorted(speeds)
    assert speeds[0] < 0.1 * mean


def test_speed_falls_in_proportion_to_what_is_left_where_others_went_on(skill):
    policy = skill.policy_to((0.2, 0.1))  # half-way, where the demonstration is fastest
    points = walk(policy, (0.0, 0.0), steps=1000)
    left = np.linalg.norm(points - (0.2, 0.1), axis=1)
    near = (left > 2.0 * policy.grid.spacing.max()) & (left < 0.015)
    rates = [np.linalg.norm(policy(point)) for point in points[near]] / left[near]
    assert near.sum() > 5
    np.testing.assert_allclose(rates, rates[0], rtol=1e-3)


def test_policy_to_another_goal_goes_around_obstacles(skill):
    box = lt.Box((0.05, 0.05, 0.2), (0.2, 0.1, 0.0))
    policy = skill.policy_to((0.45, 0.05), obstacles=[box])
    points = walk(policy, (0.0, 0.0))
    np.testing.assert_allclose(points[-1], (0.45, 0.05), atol=1e-4)
    assert box.distance(np.column_stack([points, np.zeros(len(points))])).min() > 0.0


def ring(seed, *, dimensions=2, scatter=0.003):
    """A motion of 2 s once round, that ends where it began, but for some scatter."""
    t = np.linspace(0.0, 1.0, 300)
    angle = 2.0 * np.pi * minimum_jerk(t)
    points = 0.2 * np.column_stack([1.0 - np.cos(angle), np.sin(angle), 0.5 * np.sin(angle)])
    ends = np.random.default_rng(seed).normal(0.0, scatter, (2, dimensions))
    return lt.Trajectory(2.0 * t, points[:, :dimensions] + np.linspace(*ends, 300))


@pytest.mark.parametrize("dimensions", [2, 3])
def test_motion_that_returns_goes_round_and_does_not_stand_still_at_its_start(dimensions):
    model = lt.FastMarching(resolution=None if dimensions == 2 else 0.012)
    skill = model.fit([ring(seed, dimensions=dimensions) for seed in range(3)])
    shown = skill.experience[0]
    taught = np.linalg.norm(np.gradient(shown, 2.0 / 299, axis=0), axis=1)
    for sample in (60, 100, 150, 200, 240):
        speed = np.linalg.norm(skill.policy(shown[sample]))
        assert speed == pytest.approx(taught[sample], rel=0.1)
    for off in (0.0, 0.003, -0.003):
        points = walk(skill.policy, shown[0] + off, steps=1200)
        length = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
        assert length > 0.93 * np.linalg.norm(np.diff(shown, axis=0), axis=1).sum()
        gaps = gaps_to(shown, points)
        assert gaps.max() < skill.area_of_influence
        rest = np.linalg.norm(points[-200:] - points[-1], axis=1).max()
        assert rest < 1e-3
        assert np.linalg.norm(points[-1] - shown[0]) < 2.0 * skill.area_of_influence


@pytest.mark.parametrize("live", [False, True])
def test_tool_is_led_around_an_obstacle_that_moves(live, skill):
    policy, height = skill.policy_to(), 0.12
    position = np.array([0.0, 0.0])
    for step in range(700):
        if step % 10 == 0:
            disc = lt.Sphere(0.03, (0.25, height, 0.0))
            policy = policy.around([disc], position=position if live else None)
            height -= 0.0004 * 10
        velocity = policy(position)
        assert np.linalg.norm(velocity) < 0.5
        position = position + 0.005 * velocity
        assert disc.distance(np.append(position, 0.0)[None])[0] > 0.0
    np.testing.assert_allclose(position, (0.4, 0.0), atol=1e-3)


def test_policy_around_moved_obstacles_is_the_one_that_is_planned_anew(skill):
    first, second = (lt.Sphere(0.04, (0.2, height, 0.0)) for height in (0.1, 0.05))
    moved = skill.policy_to().around([first]).around([second])
    anew = skill.policy_to(obstacles=[second])
    for place in ((0.1, 0.1), (0.15, 0.12), (0.1, -0.05), (0.3, 0.0)):
        a, b = moved(place), anew(place)
        assert np.linalg.norm(a - b) < 0.1 * np.linalg.norm(b)
    assert np.allclose(skill.policy((0.1, 0.1)), skill.policy_to()((0.1, 0.1)))


def test_policy_marched_to_the_tool_is_the_one_of_the_whole_map_there(skill):
    disc, policy = lt.Sphere(0.04, (0.2, 0.1, 0.0)), skill.policy_to()
    for place in ((0.1, 0.1), (0.15, 0.12), (0.02, -0.05)):
        whole, part = policy.around([disc]), policy.around([disc], position=place)
        # The interpolation there lacks the cells that the wave has not reached yet.
        assert np.linalg.norm(part(place) - whole(place)) < 0.01 * np.linalg.norm(whole(place))
        assert np.isinf(part.arrival).sum() > np.isinf(whole.arrival).sum()


def test_taught_speed_holds_beside_an_obstacle(skill):
    policy = skill.policy_to(obstacles=[lt.Sphere(0.02, (0.2, 0.14, 0.0))])
    free, beside = (np.linalg.norm(each((0.2, 0.1))) for each in (skill.policy, policy))
    assert beside == pytest.approx(free, rel=0.01)


WORKSPACE = ((-0.1, -0.5, -0.1), (0.7, 0.5, 0.6))
START, GOAL = np.array([0.1, -0.3, 0.1]), np.array([0.5, 0.3, 0.1])


@pytest.fixture(scope="module")
def map_skill():
    rng = np.random.default_rng(2)
    share = np.linspace(0.0, 1.0, 120)
    shown = []
    for _ in range(4):
        path = START + np.outer(share, GOAL - START) + rng.normal(0.0, 0.005, 3)
        path[:, 2] += 0.2 * np.sin(np.pi * share)
        shown.append(lt.Demonstration(lt.Trajectory(2.0 * share, path)))
    return lt.FastMarching(method="map", resolution=0.01, workspace=WORKSPACE).fit(shown)


@pytest.fixture(scope="module")
def live(map_skill):
    return map_skill.live_map(WORKSPACE, cells=560_000)


def test_map_has_about_the_cells_asked_for(live):
    assert np.prod(live.grid.shape) == pytest.approx(560_000, rel=0.1)


@pytest.mark.parametrize("obstacles", [(), (lt.Box((0.1, 0.1, 0.2), (0.3, 0.0, 0.3)),)])
def test_route_is_the_one_of_the_skill(obstacles, map_skill, live):
    wanted = map_skill.plan(start=START, goal=GOAL, obstacles=obstacles)
    found = live.route(START, GOAL, obstacles)
    # First order against second: they agree to a cell or two.
    assert cKDTree(wanted.path).query(found.path)[0].max() < 0.025
    assert np.array_equal(found.path[[0, -1]], [START, GOAL])


def test_moved_obstacle_is_the_only_one_that_counts(live):
    here, there = (lt.Sphere(0.08, (0.3, y, 0.3)) for y in (0.0, 0.2))
    live.route(START, GOAL, [here])
    path = live.route(START, GOAL, [there]).path
    assert there.distance(path).min() > 0.0
    assert np.array_equal(path, live.route(START, GOAL, [there]).path)


def test_route_becomes_a_motion(map_skill, live):
    motion = map_skill.in_time(live.route(START, GOAL, ()), duration=3.0, dt=0.05)
    assert motion.duration == pytest.approx(3.0)
    assert np.allclose(motion.positions[-1], GOAL)


U = np.linspace(0.0, 1.0, 100)
ARCHES = [
    lt.Trajectory(2.0 * U, np.column_stack([0.4 * U, 0.1 * np.sin(np.pi * U) + shift]))
    for shift in (-0.01, 0.0, 0.01)
]


@pytest.mark.parametrize("method", ["auto", "map", "start", "mean_path"])
def test_preview_keeps_clear_and_ends_at_the_goal_as_the_skill_does(method):
    preview = lt.FastMarching(method=method).fit(ARCHES).preview()
    disc = lt.Sphere(0.02, (0.2, 0.1, 0.0))
    for height in (0.0, 0.02):
        motion = preview.generate(goal=(0.4, height), duration=3.0, obstacles=[disc])
        assert motion.positions[-1] == pytest.approx((0.4, height))
        assert motion.duration == pytest.approx(3.0)
        assert disc.distance(np.pad(motion.positions, ((0, 0), (0, 1)))).min() > 0.0


@pytest.mark.parametrize("method", ["auto", "start", "mean_path"])
def test_preview_is_the_plan(method):
    skill = lt.FastMarching(method=method).fit(ARCHES)
    preview = skill.preview()
    for height in (0.0, 0.02):
        query = {"goal": (0.4, height), "obstacles": [lt.Sphere(0.02, (0.2, 0.1, 0.0))], "dt": 0.04}
        np.testing.assert_array_equal(
            preview.generate(**query).positions, skill.generate(**query).positions
        )


def test_a_map_is_kept_until_the_goal_leaves_it():
    preview = lt.FastMarching(method="map").fit(ARCHES).preview()
    preview.generate(goal=(0.4, 0.01))
    kept = preview.live_map
    preview.generate(goal=(0.4, 0.05))
    assert preview.live_map is kept
    assert preview.generate(goal=(1.4, 0.0)).positions[-1] == pytest.approx((1.4, 0.0))
    assert preview.live_map is not kept


def test_a_pose_may_be_asked_for():
    turned = lt.rotations.exp(np.outer(U, [0.0, 0.3, 0.5]))
    points = np.column_stack([0.4 * U, 0.1 * U**2, 0.1 * U])
    preview = lt.FastMarching(method="map").fit([lt.PoseTrajectory(U, points, turned)]).preview()
    wanted = lt.rotations.exp([[0.1, 0.2, 0.3]])[0]
    motion = preview.generate(goal=((0.4, 0.12, 0.1), wanted))
    assert isinstance(motion, lt.PoseTrajectory)
    assert motion.orientations[-1] == pytest.approx(wanted)

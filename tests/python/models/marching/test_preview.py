"""Quick answers of Fast Marching Learning while something is dragged."""

import numpy as np
import pytest

import leadthrough as lt

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

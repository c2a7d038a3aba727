"""The handwriting study, from recordings to joints."""

import numpy as np
import pytest
from refusals import refused
from scipy.spatial import cKDTree

import leadthrough as lt
from leadthrough_studies.handwriting.demo import HandwritingConfig, run

CONFIG = HandwritingConfig()


@pytest.fixture(scope="module")
def arm():
    return lt.Arm.load(CONFIG.robot)


@pytest.fixture(scope="module")
def snake(arm):
    return run("Snake", arm, CONFIG)


def on_table(points):
    return np.column_stack([points, np.zeros(len(points))])


def test_six_drawings_are_shown_and_the_seventh_is_reproduced_from_its_start(snake):
    assert len(snake.shown) == 6
    np.testing.assert_allclose(snake.reproduction.positions[0], snake.held_out.positions[0])
    size = np.ptp(snake.held_out.positions, axis=0).max()
    assert snake.errors.end_error < 1.0  # mm
    assert 0.1 < size <= CONFIG.size * (1 + 1e-12)


def test_reproduction_is_nearer_to_the_drawing_than_the_straight_line_is(snake):
    start, goal = snake.held_out.positions[[0, -1]]
    line = start + np.linspace(0, 1, 200)[:, None] * (goal - start)
    gaps = [
        np.linalg.norm(snake.held_out.positions[:, None] - path[None], axis=2).min(axis=1).mean()
        for path in (snake.reproduction.positions, line)
    ]
    assert gaps[0] < 0.2 * gaps[1]


def test_box_stands_in_the_way_and_the_detour_keeps_clear_of_it(snake):
    assert snake.box.distance(on_table(snake.reproduction.positions)).min() < 0.0
    assert snake.box.distance(on_table(snake.detour.positions)).min() > 0.001


def test_arm_holds_the_pen_upright_on_the_detour(snake, arm):
    positions, orientations = arm.forward_kinematics(snake.joints.positions)
    dense = np.linspace(*snake.detour.times[[0, -1]], 50 * len(snake.detour.times))
    off, _ = cKDTree(snake.detour.at(dense)).query(positions[:, :2])
    assert off.max() < 5e-5
    np.testing.assert_allclose(positions[:, 2], CONFIG.pen_length, atol=5e-5)
    downwards = np.tile([0.0, 1.0, 0.0, 0.0], (len(orientations), 1))
    assert lt.rotations.distance(orientations, downwards).max() < 1e-4


def test_joints_are_slowed_to_their_limits_and_not_below(snake):
    assert snake.limits.ok
    assert not snake.limits.unchecked
    assert snake.slowing > 1.0
    peaks = (snake.limits.velocity, snake.limits.acceleration, snake.limits.jerk)
    assert max(peak.ratio for peak in peaks) == pytest.approx(1.0, abs=5e-3)


def test_arm_and_pen_keep_clear_of_table_box_and_themselves(snake):
    assert snake.clearance.ok
    assert snake.clearance.obstacles.minimum_distance == pytest.approx(CONFIG.pen_lift, abs=1e-5)
    assert snake.clearance.itself.minimum_distance > 0.0


def test_same_motion_gives_the_same_bits(snake, arm):
    again = run("Snake", arm, CONFIG)
    assert again.joints.positions.tobytes() == snake.joints.positions.tobytes()
    assert again.joints.times.tobytes() == snake.joints.times.tobytes()


def test_unknown_motion_is_refused(arm):
    refused("Scribble", run, "Scribble", arm, CONFIG)

import dataclasses
import pickle

import numpy as np
import pytest

import leadthrough as lt
from leadthrough.errors import InvalidInput
from leadthrough.shapes import MovingObstacle, RandomObstacle, as_scene

BALL = lt.Sphere(0.1, (0.5, 0.0, 0.3))
BOX = lt.Box((0.1, 0.1, 0.1), (0.4, 0.2, 0.1))


def test_plain_list_is_scene_with_default_margins():
    scene = as_scene([BALL, BOX])
    assert scene.shapes == (BALL, BOX)
    assert (scene.margin, scene.self_collision_margin) == (0.005, 0.0)
    stated = lt.Scene([BALL], margin=0.02)
    assert as_scene(stated) is stated


def test_scene_is_frozen_and_survives_pickling():
    scene = lt.Scene([BALL, MovingObstacle(BOX, 0.1)], 0.01, 0.02)
    with pytest.raises(dataclasses.FrozenInstanceError):
        scene.margin = 0.0
    again = pickle.loads(pickle.dumps(scene))
    assert (again.margin, again.self_collision_margin, again.speeds) == (0.01, 0.02, (0.0, 0.1))
    np.testing.assert_array_equal(again.shapes[1].position, BOX.position)


def test_planning_keeps_tolerance_beyond_both_margins():
    scene = lt.Scene([BALL], 0.004, 0.001).for_planning()
    assert scene.margin == pytest.approx(0.0042)
    assert scene.self_collision_margin == pytest.approx(0.0012)
    assert lt.Scene([BALL]).for_planning().self_collision_margin == 0.0


def test_random_obstacle_is_drawn_inside_its_region_and_repeatably():
    scene = lt.Scene([BOX, RandomObstacle(BALL, (0.2, 0.1, 0.0))])
    with pytest.raises(InvalidInput, match="draw"):
        scene.shapes  # noqa: B018
    drawn = [scene.draw(np.random.default_rng(seed)).shapes for seed in (1, 1, 2)]
    assert all(first is BOX for first, _ in drawn)
    assert all(isinstance(ball, lt.Sphere) and ball.radius == BALL.radius for _, ball in drawn)
    positions = [ball.position for _, ball in drawn]
    np.testing.assert_array_equal(positions[0], positions[1])
    assert (positions[1] != positions[2]).any()
    assert np.all(np.abs(positions - BALL.position) <= [0.2, 0.1, 0.0])


@pytest.mark.parametrize(
    "make",
    [
        lambda: lt.Scene(BALL),
        lambda: lt.Scene(["box"]),
        lambda: lt.Scene([BALL], margin=-0.001),
        lambda: lt.Scene([BALL], margin=np.nan),
        lambda: lt.Scene([BALL], self_collision_margin=-1.0),
        lambda: MovingObstacle("box", 0.1),
        lambda: MovingObstacle(BALL, -0.1),
        lambda: MovingObstacle(BALL, np.inf),
        lambda: RandomObstacle(BALL, (0.0, -0.1, 0.0)),
        lambda: RandomObstacle(BALL, np.nan),
        lambda: RandomObstacle(BALL, (0.1, 0.2)),
        lambda: RandomObstacle("ball", 0.1),
    ],
)
def test_malformed_scene_is_refused(make):
    with pytest.raises(InvalidInput):
        make()

"""Demonstrations that contradict all others are named before anything is learned."""

import motions
import numpy as np
import pytest

import leadthrough as lt
from leadthrough import rotations
from leadthrough.errors import FitError, InvalidInput

POSES = [motions.arch("poses", shift) for shift in (-0.02, 0.0, 0.02)]
POINTS = [motions.arch("points", shift) for shift in (-0.02, 0.0, 0.02)]


def reversed_(motion):
    return lt.Trajectory(motion.times, motion.positions[::-1])


def rotated(motion, degrees):
    by = rotations.exp(np.tile([0.0, np.radians(degrees), 0.0], (len(motion), 1)))
    turned = rotations.compose(by, motion.orientations)
    return lt.PoseTrajectory(motion.times, motion.positions, rotations.align_signs(turned))


def wave(motion):
    """Another task between the same ends."""
    u = np.linspace(0.0, 1.0, len(motion))
    up = 0.3 * np.sin(3.0 * np.pi * u)
    return lt.Trajectory(motion.times, motion.positions + np.column_stack([0.0 * u, up]))


def slowed(motion, factor):
    return lt.Trajectory(factor * motion.times, motion.positions)


@pytest.mark.parametrize(
    ("odd", "said"),
    [
        (reversed_(POINTS[1]), "runs backwards"),
        (wave(POINTS[1]), "takes a path of its own"),
        (slowed(POINTS[1], 0.1), "10 times as fast"),
        (slowed(POINTS[1], 10.0), "10 times as slow"),
    ],
)
def test_a_lone_one_is_named_and_dropped_on_request(odd, said):
    shown = [POINTS[0], odd, POINTS[2]]
    with pytest.raises(FitError, match=rf"demonstrations\[1\]: .*{said}"):
        lt.learn(shown, candidates=["dmp"])
    kept = lt.learn(shown, candidates=["dmp"], outliers="drop").generate()
    alone = lt.learn([POINTS[0], POINTS[2]], candidates=["dmp"]).generate()
    np.testing.assert_array_equal(kept.positions, alone.positions)


def test_a_pose_that_is_rotated_by_136_degrees_is_named_with_the_angle():
    with pytest.raises(FitError, match=r"demonstrations\[2\]: is rotated by 1[34]\d degrees"):
        lt.learn([POSES[0], POSES[1], rotated(POSES[2], 136.0)], candidates=["dmp"])


def test_two_that_agree_are_a_second_way():
    back = [reversed_(POINTS[0]), reversed_(POINTS[1])]
    lt.learn([*POINTS, *back], candidates=["aligned-mean"])
    waves = [wave(POINTS[0]), wave(POINTS[1])]
    lt.learn([*POINTS, *waves], candidates=["aligned-mean"])


def test_of_two_the_second_may_run_backwards():
    with pytest.raises(FitError, match=r"demonstrations\[1\]: runs backwards"):
        lt.learn([POINTS[0], reversed_(POINTS[1])])


def test_demonstrations_to_other_goals_do_not_contradict():
    goals = ((0.0, 0.0), (0.2, 0.1), (0.0, 0.3))
    u = np.linspace(0.0, 1.0, 150)[:, None]
    shown = [
        lt.Trajectory(m.times, m.positions + u * g) for m, g in zip(POINTS, goals, strict=True)
    ]
    lt.learn(shown, candidates=["dmp"])


def test_outliers_are_refused_or_dropped():
    with pytest.raises(InvalidInput, match="outliers"):
        lt.learn(POINTS, outliers="keep")

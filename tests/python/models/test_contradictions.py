"""Demonstrations that contradict all others are named before anything is learned."""

import motions
import numpy as np
import pytest

import leadthrough as lt
from leadthrough import rotations
from leadthrough.errors import FitError, InvalidInput
from leadthrough.models import Frame, Framed, TaskGMR

POSES = [motions.arch("poses", shift) for shift in (-0.02, 0.0, 0.02)]
POINTS = [motions.arch("points", shift) for shift in (-0.02, 0.0, 0.02)]


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
        (motions.backwards(POINTS[1]), "runs backwards"),
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
    back = [motions.backwards(POINTS[0]), motions.backwards(POINTS[1])]
    lt.learn([*POINTS, *back], candidates=["aligned-mean"])
    waves = [wave(POINTS[0]), wave(POINTS[1])]
    lt.learn([*POINTS, *waves], candidates=["aligned-mean"])


def test_of_two_the_second_may_run_backwards():
    with pytest.raises(FitError, match=r"demonstrations\[1\]: runs backwards"):
        lt.learn([POINTS[0], motions.backwards(POINTS[1])])


def test_demonstrations_to_other_goals_do_not_contradict():
    goals = ((0.0, 0.0), (0.2, 0.1), (0.0, 0.3))
    u = np.linspace(0.0, 1.0, 150)[:, None]
    shown = [
        lt.Trajectory(m.times, m.positions + u * g) for m, g in zip(POINTS, goals, strict=True)
    ]
    lt.learn(shown, candidates=["dmp"])


def test_one_that_is_meant_is_kept_on_request():
    shown = [POINTS[0], wave(POINTS[1]), POINTS[2]]
    kept = lt.DMP().fit(shown, outliers="keep")
    other = kept.generate(mode=1).positions
    assert len(kept.modes) == 2
    assert np.abs(other - lt.DMP().fit(POINTS).generate().positions).max() > 0.05
    lt.learn(shown, candidates=["dmp"], outliers="keep")
    with pytest.raises(InvalidInput, match="outliers"):
        lt.learn(POINTS, outliers="refused")


def test_motions_at_given_phases_and_those_seen_from_their_frames_are_not_contradictions():
    shown = [POINTS[0], wave(POINTS[1]), POINTS[2]]
    with pytest.raises(FitError, match=r"demonstrations\[1\]"):
        lt.ProMP().fit(shown)
    lt.ProMP().fit(shown, phases=[np.linspace(0.0, 1.0, 150)] * 3)

    quarter = np.array([[0.0, -1.0], [1.0, 0.0]])
    turned = lt.Trajectory(POINTS[1].times, POINTS[1].positions @ quarter.T)
    shown, frames = [POINTS[0], turned, POINTS[2]], [Frame((0.0, 0.0)) for _ in range(3)]
    frames[1] = Frame((0.0, 0.0), quarter)
    with pytest.raises(FitError, match=r"demonstrations\[1\]"):
        lt.DMP().fit(shown)
    for model in (Framed(lt.DMP()), TaskGMR(components=4)):
        model.fit(shown, frames=[[each] for each in frames])
    frames[1] = Frame((0.0, 0.0))
    with pytest.raises(FitError, match=r"demonstrations\[1\]"):
        Framed(lt.DMP()).fit(shown, frames=[[each] for each in frames])

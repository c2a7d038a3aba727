"""Joints that encoders give at another turn in some of the demonstrations."""

from dataclasses import replace

import numpy as np
import pytest

import leadthrough as lt
from leadthrough.models import DMP, GMR, AlignedMean, ProMP
from leadthrough.sanity import ImplausibleInputWarning

U = np.linspace(0.0, 1.0, 120)
SHAPE = U**2 * (3.0 - 2.0 * U)
MODELS = {"aligned mean": AlignedMean(), "DMP": DMP(), "ProMP": ProMP(), "GMR": GMR(6, starts=1)}


def reaches(turns):
    """A reach of two joints, the second of which begins near half a turn, at whole turns."""
    return [
        lt.JointTrajectory(
            2.0 * U,
            np.column_stack([0.6 * SHAPE, 3.13 + 0.01 * i + 2 * np.pi * k - 0.5 * SHAPE]),
            joint_names=("shoulder", "elbow"),
        )
        for i, k in enumerate(turns)
    ]


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize(("turns", "usual"), [((0, -1, 0), 0), ((1, 1, 0), 1), ((-1, 0), -1)])
def test_demonstrations_are_learned_at_the_turn_of_most(name, turns, usual):
    model = MODELS[name]
    wanted = model.fit(reaches([usual] * len(turns))).generate()
    with pytest.warns(ImplausibleInputWarning, match=r"demonstrations\[.\]: elbow is .6.283 rad"):
        made = model.fit(reaches(turns)).generate()
    np.testing.assert_allclose(made.positions, wanted.positions, atol=1e-6)


def test_joints_that_go_along_with_poses_are_at_one_turn_too():
    def shown(turns):
        points = np.column_stack([0.3 * SHAPE, 0.0 * U, 0.2 + 0.0 * U])
        upright = np.tile([1.0, 0.0, 0.0, 0.0], (len(U), 1))
        return [lt.PoseTrajectory(2.0 * U, points, upright, joints=each) for each in reaches(turns)]

    wanted, made = (AlignedMean().fit(shown(turns)).generate() for turns in ((0, 0, 0), (0, 1, 0)))
    np.testing.assert_allclose(made.joints.positions, wanted.joints.positions, atol=1e-9)


def test_joints_that_are_no_whole_turn_apart_stay_where_they_are():
    demonstrations = reaches((0, 0))
    far = replace(demonstrations[1], positions=demonstrations[1].positions - [0.0, 4.0])
    skill = AlignedMean().fit([demonstrations[0], far])
    assert skill.generate(start=far.positions[0]).positions[0] == pytest.approx(far.positions[0])


def test_numbers_too_large_to_be_turns_stay_as_they_are():
    shown = [replace(each, positions=1e20 * each.positions) for each in reaches((0, 1))]
    start = np.mean([each.positions[0] for each in shown], axis=0)
    made = AlignedMean().fit(shown).generate()
    np.testing.assert_allclose(made.positions[0], start, rtol=1e-9, atol=1e10)


def test_a_query_a_whole_turn_from_the_demonstrations_is_named():
    skill = AlignedMean().fit(reaches((0, 0)))
    with pytest.warns(ImplausibleInputWarning, match="start: number 2 is -3.15 rad, a whole turn"):
        skill.generate(start=[0.0, -3.15])

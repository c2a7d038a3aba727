"""Motions one after the other."""

from dataclasses import replace

import numpy as np
import pytest

import leadthrough as lt
from leadthrough import rotations
from leadthrough.errors import InvalidInput
from leadthrough.preprocess import join, segment

TIMES = np.linspace(2.0, 5.0, 31)
WAY = np.linspace(0.0, 1.0, 31)


def poses(first=0.0):
    turned = rotations.exp(np.outer(first + WAY, [0.0, 0.0, 2.0]))
    happened = (lt.Event(3.0, "closed"), lt.Event(5.0, "opened"))
    return lt.PoseTrajectory(TIMES, np.outer(first + WAY, [1.0, 0.5, 0.0]), turned, happened)


def test_each_motion_begins_where_and_when_the_last_one_ended():
    whole = join([poses(), poses(1.0), poses(2.0)])
    assert len(whole.times) == 91
    np.testing.assert_allclose(whole.times, np.linspace(2.0, 11.0, 91))
    np.testing.assert_allclose(whole.positions[:, 0], np.linspace(0.0, 3.0, 91), atol=1e-12)
    np.testing.assert_allclose(
        rotations.distance(whole.orientations[1:], whole.orientations[:-1]), 2.0 / 30
    )
    times = [event.time for event in whole.events]
    np.testing.assert_allclose(times, [3.0, 5.0, 6.0, 8.0, 9.0, 11.0])


def test_what_was_cut_is_joined_again():
    rests = np.concatenate([np.zeros(50), WAY, np.ones(100), 1.0 + WAY, np.full(50, 2.0)])
    shown = lt.Trajectory(0.02 * np.arange(len(rests)), np.outer(rests, [1.0, 0.3]))
    parts = [each.motion for each in segment(lt.Demonstration(shown))]
    whole = join(parts)
    assert whole.duration == pytest.approx(sum(part.duration for part in parts))
    np.testing.assert_array_equal(whole.positions[[0, -1]], shown.positions[[0, -1]])


def test_joints_keep_derivatives_and_names_where_all_have_them():
    q = np.outer(WAY, [1.0, 2.0])
    first = lt.JointTrajectory(TIMES, q, q, None, ("a", "b"))
    second = replace(first, positions=q + q[-1])
    whole = join([first, second])
    assert whole.joint_names == ("a", "b")
    np.testing.assert_array_equal(whole.velocities, np.vstack([q, q[1:]]))
    assert whole.accelerations is None
    assert join([first, replace(second, velocities=None)]).velocities is None


def test_one_motion_is_itself():
    assert join([poses()]).positions.tobytes() == poses().positions.tobytes()


@pytest.mark.parametrize(
    "wrong",
    [
        [],
        poses(),
        [poses(), 3],
        [poses(), poses()],
        [poses(), lt.Trajectory(TIMES, poses().positions)],
        [poses(), replace(poses(1.0), orientations=poses().orientations)],
        3,
    ],
)
def test_what_does_not_fit_is_refused(wrong):
    with pytest.raises(InvalidInput, match="motions"):
        join(wrong)

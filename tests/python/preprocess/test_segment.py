"""Recordings cut into motions, and motions joined."""

from dataclasses import replace

import numpy as np
import pytest
from motions import minimum_jerk
from refusals import refused

import leadthrough as lt
from leadthrough import rotations
from leadthrough.errors import InvalidInput
from leadthrough.preprocess import join, segment


def stop_and_go(*, rate=100.0, noise=0.0):
    """Three strokes of 1 s and 0.2 m, the last one a turn on the spot, 1 s of rest around each."""
    times = np.arange(0.0, 7.0, 1.0 / rate)
    rise = [np.clip(times - start, 0.0, 1.0) for start in (1.0, 3.0, 5.0)]
    s = [minimum_jerk(u) for u in rise]
    points = np.column_stack([0.2 * s[0], 0.2 * s[1], np.zeros_like(times)])
    points += np.random.default_rng(0).normal(0.0, noise, points.shape)
    turned = lt.rotations.exp(np.outer(s[2], [0.0, 1.5, 0.0]))
    return lt.Demonstration(lt.PoseTrajectory(times, points, turned), name="work")


@pytest.mark.parametrize("noise", [0.0, 3e-4])
def test_motions_are_cut_at_pauses(noise):
    pieces = segment(stop_and_go(noise=noise))
    assert [piece.name for piece in pieces] == ["work 1", "work 2", "work 3"]
    for piece, start in zip(pieces, (1.0, 3.0, 5.0), strict=True):
        assert start - 0.4 <= piece.motion.times[0] <= start + 0.1
        assert start + 0.9 <= piece.motion.times[-1] <= start + 1.4


def test_samples_are_as_recorded():
    whole = stop_and_go().motion
    for piece in segment(stop_and_go()):
        rows = np.searchsorted(whole.times, piece.motion.times)
        np.testing.assert_array_equal(piece.motion.times, whole.times[rows])
        np.testing.assert_array_equal(piece.motion.positions, whole.positions[rows])
        np.testing.assert_allclose(piece.motion.orientations, whole.orientations[rows], atol=1e-15)


def test_a_turn_alone_is_seen_in_poses_only():
    poses = stop_and_go().motion
    points = lt.Demonstration(lt.Trajectory(poses.times, poses.positions))
    assert len(segment(points)) == 2
    assert segment(points)[0].name == "1"


def test_joints_keep_all_they_have():
    poses = stop_and_go().motion
    joints = lt.JointTrajectory(
        poses.times, poses.positions, poses.positions, joint_names=("a", "b", "c")
    )
    first = segment(lt.Demonstration(joints))[0].motion
    assert first.joint_names == ("a", "b", "c")
    np.testing.assert_array_equal(first.velocities, first.positions)
    assert first.accelerations is None


def test_short_rests_do_not_cut_and_short_motions_are_left_out():
    assert len(segment(stop_and_go(), pause=1.5)) == 1
    assert segment(stop_and_go(), shortest=3.0) == []


def test_what_stands_still_has_no_motions():
    still = lt.Demonstration(lt.Trajectory([0.0, 1.0, 2.0], np.ones((3, 2))))
    assert segment(still) == []
    assert segment(lt.Demonstration(lt.Trajectory([0.0], [[1.0]]))) == []
    single = lt.PoseTrajectory([0.0], [[0.0, 0.0, 0.0]], [[1.0, 0.0, 0.0, 0.0]])
    assert segment(lt.Demonstration(single)) == []


def test_a_motion_stands_for_a_demonstration_of_it():
    named, alone = segment(stop_and_go()), segment(stop_and_go().motion)
    assert [each.name for each in alone] == [str(i) for i in range(1, len(named) + 1)]
    for each, same in zip(alone, named, strict=True):
        assert np.array_equal(each.motion.positions, same.motion.positions)


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


def test_bad_settings_and_what_does_not_fit_are_refused_by_name():
    for value in [0.0, np.nan, "1"]:
        for name in ["speed", "angular_speed", "pause", "shortest"]:
            refused(name, segment, stop_and_go(), **{name: value})
            with pytest.raises(
                InvalidInput, match="demonstration: expected a Demonstration or a motion"
            ):
                segment(stop_and_go().motion.positions)
    for wrong in [
        [],
        poses(),
        [poses(), 3],
        [poses(), poses()],
        [poses(), lt.Trajectory(TIMES, poses().positions)],
        [poses(), replace(poses(1.0), orientations=poses().orientations)],
        3,
    ]:
        refused("motions", join, wrong)

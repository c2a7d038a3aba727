"""Motions, demonstrations and their events."""

import numpy as np
import pytest
from hypothesis import given, strategies as st
from refusals import refused

import leadthrough as lt
from leadthrough.errors import InvalidInput
from leadthrough.models.coordinates import events_by_round
from leadthrough.models.dmp.rhythmic import events_of_rounds
from leadthrough.motion import (
    Event,
    agreed_events,
    events_of_plain,
    moved_events,
    normalised_times,
    plain_events,
)

TIMES = np.array([0.0, 0.5, 2.0])
UNIT = np.tile([1.0, 0.0, 0.0, 0.0], (3, 1))


def test_data_are_copied_and_read_only():
    positions = np.zeros((3, 2))
    motion = lt.Trajectory(TIMES, positions)
    positions[0, 0] = 1.0
    assert motion.positions[0, 0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        motion.positions[0, 0] = 1.0
    with pytest.raises(AttributeError):
        motion.positions = positions


def test_normalised_times_run_from_zero_to_one_and_a_single_one_is_zero():
    assert np.array_equal(normalised_times(TIMES + 3.0), [0.0, 0.25, 1.0])
    assert np.array_equal(normalised_times(TIMES[2:]), [0.0])


def test_duration_is_from_the_first_to_the_last_sample():
    assert lt.Trajectory(TIMES + 3.0, np.zeros((3, 2))).duration == 2.0
    assert lt.PoseTrajectory(TIMES, np.zeros((3, 3)), UNIT).duration == 2.0
    assert lt.JointTrajectory(TIMES, np.zeros((3, 6))).duration == 2.0


def test_orientations_are_normalised_and_sign_continuous():
    flipped = UNIT * np.array([[1.001], [-1.0], [1.0]])
    motion = lt.PoseTrajectory(TIMES, np.zeros((3, 3)), flipped)
    assert np.array_equal(motion.orientations, UNIT)


def test_a_demonstration_holds_a_motion():
    motion = lt.Trajectory(TIMES, np.zeros((3, 2)))
    assert lt.Demonstration(motion, name="first").motion is motion
    refused("motion: expected a Trajectory", lt.Demonstration, np.zeros((3, 2)))


def test_motions_compare_by_identity_and_can_be_hashed():
    a, b = (lt.Trajectory(TIMES, np.zeros((3, 2))) for _ in range(2))
    assert a == a  # noqa: PLR0124
    assert a != b
    assert len({a, b}) == 2


def test_a_slice_keeps_times_rows_and_the_events_between():
    times = np.arange(10.0)
    happened = [lt.Event(1.0, "opened"), lt.Event(4.5, "closed")]
    rows = np.column_stack([times, -times])
    motion = lt.JointTrajectory(times, rows, 2.0 * rows, joint_names=("a", "b"), events=happened)
    piece = motion[3:7]
    assert len(motion) == 10
    assert len(piece) == 4
    assert piece.times.tolist() == [3.0, 4.0, 5.0, 6.0]
    assert np.array_equal(piece.velocities, 2.0 * piece.positions)
    assert piece.accelerations is None
    assert piece.joint_names == ("a", "b")
    assert [event.name for event in piece.events] == ["closed"]
    assert np.array_equal(motion[::3].positions, rows[::3])


def test_what_makes_no_motion_is_refused_by_name():
    for positions in [
        np.zeros((2, 2)),
        np.zeros(3),
        np.zeros((3, 0)),
        np.full((3, 2), np.nan),
        None,
    ]:
        for motion in (lt.Trajectory, lt.JointTrajectory):
            refused("positions: ", motion, TIMES, positions)
    refused("times: expected at least one sample", lt.Trajectory, [], np.zeros((0, 2)))
    refused(r"positions: expected shape \(3, 3\)", lt.PoseTrajectory, TIMES, np.zeros((3, 2)), UNIT)
    refused("orientations: ", lt.PoseTrajectory, TIMES, np.zeros((3, 3)), np.zeros((3, 4)))
    for name in ("velocities", "accelerations"):
        with pytest.raises(InvalidInput, match=f"{name}: expected shape"):
            lt.JointTrajectory(TIMES, np.zeros((3, 2)), **{name: np.zeros((3, 1))})
    for names in ["ab", ("a",), ("a", "b", "c"), ("a", 1), None, 2]:
        refused("joint_names: ", lt.JointTrajectory, TIMES, np.zeros((3, 2)), joint_names=names)
    with pytest.raises(InvalidInput, match="positions: expected numbers, got a Trajectory"):
        lt.Trajectory(TIMES, lt.Trajectory(TIMES, np.zeros((3, 2))))


def test_between_samples_a_motion_is_straight_and_turns_steadily():
    points = np.array([[0.0, 1.0], [1.0, 1.0], [1.0, 0.0]])
    motion = lt.Trajectory(TIMES, points)
    assert np.array_equal(motion.at(0.25), [0.5, 1.0])
    assert np.array_equal(motion.at([0.0, 2.0]), points[[0, 2]])
    turned = lt.rotations.exp(np.outer([0.0, 1.0, 2.5], [0.0, 0.0, 1.0]))
    poses = lt.PoseTrajectory(TIMES, np.zeros((3, 3)), turned)
    position, orientation = poses.at(1.25)
    assert position.tolist() == [0.0, 0.0, 0.0]
    np.testing.assert_allclose(lt.rotations.log(orientation[None])[0], [0.0, 0.0, 1.75])
    positions, orientations = poses.at(TIMES)
    assert positions.shape == (3, 3)
    np.testing.assert_allclose(orientations, turned)
    assert lt.PoseTrajectory([1.0], np.zeros((1, 3)), UNIT[:1]).at(1.0)[1].shape == (4,)
    assert lt.JointTrajectory(TIMES, points).at(0.25).tolist() == [0.5, 1.0]


def test_pieces_and_times_outside_a_motion_are_refused():
    for samples in [3, slice(5, 5), "a", slice(None, None, -1)]:
        with pytest.raises(InvalidInput, match=r"samples: |times: "):
            lt.Trajectory(np.arange(10.0), np.zeros((10, 2)))[samples]
    for time in [-0.1, 2.1, np.nan, "now", [0.0, 3.0]]:
        refused("time: ", lt.Trajectory(TIMES, np.zeros((3, 2))).at, time)


def test_an_object_of_which_a_part_was_meant_is_told_the_part(tmp_path):
    arm = lt.Arm.load("ur3")
    q = np.array([0.0, -1.6, 1.9, -1.9, -1.6, 0.0])
    joints = lt.JointTrajectory([0.0, 1.0], [q, q + 0.1])
    with pytest.raises(
        InvalidInput, match=r"expected numbers, got Demonstration.* give its motion"
    ):
        arm.check(lt.Demonstration(joints))
    skill = lt.DMP(weights=5).fit([arm.poses(joints)])
    planned = lt.plan_motion(skill, arm)
    refused("got PlannedMotion; give its joints", lt.write_motion, planned, tmp_path / "a.json")
    refused(r"arm.poses\(motion\) makes poses of joints", lt.FastMarching().fit, [joints])
    refused(r"path: no such file: none\.npz", lt.load_skill, "none.npz")


def at(*pairs):
    return tuple(Event(time, name) for time, name in pairs)


def test_motions_sort_their_events_and_demonstrations_show_them():
    motion = lt.Trajectory([1.0, 2.0], [[0.0], [1.0]], at((2.0, "opened"), (1.0, "closed")))
    assert motion.events == at((1.0, "closed"), (2.0, "opened"))
    assert lt.Demonstration(motion).events == motion.events
    assert lt.Trajectory([1.0, 2.0], [[0.0], [1.0]], [Event(1.5, "a")]).events == at((1.5, "a"))


def test_events_without_a_time_or_a_name_or_outside_their_motion_are_refused():
    for time, name in [(np.nan, "a"), ("now", "a"), (0.0, " "), (0.0, 3)]:
        refused(r"time|name", Event, time, name)
    for wrong in [at((2.1, "late")), at((0.9, "early")), "closed", 3, None, [(1.0, "closed")]]:
        refused("events", lt.Trajectory, [1.0, 2.0], [[0.0], [1.0]], wrong)


def test_moved_events_come_as_soon_as_the_new_clock_gets_there():
    old, new = [0.0, 1.0, 1.0, 2.0], [10.0, 11.0, 13.0, 14.0]
    found = moved_events(at((0.5, "a"), (1.0, "b"), (1.5, "c"), (2.0, "d")), old, new)
    assert found == at((10.5, "a"), (11.0, "b"), (13.5, "c"), (14.0, "d"))


@given(st.lists(st.floats(0.0, 1.0), max_size=8), st.floats(0.1, 100.0), st.floats(-10.0, 10.0))
def test_events_that_move_there_and_back_are_where_they_were(times, scale, shift):
    old = np.linspace(0.0, 1.0, 5)
    new = shift + scale * old**2
    before = tuple(Event(time, "x") for time in sorted(times))
    moved = moved_events(before, old, new)
    assert all(new[0] <= event.time <= new[-1] for event in moved)
    back = moved_events(moved, new, old)
    np.testing.assert_allclose(
        [event.time for event in back], [event.time for event in before], atol=1e-6
    )


def test_most_demonstrations_decide_what_happens_and_their_mean_when():
    shown = [
        at((0.2, "closed"), (0.5, "opened"), (0.6, "closed")),
        at((0.4, "closed"), (0.7, "opened"), (0.8, "closed")),
        at((0.3, "closed"), (0.9, "dropped")),
    ]
    found = agreed_events(shown)
    assert [event.name for event in found] == ["closed", "opened", "closed"]
    np.testing.assert_allclose([event.time for event in found], [0.3, 0.6, 0.7])
    assert agreed_events(shown[:2] + [()] * 2) == ()  # half is not most
    (only,) = agreed_events([at((0.2, "a")), at((0.6, "a")), ()], [1.0, 3.0, 2.0])
    assert only.time == pytest.approx(0.5)


def test_rounds_are_cut_and_repeated():
    happened = at((0.25, "a"), (1.25, "a"), (2.0, "b"))
    assert events_by_round(happened, 0.0, 2.0) == [at((0.25, "a")), at((0.25, "a"), (1.0, "b"))]
    assert events_of_rounds(at((0.25, "a")), 2.2) == at((0.25, "a"), (1.25, "a"))


def test_plain_values_come_back():
    happened = at((0.1, "closed"), (1.0 / 3.0, "opened"))
    assert events_of_plain(plain_events(happened)) == happened

"""Separate tasks of two arms: each keeps its path, and one waits where they would meet."""

import numpy as np
import pytest
from refusals import refused
from scipy.interpolate import CubicSpline

import leadthrough as lt
from leadthrough.arm import coordinate
from leadthrough.errors import NoPath

DOWN = (0.0, 1.0, 0.0, 0.0)


@pytest.fixture(scope="module")
def pair(panda):
    return lt.DualArm(panda, panda, ((0.0, -0.6, 0.0), (1.0, 0.0, 0.0, 0.0)))


def line(arm, begin, end, samples=61, duration=3.0):
    s = lt.trajectories.minimum_jerk_time_scaling(np.linspace(0.0, 1.0, samples))[:, None]
    path = np.array(begin) + s * (np.array(end) - begin)
    poses = lt.PoseTrajectory(
        duration * np.linspace(0, 1, samples), path, np.tile(DOWN, (samples, 1))
    )
    return arm.follow(poses, scene=[], on_rate_limit="exceed_limits")


def there_and_back(motion):
    times = np.append(motion.times, motion.times[1:] + motion.times[-1])
    rows = np.vstack([motion.positions, motion.positions[-2::-1]])
    events = [lt.Event(motion.times[-1], f"at {motion.joint_names[0]}")]
    return lt.JointTrajectory(times, rows, joint_names=motion.joint_names, events=events)


@pytest.fixture(scope="module")
def crossing(panda):
    """Both reach over the middle between the bases, which is at y = -0.3 of the left one."""
    left = line(panda, [0.35, 0.2, 0.4], [0.6, -0.35, 0.25])
    right = line(panda, [0.35, -0.2, 0.4], [0.6, 0.35, 0.3], 81, 4.0)
    return there_and_back(left), there_and_back(right)


def test_one_arm_waits_until_the_other_has_passed(pair, crossing):
    left, right = crossing
    last = left.times[-1]
    together = pair.check(np.hstack([left.positions, right.at(left.times)]), [])
    assert not together.ok
    found = coordinate(pair, left, right)
    assert pair.check(found.joints, [], tolerance=1e-4).ok
    (wait,) = found.waits
    assert wait.bodies == together.first.bodies
    assert {name.partition("_")[0] for name in wait.bodies} == {"left", "right"}
    own = found.joints.positions[:, :7] if wait.side == "left" else found.joints.positions[:, 7:]
    stands = (found.joints.times >= wait.begin) & (found.joints.times <= wait.end)
    np.testing.assert_allclose(own[stands], np.tile(wait.q, (stands.sum(), 1)), atol=1e-9)
    assert wait.end - wait.begin < last


def test_both_paths_are_kept(pair, crossing):
    """Each row is on the spline through an arm's samples, and none of it is left out."""
    found = coordinate(pair, *crossing)
    for rows, motion in zip(np.split(found.joints.positions, [7], axis=1), crossing, strict=True):
        ends = motion.positions[[0, -1]]
        np.testing.assert_allclose(rows[[0, -1]], ends, rtol=0.0, atol=1e-12)
        times = np.linspace(0.0, motion.times[-1], 4001)
        path = CubicSpline(motion.times, motion.positions)(times)
        gaps = np.linalg.norm(rows[:, None] - path[None, ::20], axis=2)
        assert gaps.min(axis=0).max() < 0.05
        nearest = np.abs(rows[:, None] - path[None]).max(axis=2).min(axis=1)
        assert nearest.max() < 2e-3


def test_the_motion_is_retimed_within_all_limits(pair, crossing):
    found = coordinate(pair, *crossing)
    run = lt.retime(found.joints, pair.limits)
    assert lt.check_limits(run, pair.limits).ok
    assert pair.check(run, []).ok
    assert [event.name for event in run.events] == ["at panda_joint1"] * 2


@pytest.fixture(scope="module")
def apart(panda):
    return lt.DualArm(panda, panda, ((0.0, -2.0, 0.0), (1.0, 0.0, 0.0, 0.0)))


def test_arms_that_never_meet_do_not_wait(apart, crossing):
    found = coordinate(apart, *crossing)
    assert found.waits == ()
    together = max(motion.duration for motion in crossing)
    assert found.joints.duration == pytest.approx(together, rel=0.1)


def test_an_arm_that_ends_in_the_others_way_is_refused(pair, panda):
    left = line(panda, [0.35, 0.2, 0.4], [0.6, -0.3, 0.3])
    right = line(panda, [0.35, -0.2, 0.4], [0.6, 0.3, 0.3])
    with pytest.raises(NoPath, match=r"left_panda_\w+ and right_panda_\w+ come") as raising:
        coordinate(pair, left, right)
    assert raising.value.reason == "blocked"


def test_obstacles_in_the_way_of_one_arm_are_named(apart, panda):
    left, right = (line(panda, [0.35, y, 0.4], [0.5, y, 0.3]) for y in (0.2, -0.2))
    box = lt.Box((0.1, 0.1, 0.6), (0.55, 0.2, 0.3))
    assert coordinate(apart, left, right).waits == ()
    with pytest.raises(NoPath, match="obstacle 0 and left_panda"):
        coordinate(apart, left, right, scene=[box])


def test_bad_arguments_are_named(pair, crossing):
    left, right = crossing
    refused("pair: expected a DualArm", coordinate, pair.left, left, right)
    refused("left", coordinate, pair, None, right)
    refused("right: expected two samples or more", coordinate, pair, left, right[:1])
    refused("left: expected samples so dense", coordinate, pair, left[::12], right)


def test_motions_of_paces_that_no_memory_holds_together_are_refused(pair, crossing):
    left, right = crossing
    quick = lt.JointTrajectory(1e-6 * left.times, left.positions, joint_names=left.joint_names)
    refused("left, right: expected at most", coordinate, pair, quick, right)

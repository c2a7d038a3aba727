"""Recorded joints as the arm's own, and as poses of its tip."""

import numpy as np
import pytest
from refusals import raised, refused

import leadthrough as lt
from leadthrough.arm import FollowOptions, IkOptions

ARM = lt.Arm.load("panda")
TIMES = np.linspace(0.0, 1.0, 20)
MIDDLE = 0.5 * (ARM.limits.lower + ARM.limits.upper)
Q = MIDDLE + 0.3 * np.sin(TIMES[:, None] * np.arange(1, 8))
NAMED = lt.JointTrajectory(TIMES, Q, joint_names=ARM.joint_names)
ENDLESS = """<robot name="endless">
<link name="base"/><link name="upper"/><link name="lower"/>
<joint name="turn" type="continuous"><parent link="base"/><child link="upper"/>
<axis xyz="0 0 1"/></joint>
<joint name="lift" type="revolute"><parent link="upper"/><child link="lower"/>
<origin xyz="0.3 0 0.2"/><axis xyz="0 1 0"/>
<limit lower="-4" upper="4" velocity="1" effort="1"/></joint></robot>"""


def recording(names, columns, **more):
    return lt.JointTrajectory(TIMES, Q[:, columns], joint_names=names, **more)


def test_joints_are_found_by_name_among_others_in_any_order():
    shuffled = [6, 0, 3, 1, 5, 2, 4]
    names = ("finger", *(ARM.joint_names[i] for i in shuffled))
    found = ARM.joints_of(recording(names, [0, *shuffled], velocities=Q[:, [0, *shuffled]]))
    assert found.joint_names == ARM.joint_names
    assert np.array_equal(found.positions, Q)
    assert np.array_equal(found.velocities, Q)
    assert found.accelerations is None


def test_poses_are_the_tips_at_every_sample_and_keep_events():
    happens = (lt.Event(0.4, "close"),)
    motion = ARM.poses(lt.JointTrajectory(TIMES, Q, events=happens))
    positions, orientations = ARM.forward_kinematics(Q)
    assert np.array_equal(motion.positions, positions)
    # PoseTrajectory may turn a quaternion's sign.
    assert np.allclose(np.abs(np.sum(motion.orientations * orientations, axis=1)), 1.0)
    assert np.array_equal(motion.times, TIMES)
    assert motion.events == happens


def test_follow_leads_back_to_the_joints_poses():
    motion = ARM.poses(lt.JointTrajectory(TIMES, Q))
    back = ARM.poses(ARM.follow(motion, q0=Q[0]))
    assert np.abs(back.positions - motion.positions).max() < 1e-5


@pytest.mark.parametrize(
    "wrong",
    [
        Q,
        lt.JointTrajectory(TIMES, Q[:, :6]),
        lt.JointTrajectory(TIMES, Q, joint_names=tuple("abcdefg")),
        lt.PoseTrajectory([0.0], [(0, 0, 0)], [(1, 0, 0, 0)]),
    ],
)
def test_other_joints_are_refused(wrong):
    refused("trajectory", ARM.poses, wrong)


def test_joints_without_limits_are_made_continuous():
    endless = lt.Arm.from_urdf(ENDLESS)
    q = np.column_stack([np.linspace(2.0, 8.0, 20), np.linspace(0.0, 1.0, 20)])
    leaping = (q + np.pi) % (2.0 * np.pi) - np.pi
    recorded = lt.JointTrajectory(TIMES, leaping)
    found = endless.joints_of(recorded).positions
    np.testing.assert_allclose(found, q, atol=1e-12)
    shown = endless.poses(recorded)
    assert np.abs(np.diff(shown.joints.positions, axis=0)).max() < 0.5


def test_leaps_of_whole_turns_are_undone_with_an_arm_and_refused_without():
    arm = lt.Arm.load("ur3")
    q = np.linspace([2.9, -1.6, 1.9, -1.9, -1.6, 0.0], [3.5, -1.3, 1.5, -1.7, -1.5, 0.5], 50)
    leaping = lt.JointTrajectory(np.linspace(0.0, 2.0, 50), (q + np.pi) % (2.0 * np.pi) - np.pi)
    np.testing.assert_allclose(arm.joints_of(leaping).positions, q, atol=1e-12)
    assert "leaps by a whole turn" in str(raised(lt.errors.FitError, lt.learn, [leaping]))
    lt.learn([arm.joints_of(leaping)])


def test_poses_of_joints_are_followed_in_the_posture_that_was_shown():
    stood = np.add(Q, [-0.9, 0.5, 1.3, -0.7, -1.2, 0.4, 0.9])  # far from the middle of the ranges
    shown = ARM.poses(lt.JointTrajectory(TIMES, stood, joint_names=ARM.joint_names))
    back = ARM.follow(shown)
    np.testing.assert_allclose(back.positions[0], stood[0], atol=1e-6)
    assert np.abs(back.positions - stood).max() < 0.1
    bare = lt.PoseTrajectory(shown.times, shown.positions, shown.orientations)
    assert np.abs(ARM.follow(bare).positions[0] - stood[0]).max() > 0.3


def test_a_posture_that_is_asked_for_goes_before_the_shown_one():
    shown = ARM.poses(NAMED)
    other = ARM.inverse_kinematics_all(
        shown.positions[0], shown.orientations[0], options=IkOptions(posture=Q[0])
    )
    far = other.q[np.argmax(np.abs(other.q - Q[0]).max(axis=1))]
    held = ARM.follow(shown, q0=far, options=FollowOptions(posture=far))
    assert np.abs(held.positions[0] - Q[0]).max() > 0.3


def test_joints_of_another_arm_say_nothing_of_the_posture():
    shown = ARM.poses(lt.JointTrajectory(TIMES, Q))
    named = lt.JointTrajectory(TIMES, Q, joint_names=tuple("abcdefg"))
    foreign = lt.PoseTrajectory(shown.times, shown.positions, shown.orientations, joints=named)
    bare = lt.PoseTrajectory(shown.times, shown.positions, shown.orientations)
    assert ARM.follow(foreign).positions.tobytes() == ARM.follow(bare).positions.tobytes()


def test_where_the_shown_posture_ends_early_another_one_is_taken():
    # With the elbow shown so, joint 1 comes to its limit on a longer way around.
    goal = [0.0, 0.0, 0.0, -2.0, 0.0, 2.0, 0.8]
    line = np.linspace(0.0, 1.0, 60)[:, None]
    there, turned = ARM.forward_kinematics(np.array(goal))
    way = there + line * [0.0, 0.25, 0.0]
    edge = np.add(goal, [2.85, 0.0, -2.85, 0.0, 0.0, 0.0, 0.0])
    reached = ARM.inverse_kinematics(way[0], turned, q0=edge)
    joints = lt.JointTrajectory(
        np.arange(60) / 20.0, np.repeat(reached.q[None], 60, axis=0), joint_names=ARM.joint_names
    )
    motion = lt.PoseTrajectory(np.arange(60) / 20.0, way, np.tile(turned, (60, 1)), joints=joints)
    made = ARM.follow(motion)
    assert ARM.path_report(made, motion).position_error.max() < 1e-4


def test_a_goal_that_moves_changes_the_joints_continuously():
    skill = lt.DMP().fit([ARM.poses(NAMED)])
    plain = skill.generate(dt=0.05)
    before = None
    for step in np.linspace(-0.06, 0.06, 25):
        goal = plain.positions[-1] + [step, 0.5 * step, -step], plain.orientations[-1]
        joints = ARM.follow(skill.generate(goal=goal, dt=0.05, duration=1.0)).positions
        assert np.abs(joints[0] - Q[0]).max() < 0.05
        if before is not None:
            assert np.abs(joints - before).max() < 0.1
        before = joints

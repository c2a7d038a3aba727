"""Motions through a singularity of the wrist, followed near the joints that were demonstrated."""

import foreign_arms
import numpy as np
import pytest
from motions import minimum_jerk

import leadthrough as lt
from leadthrough import rotations
from leadthrough.arm import FollowOptions
from leadthrough.errors import IkFailure

# URDF, tip, start and way of the joints; the last but one passes 0, where the wrist is singular.
ARMS = {
    "kr16": ("kr16_2.urdf", "tool0", [0.3, -1.4, 1.6, 0.3, 0.25, 0.1]),
    "puma": ("puma560_robot.urdf", "link7", [0.3, 0.6, -0.5, 0.2, 0.25, 0.1]),
    "iiwa": ("lbr_iiwa_14_r820.urdf", "tool0", [0.3, 0.5, -0.4, -1.2, 0.3, 0.25, 0.1]),
}
WAY = [0.5, 0.35, -0.3, 0.3, 0.4, -0.5, 0.3]
OFFSETS = np.random.default_rng(1).uniform(-0.028, 0.028, (4, 3))  # within 5 cm


@pytest.fixture(params=ARMS)
def name(request):
    return request.param


@pytest.fixture
def arm(name, tmp_path):
    file, tip, first = ARMS[name]
    joints = [f"j{i + 1}" if name == "puma" else f"joint_a{i + 1}" for i in range(len(first))]
    rows = (f"{each} = {{ velocity = 2.5, acceleration = 10.0, jerk = 100.0 }}" for each in joints)
    (tmp_path / "limits.toml").write_text("\n".join(["[joints]", *rows]))
    urdf = foreign_arms.urdf_in_package("rtb-data", file)
    return lt.Arm.from_urdf(urdf, tip=tip, limits=tmp_path / "limits.toml")


@pytest.fixture
def skill(name, arm):
    first = np.array(ARMS[name][2])
    way = np.array(WAY if len(first) == 7 else [*WAY[:3], *WAY[4:]])
    rng, times = np.random.default_rng(0), np.arange(0.0, 3.0, 0.01)
    rise = minimum_jerk(times / times[-1])[:, None]
    demonstrations = []
    for _ in range(2):
        start, end = rng.normal(0.0, 0.01, (2, len(first)))
        q = first + start + rise * (way + end) + rng.normal(0.0, 5e-4, (len(times), len(first)))
        motion = arm.poses(lt.JointTrajectory(times, q, joint_names=arm.joint_names))
        demonstrations.append(lt.Demonstration(motion))
    return lt.DMP().fit(demonstrations)


def moved(skill, offset):
    plain = skill.generate()
    return skill.generate(goal=(plain.positions[-1] + offset, plain.orientations[-1]))


def test_unchanged_and_moved_goals_are_followed_near_the_demonstrated_joints(arm, skill):
    for offset in ([0.0, 0.0, 0.0], *OFFSETS):
        motion = moved(skill, offset)
        joints = arm.follow(motion)
        assert np.abs(joints.positions - motion.joints.positions).max() < 1.3
        assert np.abs(np.diff(joints.positions, axis=0)).max() < 0.5
        tip, orientations = arm.forward_kinematics(joints.positions)
        assert np.linalg.norm(tip - motion.positions, axis=1).max() < 2e-3
        assert rotations.distance(orientations, motion.orientations).max() < 0.05
        assert np.linalg.norm(tip[[0, -1]] - motion.positions[[0, -1]], axis=1).max() < 1e-5
    assert lt.check_limits(lt.retime(joints, arm.limits), arm.limits).ok


@pytest.mark.parametrize("name", ["puma"], indirect=True)
def test_a_tolerance_that_was_asked_for_holds_and_the_error_names_one_that_works(arm, skill):
    motion = moved(skill, [0.03, 0.02, 0.03])
    with pytest.raises(IkFailure, match=r"--tolerance \S+ allows that") as failure:
        arm.follow(
            motion, options=FollowOptions(position_tolerance=1e-5, orientation_tolerance=1e-5)
        )
    named = str(failure.value).split("--tolerance ")[1].split()[0]
    position, orientation = map(float, named.split(","))
    options = FollowOptions(position_tolerance=position, orientation_tolerance=orientation)
    report = arm.path_report(arm.follow(motion, options=options), motion)
    assert 1e-5 < report.position_error.max() < position
    assert 1e-5 < report.orientation_error.max() < orientation


def test_joints_that_are_on_the_path_are_kept_where_it_would_take_them_away():
    """The least singular value of the pose is 0.004 at the end: exactly on it joints go 0.2 rad."""
    urdf = foreign_arms.urdf_in_package("example-robot-data", "hextilt_flying_arm_5.urdf")
    arm = lt.Arm.from_urdf(urdf, base="flying_arm_5__base_link", tip="flying_arm_5__link_5")
    times = np.linspace(0.0, 2.0, 101)
    first = np.array([0.229, -0.385, -0.767, -0.808, 0.523])
    shown = lt.JointTrajectory(
        times, first + 0.5 * minimum_jerk(times / 2.0)[:, None], joint_names=arm.joint_names
    )
    poses = arm.poses(shown)
    off = np.column_stack([np.sin(times), times - 1.0, np.cos(times)])
    for size in (1e-5, 5e-5):  # the larger cannot be reached exactly
        motion = lt.PoseTrajectory(
            times, poses.positions + size * off, poses.orientations, joints=shown
        )
        followed = arm.follow(motion)
        assert np.abs(followed.positions - shown.positions).max() < 0.1
        report = arm.path_report(followed, motion)
        assert report.position_error.max() < size and report.orientation_error.max() < 1e-3


def test_an_arm_of_two_joints_follows_the_mean_of_its_demonstrations():
    """Means of poses are some micrometres off the surface that two joints reach."""
    urdf = foreign_arms.urdf_in_package("example-robot-data", "double_pendulum_continuous.urdf")
    limits = lt.arm.JointLimits(
        ["joint1", "joint2"], *2.0 * np.array([[-3.0] * 2, [3.0] * 2, [1.0] * 2])
    )
    arm = lt.Arm.from_urdf(urdf, base="base_link", tip="link2", limits=limits)
    rng = np.random.default_rng(3)
    rise = minimum_jerk(np.linspace(0.0, 1.0, 101))[:, None]
    shown = []
    for _ in range(3):
        first, way = rng.normal([0.3, 0.6], 0.05), rng.normal([0.5, -0.4], 0.05)
        q = lt.JointTrajectory(
            np.linspace(0.0, 2.0, 101), first + rise * way, joint_names=arm.joint_names
        )
        shown.append(lt.Demonstration(arm.poses(q)))
    motion = lt.learn(shown).generate()
    followed = arm.follow(motion)
    assert np.abs(followed.positions - motion.joints.positions).max() < 0.02
    report = arm.path_report(followed, motion)
    assert report.position_error.max() < 1e-3 and report.orientation_error.max() < 1e-2

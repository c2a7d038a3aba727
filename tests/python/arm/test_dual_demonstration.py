"""Recordings of two arms: reading, the object and the relative motion, learning, the other base."""

import numpy as np
import pytest
from refusals import refused

import leadthrough as lt
from leadthrough import rotations
from leadthrough.arm import DualDemonstration, left_tip, right_tip, tips_of
from leadthrough.errors import FitError, InvalidInput

BASE = ((0.02, -0.8, 0.01), tuple(rotations.exp([[0.05, -0.03, 0.1]])[0]))
DOWN = np.array([0.0, 1.0, 0.0, 0.0])
GRASPS = (((0.0, 0.15, 0.0), DOWN), ((0.0, -0.15, 0.0), DOWN))


@pytest.fixture(scope="module")
def pair(panda):
    return lt.DualArm(panda, panda, BASE)


def carried(tilt=0.2, yaw=0.2, samples=201, goal=0.0):
    u = np.linspace(0.0, 1.0, samples)
    turn = 2 * np.pi * u
    path = [0.45 + 0.06 * np.sin(turn), -0.4 + goal * u, 0.35 + 0.1 * np.sin(np.pi * u)]
    angles = [tilt * np.sin(turn), tilt * (np.cos(turn) - 1.0), yaw * np.sin(np.pi * u)]
    return lt.PoseTrajectory(4.0 * u, np.transpose(path), rotations.exp(np.transpose(angles)))


@pytest.fixture(scope="module")
def recorded(pair):
    return pair.follow(carried(), GRASPS)


def test_object_and_relative_motion_are_those_that_were_followed(pair, recorded):
    shown = pair.demonstration(lt.Demonstration(recorded, "tray"))
    found = shown.object(GRASPS)
    motion = carried()
    assert found.name == "tray"
    assert found.joints.joint_names == pair.joint_names
    assert np.abs(found.motion.positions - motion.positions).max() < 1e-5
    assert rotations.distance(found.motion.orientations, motion.orientations).max() < 1e-5
    held = rotations.compose([[0.0, -1.0, 0.0, 0.0]], [DOWN])
    assert np.abs(shown.relative.positions - (0.0, 0.3, 0.0)).max() < 1e-5
    assert rotations.distance(shown.relative.orientations[:1], held)[0] < 1e-5


def test_an_object_is_in_the_middle_between_what_the_hands_say(pair):
    left = lt.PoseTrajectory([0.0, 1.0], [[0.5, 0.0, 0.3]] * 2, [DOWN] * 2)
    turn = rotations.compose(rotations.exp([[0.0, 0.0, 0.2]]), [DOWN])
    right = lt.PoseTrajectory([0.0, 1.0], [[0.51, -0.3, 0.3]] * 2, np.repeat(turn, 2, axis=0))
    grasps = (((0.0, 0.0, 0.0), DOWN), ((0.0, -0.3, 0.0), DOWN))
    found = DualDemonstration(left, right).object(grasps).motion
    middle = rotations.exp([[0.0, 0.0, 0.1]])
    assert rotations.distance(found.orientations[:1], middle)[0] < 1e-9
    by_right = np.array([0.51 - 0.3 * np.sin(0.2), -0.3 + 0.3 * np.cos(0.2), 0.3])
    assert found.positions[0] == pytest.approx(0.5 * np.add(by_right, (0.5, 0.0, 0.3)), abs=1e-9)


def test_a_carry_is_learned_and_followed_to_a_new_goal_in_the_demonstrated_posture(pair):
    """Without grasps the object's frame is that of the left tip."""
    shown = [
        pair.demonstration(pair.follow(carried(goal=goal), GRASPS)) for goal in (0.0, 0.03, 0.06)
    ]
    grasps = shown[0].grasps
    skill = lt.DMP().fit([each.object(grasps) for each in shown])
    end = shown[1].left.positions[-1], shown[1].left.orientations[-1]
    motion = skill.generate(goal=end)
    joints = pair.follow(motion, grasps, scene=[])
    assert np.abs(joints.positions[-1] - shown[1].joints.positions[-1]).max() < 0.2
    tips, _ = pair.forward_kinematics(joints.positions)
    assert np.linalg.norm(tips[-1, 1] - shown[1].right.positions[-1]) < 1e-3


def test_tips_on_two_clocks_are_put_on_the_left_one():
    left = lt.PoseTrajectory(np.arange(5.0), np.zeros((5, 3)), [DOWN] * 5)
    ramp = np.arange(8.0)[:, None] * (0.5, 0.0, 0.0)
    right = lt.PoseTrajectory(0.5 * np.arange(8.0) + 0.75, ramp, [DOWN] * 8)
    shown = DualDemonstration(left, right)
    assert shown.left.times.tolist() == shown.right.times.tolist() == [1.0, 2.0, 3.0, 4.0]
    np.testing.assert_allclose(shown.right.positions[:, 0], shown.left.times - 0.75)
    late = lt.PoseTrajectory(right.times + 9.0, right.positions, right.orientations)
    refused("right: expected times that the left motion covers", DualDemonstration, left, late)
    refused("left: expected a PoseTrajectory", DualDemonstration, None, right)


@pytest.mark.parametrize("format", ["csv", "npz"])
def test_joints_of_two_arms_are_read_back(pair, recorded, tmp_path, format):
    path = tmp_path / f"both.{format}"
    lt.write_motion(recorded, path)
    again = pair.joints_of(lt.read_motion(path))
    assert again.joint_names == pair.joint_names
    np.testing.assert_allclose(again.positions, recorded.positions, atol=1e-12)


def test_joints_of_other_numbers_of_arms_are_still_asked_for(tmp_path):
    path = tmp_path / "three.csv"
    names = [f"{arm}_joint{i}" for arm in ("left", "right", "torso") for i in (1, 2)]
    path.write_text(f"time,{','.join(names)}\n0,1,1,1,1,1,1\n1,1,1,1,1,1,1\n", encoding="utf-8")
    with pytest.raises(InvalidInput, match="several fit"):
        lt.read_motion(path)


def test_a_recording_with_names_of_motors_and_grippers_has_the_joints_of_both_arms(pair, recorded):
    names = [f"{name}.pos" for name in reversed(recorded.joint_names)]
    rows = np.hstack([recorded.positions[:, ::-1], np.ones((len(recorded), 2))])
    names += ["left_gripper.pos", "right_gripper.pos"]
    found = pair.joints_of(lt.JointTrajectory(recorded.times, rows, joint_names=names))
    np.testing.assert_array_equal(found.positions, recorded.positions)
    refused(
        "trajectory: expected the joints left_panda_joint1",
        pair.joints_of,
        lt.JointTrajectory(recorded.times, rows[:, 1:], joint_names=names[1:]),
    )


def test_poses_of_two_tips_are_read_by_their_columns(pair, recorded, tmp_path):
    positions, orientations = pair.forward_kinematics(recorded.positions)
    axes = ["x", "y", "z", "qw", "qx", "qy", "qz"]
    names = ["time", *(f"{side}_{axis}" for side in ("left", "right") for axis in axes)]
    rows = np.concatenate([positions, orientations], axis=2).reshape(len(recorded), -1)
    path = tmp_path / "tips.csv"
    table = np.column_stack([recorded.times, rows])
    np.savetxt(path, table, delimiter=",", header=",".join(names), comments="", fmt="%.17g")
    with pytest.raises(InvalidInput, match="several fit, left_x, left_y, left_z"):
        lt.read_motion(path)
    left, right = (
        lt.read_motion(
            path,
            columns={
                "positions": [f"{side}_{axis}" for axis in axes[:3]],
                "orientations": [f"{side}_{axis}" for axis in axes[3:]],
            },
        )
        for side in ("left", "right")
    )
    shown, ours = DualDemonstration(left, right), pair.demonstration(recorded)
    np.testing.assert_allclose(shown.relative.positions, ours.relative.positions, atol=1e-12)


def two_tips(rng):
    """The right tip is the left one and an offset, to 0.1 mm."""
    u = np.linspace(0.0, 1.0, 101)
    s = (u**3 * (10 - 15 * u + 6 * u**2))[:, None]
    start, goal = (0.4, 0.2, 0.3) + 0.03 * rng.normal(size=3), 0.5 + 0.05 * rng.normal(size=3)
    bump = 0.05 * rng.normal(size=3) * np.sin(np.pi * u)[:, None]
    left = start + s * (goal - start) + bump
    right = left + (0.0, -0.3, 0.05) + 1e-4 * rng.normal(size=left.shape)
    still = [DOWN] * 101
    return DualDemonstration(
        lt.PoseTrajectory(2.0 * u, left, still), lt.PoseTrajectory(2.0 * u, right, still)
    )


def test_the_right_tip_follows_a_conditioned_left_one_within_a_millimetre():
    rng = np.random.default_rng(1)
    shown = [two_tips(rng) for _ in range(12)]
    skill = lt.ProMP().fit([each.middle_and_difference for each in shown])
    for _ in range(3):
        wanted = two_tips(rng)
        moved = skill
        for k in (30, 70):
            moved = moved.condition_task(2.0 * k / 100, wanted.left.positions[k], left_tip)
        left, right = tips_of(moved.generate(dt=0.02))
        assert np.linalg.norm(left.at(0.6) - wanted.left.positions[30]) < 1e-6
        apart = right.positions - left.positions - (0.0, -0.3, 0.05)
        assert np.linalg.norm(apart, axis=1).max() < 1e-3


def test_tips_of_middle_and_difference_are_the_tips_again():
    shown = two_tips(np.random.default_rng(0))
    both = shown.middle_and_difference
    for motion, tip, task in zip(
        tips_of(both), (shown.left, shown.right), (left_tip, right_tip), strict=True
    ):
        np.testing.assert_allclose(motion.positions, tip.positions, atol=1e-15)
        value, jacobian = task(both.positions[3])
        np.testing.assert_allclose(value, tip.positions[3], atol=1e-15)
        np.testing.assert_array_equal(jacobian @ both.positions[3], value)
    refused("motion: expected a Trajectory in 6-D", tips_of, lt.Trajectory([0.0], [[0.0] * 3]))


def noisy(joints, rng):
    rows = joints.positions + 1e-3 * rng.normal(size=joints.positions.shape)
    return lt.JointTrajectory(joints.times, rows, joint_names=joints.joint_names)


@pytest.fixture(scope="module")
def misplaced(panda):
    return lt.DualArm(panda, panda, ((0.2, -0.6, -0.1), rotations.exp([[-0.2, 0.2, -0.2]])[0]))


def test_the_other_base_is_found_from_what_both_hold(pair, misplaced):
    rng = np.random.default_rng(2)
    joints = pair.follow(carried(tilt=0.1, samples=2001), GRASPS)
    scores = []
    for _ in range(4):
        found = misplaced.located([noisy(joints, rng)])
        away = np.subtract(found.base[0], BASE[0])
        turn = rotations.log(rotations.compose([found.base[1]], rotations.inverse([BASE[1]])))[0]
        assert np.linalg.norm(away) < 2e-3
        assert np.linalg.norm(turn) < np.radians(0.2)
        assert found.noise == pytest.approx(1e-3, rel=0.2)
        error = np.concatenate([away, turn])
        scores.append(error @ np.linalg.solve(found.covariance, error))
    assert 2.0 < np.mean(scores) < 14.0  # of six degrees of freedom


def test_demonstrations_with_other_grasps_are_taken_together(pair, misplaced, recorded):
    other = (((0.0, 0.12, 0.02), DOWN), ((0.0, -0.15, 0.0), DOWN))
    found = misplaced.located([recorded, pair.follow(carried(), other)])
    assert np.linalg.norm(np.subtract(found.base[0], BASE[0])) < 1e-5


def test_a_base_that_the_recording_leaves_open_is_refused(pair, misplaced):
    rng = np.random.default_rng(3)
    joints = pair.follow(carried(tilt=0.0, yaw=0.4), GRASPS)
    for recording in (joints, noisy(joints, rng)):
        with pytest.raises(FitError, match=r"open by .* mm along \(-?0.0., -?0.0., -?1.00\)"):
            misplaced.located([recording])
    with pytest.raises(InvalidInput, match="demonstrations: expected at least one"):
        misplaced.located([])

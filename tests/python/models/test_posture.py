"""The joints that an arm was shown with: every skill keeps them by phase, in files too."""

from dataclasses import replace

import numpy as np
import pytest
from kinds import kind
from motions import arm, minimum_jerk
from refusals import refused

import leadthrough as lt
from leadthrough.errors import InvalidInput
from leadthrough.models import Framed
from leadthrough.preprocess import (
    align_by_arc_length,
    align_by_time_warping,
    clean,
    join,
    sample_evenly,
    segment,
    smooth_by_spline,
)

ARM = arm("panda")
U = np.linspace(0.0, 1.0, 121)
RISE = minimum_jerk(U)
HOME = np.array([0.3, -0.7, -0.6, -2.3, 0.4, 1.9, -0.5])
WAY = np.array([0.5, 0.3, -0.4, 0.4, -0.3, 0.2, 0.6])


def shown(first=HOME, way=WAY, duration=2.0):
    return lt.JointTrajectory(
        duration * U, first + np.outer(RISE, way), joint_names=ARM.joint_names
    )


def poses(count=3):
    """Poses with the joints behind them, a little different each time."""
    rng = np.random.default_rng(0)
    return [ARM.poses(shown(HOME + rng.normal(0.0, 0.01, 7))) for _ in range(count)]


def points():
    return [lt.Trajectory(p.times, p.positions, joints=p.joints) for p in poses()]


LEARNERS = {
    "DMP": kind("DMP"),
    "DMP of poses": kind("DMP", "poses"),
    "DMP of poses, lifted": kind("DMP", "poses", orientation="lifted"),
    "RhythmicDMP": kind("RhythmicDMP"),
    "RhythmicDMP of poses": kind("RhythmicDMP", "poses"),
    "ProMP": kind("ProMP", "poses"),
    "ProMP of points": kind("ProMP"),
    "GMR": kind("GMR", "poses"),
    "TaskGMR": kind("TaskGMR", "poses"),
    "FastMarching": kind("FastMarching", "poses"),
    "FastMarching of points": kind("FastMarching"),
    "Framed": kind("DMP", "poses"),
}


def learner(name):
    """A model, and a function that returns what it learns."""
    model = LEARNERS[name].build()
    return (
        Framed(model) if name == "Framed" else model,
        poses if LEARNERS[name].motion == "poses" else points,
    )


@pytest.mark.filterwarnings("ignore:demonstrations. periods")  # a rhythm of a line, bent to close
@pytest.mark.parametrize("name", LEARNERS)
def test_a_skill_keeps_the_joints_by_phase_and_in_its_file(name, tmp_path):
    model, demonstrations = learner(name)
    given = demonstrations()
    skill = model.fit(given)
    made = skill.generate()
    assert made.joints.joint_names == ARM.joint_names
    assert np.array_equal(made.joints.times, made.times)
    mean = np.mean([each.joints.positions for each in given], axis=0)
    rounds = name.startswith("Rhythmic")  # rhythms end where they begin
    np.testing.assert_allclose(made.joints.positions[0], mean[0], atol=0.02)
    np.testing.assert_allclose(made.joints.positions[-1], mean[0 if rounds else -1], atol=0.02)
    skill.save(tmp_path / "skill.npz")
    again = lt.load_skill(tmp_path / "skill.npz").generate()
    assert again.joints.positions.tobytes() == made.joints.positions.tobytes()
    assert again.joints.joint_names == ARM.joint_names


@pytest.mark.filterwarnings("ignore:demonstrations. periods")  # a rhythm of a line, bent to close
@pytest.mark.parametrize("name", LEARNERS)
def test_motions_without_joints_have_none_afterwards(name):
    model, demonstrations = learner(name)
    bare = [replace(motion, joints=None) for motion in demonstrations()]
    assert model.fit(bare).generate().joints is None


def test_a_new_goal_leaves_the_joints_of_the_start():
    skill = kind("DMP", "poses").build().fit(poses())
    plain = skill.generate()
    goal = plain.positions[-1] + [0.05, 0.0, 0.03], plain.orientations[-1]
    moved = skill.generate(goal=goal)
    np.testing.assert_allclose(moved.joints.positions[0], plain.joints.positions[0], atol=1e-12)


def test_a_library_blends_the_joints_of_the_targets_around():
    library = lt.SkillLibrary()
    for target, offset in ((0.0, 0.0), (1.0, 0.2)):
        skill = kind("DMP", "poses").build().fit([ARM.poses(shown(HOME + offset))])
        library = library.with_skill(skill, task="t", subtask="s", target=[target])
    between = library.interpolated("t", "s", [0.5]).generate()
    np.testing.assert_allclose(between.joints.positions[0], HOME + 0.1, atol=1e-3)


TURN, ELBOW = np.eye(7)[4] * 2.0 * np.pi, np.eye(7)[2] * 2.5


@pytest.mark.parametrize("offsets", [(0.0, TURN), (ELBOW, 0.0, 0.0)], ids=["turn", "elbow"])
def test_whole_turns_make_no_difference_and_another_elbow_is_not_averaged(offsets):
    given = [
        lt.Trajectory(2.0 * U, np.outer(U, [1, 0, 0]), joints=shown(HOME + offset))
        for offset in offsets
    ]
    joints = kind("DMP").build().fit(given).generate().joints
    np.testing.assert_allclose(joints.positions[0], HOME, atol=1e-9)


def test_a_rhythm_goes_on_turning_where_it_was_shown_to():
    rows = np.column_stack([2.0 * np.pi * U, 0.1 * U])
    ring = np.column_stack([np.cos(2.0 * np.pi * U), np.sin(2.0 * np.pi * U)])
    stood = lt.JointTrajectory(U, rows, joint_names=("a", "b"))
    skill = kind("RhythmicDMP").build().fit([lt.Trajectory(U, ring, joints=stood)])
    joints = skill.generate(duration=3.0, dt=0.01).joints
    np.testing.assert_allclose(joints.positions[:, 0], 2.0 * np.pi * joints.times, atol=1e-6)
    assert np.abs(np.diff(joints.positions, axis=0)).max() < 0.1  # joint b's gap is closed


def fits(motion):
    """Whether the motion's joints still bring the tip to its samples."""
    assert motion.joints is not None
    assert np.array_equal(motion.joints.times, motion.times)
    return np.abs(ARM.poses(motion.joints).positions - motion.positions).max() < 2e-3


def test_preparing_a_demonstration_takes_its_joints_along():
    first = poses(1)[0]
    still = np.repeat(first.joints.positions[:1], 60, axis=0)
    longer = lt.JointTrajectory(
        np.arange(181) / 60.0,
        np.vstack([still, first.joints.positions]),
        joint_names=ARM.joint_names,
    )
    recorded = ARM.poses(longer)
    assert fits(clean(recorded, longest_pause=0.2)[0].motion)
    assert fits(segment(recorded)[0].motion)
    assert fits(sample_evenly(recorded, rate=35.0).motion)
    assert fits(smooth_by_spline(recorded).motion)
    for align in (align_by_time_warping, align_by_arc_length):
        assert all(fits(each.motion) for each in align([first, recorded]))
    after = ARM.poses(shown(HOME + WAY, -WAY))
    assert fits(join([ARM.poses(shown()), after]))


def test_joints_recorded_beside_the_tip_are_taken_at_its_times():
    slow = lt.JointTrajectory(2.0 * U[::4], shown().positions[::4], joint_names=ARM.joint_names)
    tip = ARM.poses(shown())
    bare = lt.PoseTrajectory(tip.times, tip.positions, tip.orientations)
    demonstration = lt.Demonstration(bare, "reach", joints=slow)
    assert demonstration.name == "reach"
    assert demonstration.joints is demonstration.motion.joints
    assert fits(demonstration.motion)
    assert bare.joints is None
    assert lt.Demonstration(shown()).joints.positions.shape == (121, 7)


def test_joints_that_do_not_go_with_the_motion_are_refused():
    tip = ARM.poses(shown())
    with pytest.raises(InvalidInput, match="joints: expected the motion's times, 0 to 2 s"):
        lt.Demonstration(tip, joints=shown(duration=3.0))
    with pytest.raises(InvalidInput, match="joints: expected 121 samples"):
        lt.Trajectory(U, np.zeros((121, 3)), joints=lt.JointTrajectory([0.0], [[0.0]]))
    refused("joints: the motion consists of joints", lt.Demonstration, shown(), joints=shown())
    for wrong in (np.zeros((121, 7)), tip):
        refused("joints: expected a JointTrajectory", lt.Demonstration, tip, joints=wrong)
        with pytest.raises(InvalidInput, match="joints: expected a JointTrajectory"):
            lt.Trajectory(U, np.zeros((121, 3)), joints=wrong)

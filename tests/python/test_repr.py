"""Every public result shows itself in one to five lines."""

import numpy as np
import pytest

import leadthrough as lt
from leadthrough import planning, trajectories
from leadthrough.arm import JointState, PoseTask, PostureTask, TaskStack
from leadthrough.models import Frame, choose_components, infer, kmeans
from leadthrough_studies.damped_least_squares import follow_path

T = np.linspace(0.0, 2.0, 100)
S = lt.trajectories.minimum_jerk_time_scaling(T / 2.0)
HOME = np.array([0.3, -1.4, 1.6, -1.8, -1.5, 0.2])


@pytest.fixture(scope="module")
def results():
    """One of each kind of result, by what made it."""
    arm = lt.Arm.load("ur3")
    joints = lt.JointTrajectory(T, HOME + np.outer(S, np.full(6, 0.3)), joint_names=arm.joint_names)
    poses = arm.poses(joints)
    shown = [lt.Demonstration(poses, "one"), lt.Demonstration(poses[:90], "two")]
    box = lt.Box((0.1, 0.1, 0.1), (0.5, 0.5, 0.5))
    dmp, promp = lt.DMP().fit(shown), lt.ProMP().fit(shown)
    grid = lt.Grid((0.0, 0.0), 0.1, (20, 20))
    plan = planning.plan(np.ones((20, 20)), grid, (0.2, 0.2), (1.5, 1.5))
    position, orientation = arm.forward_kinematics(HOME)
    stack = TaskStack(arm, [PoseTask(position, orientation), PostureTask(HOME)])
    report = arm.check(joints, [box])
    return [
        arm, arm.limits, joints, poses, *shown, dmp, promp, box, grid, plan,
        lt.Sphere(0.1, (0, 0, 0)), lt.Capsule(0.1, 0.2, (0, 0, 0)),
        arm.inverse_kinematics(position), arm.inverse_kinematics_batch(poses.positions),
        arm.path_report(arm.follow(poses), poses), report, report.itself, report.closest,
        arm.collision_pairs, lt.check_limits(joints, arm.limits),
        lt.check_limits(joints, arm.limits).velocity, JointState(HOME, 0 * HOME, 0 * HOME),
        PoseTask(position, orientation), stack,
        follow_path(arm, poses, q0=HOME), lt.DifferentialIk(arm),
        kmeans(poses.positions, 3, seed=0), choose_components(poses.positions, at_most=2),
        lt.GMR(components=2).fit(shown).mixture, Frame.of_sample(poses, 0),
        infer(poses[:20], [promp]),
        lt.SkillLibrary().with_skill(dmp, task="t", subtask="s", target=(0.0,)),
        lt.preprocess.clean(poses)[1], trajectories.natural_cubic(T[::20], poses.positions[::20]),
        trajectories.minimum_jerk((0.0, 0.0), (1.0, 1.0), duration=1.0), lt.Event(1.0, "close"),
    ]  # fmt: skip


def test_results_are_told_in_one_to_five_lines(results):
    for each in results:
        text = repr(each)
        lines = text.splitlines()
        assert 1 <= len(lines) <= 5, text
        assert max(map(len, lines)) <= 100, text
        assert text.startswith(type(each).__name__), text

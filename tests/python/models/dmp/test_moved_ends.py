"""Starts and goals that are moved: they enter as the demonstration moves, also while it runs."""

import numpy as np
import pytest

import leadthrough as lt
from leadthrough import rotations
from leadthrough.trajectories import minimum_jerk_time_scaling

TIMES = np.linspace(0.0, 4.0, 401)
HELD = TIMES > 1.25  # after a reach of 1.2 s


def reach(times=TIMES, *, length=0.4):
    """0.4 m along x within 1.2 s; held after it."""
    done = minimum_jerk_time_scaling(np.clip(times / 1.2, 0.0, 1.0))
    return lt.Trajectory(times, np.outer(done, [length, 0.0, 0.0]))


def pose_reach(times=TIMES):
    """The reach, which also turns by 46 degrees about z."""
    done = minimum_jerk_time_scaling(np.clip(times / 1.2, 0.0, 1.0))
    turned = rotations.exp(np.outer(done, [0.0, 0.0, np.radians(46.0)]))
    return lt.PoseTrajectory(times, reach(times).positions, turned)


def as_joints(motion):
    return lt.JointTrajectory(motion.times, motion.positions)


def fitted(motion, model=None):
    return (model or lt.DMP()).fit([motion])


def about_z(degrees):
    return rotations.exp(np.radians([[0.0, 0.0, degrees]]))[0]


def yaw(orientations):
    """Degrees about z, counted past half a turn."""
    return np.degrees(rotations.lift(orientations)[:, 2])


@pytest.mark.parametrize("kind", [lambda m: m, as_joints], ids=["points", "joints"])
@pytest.mark.parametrize("goal", [0.2, 0.6])
def test_moved_goal_is_neither_passed_nor_approached_during_the_hold(kind, goal):
    made = fitted(kind(reach())).generate(goal=(goal, 0.0, 0.0), duration=4.0)
    x = made.positions[:, 0]
    assert x.max() <= goal + 1e-3
    assert np.ptp(x[HELD]) <= 1e-3


@pytest.mark.parametrize("kind", [lambda m: m, as_joints], ids=["points", "joints"])
def test_moved_start_is_left_as_the_demonstration_leaves_its_own(kind):
    done = minimum_jerk_time_scaling(np.clip((TIMES - 2.0) / 1.2, 0.0, 1.0))
    shown = lt.Trajectory(TIMES, np.outer(done, [0.4, 0.0, 0.0]))
    made = fitted(kind(shown)).generate(start=(0.1, 0.1, 0.0), duration=4.0)
    assert np.abs(made.positions[TIMES < 1.95] - (0.1, 0.1, 0.0)).max() <= 1e-3
    np.testing.assert_allclose(made.positions[-1], shown.positions[-1], atol=1e-9)


@pytest.mark.parametrize("goal", [23.0, 92.0])
def test_turned_goal_is_neither_passed_nor_approached_during_the_hold(goal):
    skill = fitted(pose_reach(), lt.DMP())
    made = skill.generate(goal=((0.2, 0.0, 0.0), about_z(goal)), duration=4.0)
    turned = yaw(made.orientations)
    assert turned.max() <= goal + 0.1
    assert np.ptp(turned[HELD]) <= 0.1
    assert np.ptp(made.positions[HELD], axis=0).max() <= 1e-3


def test_tool_that_hardly_turns_takes_a_turned_goal_with_its_way():
    shown = pose_reach()
    stiff = lt.PoseTrajectory(TIMES, shown.positions, np.repeat([[1.0, 0, 0, 0]], 401, axis=0))
    made = fitted(stiff, lt.DMP()).generate(goal=((0.4, 0, 0), about_z(40.0)), duration=4.0)
    assert np.ptp(yaw(made.orientations)[HELD]) <= 0.1
    turning = lt.PoseTrajectory(TIMES, np.zeros((401, 3)), shown.orientations)
    made = fitted(turning, lt.DMP()).generate(goal=((0.1, 0, 0), about_z(46.0)), duration=4.0)
    assert np.ptp(made.positions[HELD], axis=0).max() <= 1e-3


def hook(times=TIMES):
    s = minimum_jerk_time_scaling(times / times[-1])
    return lt.Trajectory(times, np.column_stack([0.3 * s, 0.1 * np.sin(2.5 * s), 0.2 * s**2]))


@pytest.mark.parametrize("phase", [0.5, 0.7, 0.9])
@pytest.mark.parametrize("shown", [hook(), as_joints(hook())], ids=["points", "joints"])
def test_goal_moved_on_the_way_is_reached_in_time(shown, phase):
    """With springs alone, 1, 10 and 65 % of the way are missing."""
    skill = fitted(shown)
    moved = np.array([0.1, -0.05, 0.02])
    goal = shown.positions[-1] + moved
    state = skill.step(skill.begin(), 4.0 * phase)
    state = skill.step(state, 4.0 * (1.0 - phase), goal=goal)
    assert state.phase == pytest.approx(1.0)
    assert np.linalg.norm(state.position - goal) <= 0.01 * np.linalg.norm(moved)


@pytest.mark.parametrize("orientation", ["anchored", "lifted", "log", "euler"])
@pytest.mark.parametrize("phase", [0.5, 0.7, 0.9])
def test_goal_turned_on_the_way_is_reached_in_time(phase, orientation):
    s = minimum_jerk_time_scaling(TIMES / 4.0)
    turned = rotations.exp(np.outer(s, [0.3, 0.8, 0.5]))
    shown = lt.PoseTrajectory(TIMES, hook().positions, turned)
    skill = fitted(shown, lt.DMP(orientation=orientation))
    goal = rotations.compose(about_z(20.0)[None], turned[-1:])[0]
    state = skill.step(skill.begin(), 4.0 * phase)
    state = skill.step(state, 4.0 * (1.0 - phase), goal=(shown.positions[-1] + 0.05, goal))
    left = rotations.distance(state.orientation[None], goal[None])[0]
    assert np.degrees(left) <= 0.01 * 20.0
    assert np.abs(state.position - shown.positions[-1] - 0.05).max() <= 0.01 * 0.05


def test_goal_moved_early_is_reached_with_the_motion_and_held():
    skill = fitted(pose_reach(), lt.DMP())
    goal = ((0.3, 0.1, 0.0), about_z(80.0))
    state, rows = skill.step(skill.begin(), 0.2), []
    for _ in range(380):
        state = skill.step(state, 0.01, goal=goal)
        rows.append(state.pose)
    held = np.array(rows)[np.arange(0.21, 4.005, 0.01) > 2.0]
    assert np.ptp(held, axis=0).max() <= 2e-3


def test_goal_of_the_first_step_is_that_of_the_query():
    skill = fitted(pose_reach(), lt.DMP())
    goal = ((0.3, 0.1, 0.0), about_z(80.0))
    stepped = skill.step(skill.begin(duration=4.0), 0.5, goal=goal)
    asked = skill.step(skill.begin(goal=goal, duration=4.0), 0.5)
    np.testing.assert_allclose(stepped.pose, asked.pose, atol=1e-12)


def test_goal_that_moves_all_the_time_is_followed_without_jumps():
    """Also past the end. Accelerations stay those of a smooth motion, and it arrives."""
    skill, dt = fitted(pose_reach(), lt.DMP()), 0.002
    state, velocities, spins = skill.begin(), [], []
    for i in range(3300):
        moved = 0.05 * np.sin(0.004 * min(i, 2600))
        goal = ((0.4 + moved, moved, 0.0), about_z(46.0 + 400.0 * moved))
        state = skill.step(state, dt, goal=goal)
        velocities.append(state.velocity)
        spins.append(state.angular_velocity)
    still = np.abs(np.diff(velocities, axis=0)).max() / dt
    turning = np.abs(np.diff(spins, axis=0)).max() / dt
    assert still <= 2.5  # m/s^2; 1.6 as demonstrated
    assert turning <= 10.0  # rad/s^2; 3.2 as demonstrated, and the goal swings by 20 degrees
    np.testing.assert_allclose(state.position, goal[0], atol=1e-4)


def test_course_of_a_goal_that_moves_all_the_time_stays_short():
    skill = fitted(hook())
    state = skill.begin()
    for i in range(2000):
        state = skill.step(state, 0.004, goal=(0.3 + 1e-4 * i, 0.1, 0.2))
        assert len(state.course.breaks) <= 110
    assert len(state.course.breaks) <= 10


def highest(motion):
    return np.linalg.norm(np.diff(motion.positions, axis=0), axis=1).max() / motion.times[1]


def test_goal_moved_along_the_way_is_not_reached_faster_than_a_person_showed():
    skill = fitted(hook())
    made = skill.generate(goal=2.0 * hook().positions[-1], dt=0.002)
    assert highest(made) <= 1.301 * highest(skill.generate(dt=0.002))
    assert made.duration > 1.4 * skill.duration
    assert skill.default_duration(goal=2.0 * hook().positions[-1]) == made.duration
    asked = skill.generate(goal=2.0 * hook().positions[-1], duration=4.0)
    assert asked.duration == 4.0
    across = skill.generate(goal=hook().positions[-1] + (0.0, 0.0, 0.02))
    assert across.duration == skill.duration


def test_goal_turned_along_the_way_is_not_reached_faster_than_a_person_showed():
    turned = rotations.exp(
        np.outer(minimum_jerk_time_scaling(TIMES / 4.0), [0.0, 0.0, np.pi / 2.0])
    )
    skill = fitted(lt.PoseTrajectory(TIMES, hook().positions, turned), lt.DMP())
    plain, made = (
        skill.generate(**query, dt=0.002)
        for query in ({}, {"goal": (hook().positions[-1], about_z(179.9))})
    )
    spins = [
        rotations.distance(m.orientations[1:], m.orientations[:-1]).max() / m.times[1]
        for m in (plain, made)
    ]
    assert spins[1] <= 1.301 * spins[0]
    assert made.duration == pytest.approx(4.0 * 2.0 / 1.3, rel=0.02)


def test_fastest_joint_sets_the_pace_of_joints():
    joints = lt.JointTrajectory(TIMES, hook().positions * [10.0, 1.0, 1.0])
    skill = fitted(joints)
    slow_one = skill.generate(goal=joints.positions[-1] + (0.0, 1.0, 0.0))
    assert slow_one.duration == 4.0  # the second joint still moves less than the first
    made = skill.generate(goal=2.0 * joints.positions[-1], dt=0.002)
    peak, shown = (np.abs(m.velocities).max() for m in (made, skill.generate(dt=0.002)))
    assert peak <= 1.301 * shown


def test_slow_motions_and_tools_that_were_shown_still_are_not_held_back():
    slow = lt.Trajectory(TIMES, 0.05 * hook().positions)
    assert fitted(slow).generate(goal=0.1 * hook().positions[-1]).duration == 4.0
    still = lt.PoseTrajectory(TIMES, hook().positions, np.repeat([[1.0, 0, 0, 0]], 401, axis=0))
    skill = fitted(still, lt.DMP())
    assert skill.generate(goal=(hook().positions[-1], about_z(90.0))).duration == 4.0

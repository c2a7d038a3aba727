"""Promises of corrected skills, for every model and type of motion."""

import kinds
import numpy as np
import pytest
from kinds import kind
from motions import arm
from refusals import refused

import leadthrough as lt
from leadthrough import rotations
from leadthrough.preprocess import arc_length

# Of 0.03, as the point lies between two samples, m.
NEAR = 3e-4


@pytest.fixture(params=kinds.KINDS)
def role(request):
    return request.param


@pytest.fixture
def skill(role):
    return kinds.learned(role)


def moved_point(motion, fraction, offset=0.03):
    """The time at a fraction of a motion, and a place beside the motion there."""
    time = fraction * motion.duration
    if isinstance(motion, lt.PoseTrajectory):
        position, q = motion.at(time)
        turned = rotations.compose(rotations.exp([[0.0, 0.3, 0.0]]), q[None])[0]
        return time, (position + np.array([0.0, offset, 0.0]), turned)
    return time, motion.at(time) + offset * np.eye(motion.positions.shape[1])[1]


def errors(motion, time, place):
    """Of the position and the orientation from a place at a time."""
    if isinstance(motion, lt.PoseTrajectory):
        position, q = motion.at(time)
        return np.linalg.norm(position - place[0]), rotations.distance(q[None], place[1][None])[0]
    return np.linalg.norm(motion.at(time) - place), 0.0


def far(skill, motion, time):
    """The samples farther than a fifth of the path away from a time."""
    covered = arc_length(motion.positions) / arc_length(motion.positions)[-1]
    if hasattr(skill, "period"):
        covered = motion.times / motion.times[-1]
    apart = np.abs(covered - np.interp(time, motion.times, covered))
    return (np.minimum(apart, 1.0 - apart) if hasattr(skill, "period") else apart) > 0.2


def test_the_point_is_met_and_the_rest_of_the_path_stays(skill):
    before = skill.generate()
    for fraction in (0.35, 0.6):
        time, place = moved_point(before, fraction)
        after = skill.corrected(time, place).generate()
        gap, turn = errors(after, time, place)
        assert gap < NEAR
        assert turn < 10.0 * NEAR  # of 0.3 rad
        kept = far(skill, before, time)
        assert kept.any()
        np.testing.assert_array_equal(after.positions[kept], before.positions[kept])
        ends = [0, -1]
        np.testing.assert_allclose(after.positions[ends], before.positions[ends], atol=1e-15)
        assert after.events == before.events


def test_all_of_several_corrections_are_met_and_undone_in_turn(skill, tmp_path):
    before = skill.generate()
    first, second = moved_point(before, 0.4), moved_point(before, 0.55, -0.02)
    once = skill.corrected(*first)
    twice = once.corrected(*second)
    for time, place in (first, second):
        assert errors(twice.generate(), time, place)[0] < NEAR
    again = twice.undone().generate()
    np.testing.assert_array_equal(again.positions, once.generate().positions)
    none = twice.undone().undone()
    none.save(tmp_path / "skill.npz")
    for each in (none, lt.load_skill(tmp_path / "skill.npz")):
        np.testing.assert_array_equal(each.generate().positions, before.positions)


def test_a_correction_moves_along_with_a_new_goal_and_is_saved(skill, role, tmp_path):
    query = kinds.KINDS[role].query
    before = skill.generate(goal=query.goal, duration=3.0)
    time, place = moved_point(before, 0.4)
    made = skill.corrected(time, place, goal=query.goal, duration=3.0)
    after = made.generate(goal=query.goal, duration=3.0)
    assert errors(after, time, place)[0] < NEAR
    np.testing.assert_allclose(after.positions[-1], before.positions[-1], atol=1e-15)
    made.save(tmp_path / "skill.npz")
    loaded = lt.load_skill(tmp_path / "skill.npz")
    assert type(loaded.model) is type(skill.model)
    assert loaded.duration == pytest.approx(1.5, rel=0.1)
    assert loaded.generate().positions.tobytes() == made.generate().positions.tobytes()


def test_rates_are_the_derivatives_of_the_corrected_motion():
    skill = kinds.learned("movement primitive of joints")
    made = skill.corrected(0.7, skill.generate().at(0.7) + np.array([0.0, 0.1, 0.0])).generate(
        dt=0.002
    )
    for below, above in (("positions", "velocities"), ("velocities", "accelerations")):
        rates = np.gradient(getattr(made, below), made.times, axis=0)
        largest = np.abs(rates).max()
        np.testing.assert_allclose(getattr(made, above)[5:-5], rates[5:-5], atol=1e-2 * largest)


def test_a_point_that_is_moved_again_is_met_where_it_was_moved_last():
    skill = kinds.learned("ProMP")
    first, second = (moved_point(skill.generate(), 0.5, offset) for offset in (0.03, 0.05))
    made = skill.corrected(*first).corrected(*second)
    assert len(made.corrections) == 1
    assert errors(made.generate(), *second)[0] < NEAR


def test_a_correction_belongs_to_the_mode_that_it_was_made_in(tmp_path):
    shown = [kind("DMP").demonstrated(shift) for shift in (-0.01, 0.0, 0.01)]
    mirrored = [lt.Trajectory(each.times, each.positions * [1.0, -1.0]) for each in shown[:2]]
    skill = kind("AlignedMean").build().fit([*shown, *mirrored])
    assert len(skill.modes) == 2
    time, place = moved_point(skill.generate(mode=1), 0.5)
    skill.corrected(time, place, mode=1).save(tmp_path / "skill.npz")
    made = lt.load_skill(tmp_path / "skill.npz")
    assert errors(made.generate(mode=1), time, place)[0] < NEAR
    np.testing.assert_array_equal(made.generate(mode=0).positions, skill.generate(mode=0).positions)


def test_obstacles_come_before_corrections():
    skill = kinds.learned("fast marching")
    motion = skill.generate()
    time, place = moved_point(motion, 0.5, 0.06)
    post = lt.Sphere(0.02, (*place, 0.0))
    made = skill.corrected(time, place)
    assert not _is_clear(made.generate(), post)
    assert _is_clear(made.generate(obstacles=[post]), post)


def _is_clear(motion, post):
    apart = np.linalg.norm(motion.positions - post.position[:2], axis=1)
    return bool((apart > 0.02).all())


def test_a_corrected_skill_is_planned_with_an_arm():
    panda = arm("panda")
    middle = panda.limits.lower + 0.5 * (panda.limits.upper - panda.limits.lower)
    ends = np.linspace(middle, middle + 0.3, 60)
    shown = panda.poses(lt.JointTrajectory(np.linspace(0, 2, 60), ends, None, None,
                                           panda.joint_names))  # fmt: skip
    skill = kind("DMP", "poses").build().fit([shown])
    time, place = moved_point(skill.generate(), 0.5)
    planned = lt.plan_motion(skill.corrected(time, place), panda)
    assert np.linalg.norm(planned.tip.at(time)[0] - place[0]) < NEAR


def test_a_point_may_be_named_by_its_position(skill):
    before = skill.generate()
    time, place = moved_point(before, 0.4)
    nearest = skill.corrected(before.positions[np.searchsorted(before.times, time)], place)
    position = place[0] if isinstance(place, tuple) else place
    gaps = np.linalg.norm(nearest.generate().positions - position, axis=1)
    assert gaps.min() < NEAR
    assert nearest.corrections[0].at == pytest.approx(
        skill.corrected(time, place).corrections[0].at, abs=0.02
    )


def test_times_of_any_type_of_number_are_times():
    skill = kinds.learned("GMR")
    at = skill.corrected(1.0, (0.1, 0.1)).corrections[0].at
    for time in (1, np.float32(1.0), np.int64(1)):
        assert skill.corrected(time, (0.1, 0.1)).corrections[0].at == at


@pytest.mark.parametrize("time", [-0.1, 99.0, float("nan"), "late", ((0.1, 0.1), (1.0,))])
def test_a_time_outside_the_motion_is_refused(time):
    refused("at", kinds.learned("GMR").corrected, time, (0.1, 0.1))


def test_the_ends_are_left_to_start_and_goal():
    skill = kinds.learned("GMR")
    last = skill.generate()
    refused("another goal to generate", skill.corrected, last.times[-1], (0.1, 0.1))
    refused("another start to generate", skill.corrected, 0.0, (0.1, 0.1))
    refused("position", skill.corrected, 0.7, (0.1, 0.1, 0.1))

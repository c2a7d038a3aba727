"""Systems of poses: in the rotation vectors from the goal's orientation, which may exceed pi."""

from functools import cache

import numpy as np
import pytest

import leadthrough as lt
from leadthrough import rotations
from leadthrough.errors import FitError, InvalidInput
from leadthrough.models import CLFDM, LPVDS

T = np.linspace(0.0, 1.5, 150)
U = 10 * (T / 1.5) ** 3 - 15 * (T / 1.5) ** 4 + 6 * (T / 1.5) ** 5


def shown(turn=5.0):
    motions = []
    for shift in (-0.02, 0.0, 0.02):
        bow = 0.1 * np.sin(np.pi * U) + shift * (1 - U)
        points = np.column_stack([0.3 * U, bow, 0.1 * U])
        turned = rotations.exp(np.outer(turn * U, [shift, 0.6, 0.8]))
        motions.append(lt.Demonstration(lt.PoseTrajectory(T, points, turned)))
    return motions


@cache
def fitted(name):
    models = {
        "CLF-DM": CLFDM(components=6, quadratics=1),
        "LPV-DS": LPVDS(components=5),
    }
    return models[name].fit(shown())


@pytest.fixture(params=["CLF-DM", "LPV-DS"])
def skill(request):
    return fitted(request.param)


def test_a_motion_turns_as_far_and_the_same_way_round_as_it_was_shown_to(skill):
    motion = skill.generate()
    turned = np.linalg.norm(rotations.lift(motion.orientations), axis=1)
    assert turned[-1] == pytest.approx(0.0, abs=1e-6) or turned.max() == pytest.approx(5.0, abs=0.2)
    steps = rotations.distance(motion.orientations[1:], motion.orientations[:-1])
    assert steps.sum() == pytest.approx(5.0, abs=0.2)
    middle = shown()[1].motion.positions
    gaps = np.linalg.norm(middle[:, None] - motion.positions[None], axis=2)
    assert gaps.min(axis=1).max() < 0.03


def test_the_whole_system_moves_and_turns_with_the_goal(skill):
    plain = skill.generate(duration=2.0)
    goal = (0.4, -0.1, 0.2), rotations.exp([[0.0, 3.2, 4.1]])[0]
    moved = skill.generate(start=((0.1, -0.1, 0.1), plain.orientations[0]), goal=goal, duration=2.0)
    np.testing.assert_allclose(moved.positions[[0, -1]], [[0.1, -0.1, 0.1], goal[0]], atol=1e-9)
    ends = rotations.distance(moved.orientations[[0, -1]], [plain.orientations[0], goal[1]])
    np.testing.assert_allclose(ends, 0.0, atol=1e-6)


def test_policy_of_a_pose_is_the_twist_of_its_motion(skill):
    motion = skill.generate(dt=1e-3)
    row = len(motion.times) // 2
    twist = skill.policy((motion.positions[row], motion.orientations[row]))
    linear = np.gradient(motion.positions, motion.times, axis=0)[row]
    angular = rotations.angular_velocity(motion.times, motion.orientations)[row]
    np.testing.assert_allclose(twist[:3], linear, atol=0.02 * np.linalg.norm(linear) + 1e-3)
    np.testing.assert_allclose(twist[3:], angular, atol=0.03 * np.linalg.norm(angular))


def test_all_starts_reach_the_goal(skill):
    report = skill.stability(500, around=0.2)
    assert report.ok, report


def test_what_a_system_of_poses_cannot_do_is_refused(skill):
    with pytest.raises(FitError, match="within a full turn"):
        LPVDS(components=2).fit(shown(turn=7.0))
    with pytest.raises(InvalidInput, match="position"):
        skill.policy((0.0, 0.0, 0.0))

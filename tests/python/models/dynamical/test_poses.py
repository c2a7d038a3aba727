"""Systems of poses: in the rotation vectors from the goal's orientation, which may exceed pi."""

import numpy as np
import pytest
from kinds import SHIFTS, kind
from motions import arch

from leadthrough import rotations
from leadthrough.errors import FitError, InvalidInput


def demonstrated(turn=5.0):
    return [arch("poses", shift, turn=turn) for shift in SHIFTS]


@pytest.fixture(
    scope="module",
    params=[
        kind("CLFDM", "poses", components=6, quadratics=1),
        kind("LPVDS", "poses", components=5),
    ],
    ids=str,
)
def skill(request):
    return request.param.build().fit(demonstrated())


def test_a_motion_turns_as_far_and_the_same_way_round_as_demonstrated(skill):
    motion = skill.generate()
    turned = np.linalg.norm(rotations.lift(motion.orientations), axis=1)
    assert turned[-1] == pytest.approx(0.0, abs=1e-6) or turned.max() == pytest.approx(5.0, abs=0.2)
    steps = rotations.distance(motion.orientations[1:], motion.orientations[:-1])
    assert steps.sum() == pytest.approx(5.0, abs=0.2)
    middle = demonstrated()[1].positions
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
        kind("LPVDS", "poses", components=2).build().fit(demonstrated(turn=7.0))
    with pytest.raises(InvalidInput, match="position"):
        skill.policy((0.0, 0.0, 0.0))

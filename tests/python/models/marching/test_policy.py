"""State-by-state policies from fast marching."""

import numpy as np
import pytest

import leadthrough as lt
from leadthrough.errors import InvalidInput, NoPath


@pytest.fixture(scope="module")
def skill():
    t = np.linspace(0.0, 1.0, 200)
    u = 10 * t**3 - 15 * t**4 + 6 * t**5
    arch = np.column_stack([0.4 * u, 0.1 * np.sin(np.pi * u)])
    return lt.FastMarching().fit([lt.Demonstration(lt.Trajectory(2.0 * t, arch))])


def walk(policy, position, *, steps=4000, dt=0.005, push=None):
    points = [np.asarray(position, dtype=float)]
    for step in range(steps):
        if push is not None and step == push[0]:
            points.append(points[-1] + push[1])
        points.append(points[-1] + dt * policy(points[-1]))
    return np.array(points)


def test_policy_follows_the_demonstration_to_its_goal(skill):
    points = walk(skill.policy, (0.0, 0.0))
    np.testing.assert_allclose(points[-1], (0.4, 0.0), atol=1e-4)
    shown = skill.experience[0]
    gaps = np.linalg.norm(points[:, None] - shown[None], axis=2).min(axis=1)
    assert gaps.max() < skill.area_of_influence


def test_pushed_tool_still_arrives(skill):
    points = walk(skill.policy, (0.0, 0.0), push=(200, np.array([0.05, 0.15])))
    np.testing.assert_allclose(points[-1], (0.4, 0.0), atol=1e-4)


def test_speed_is_the_demonstrations_mean_and_falls_near_the_goal(skill):
    length = np.linalg.norm(np.diff(skill.experience[0], axis=0), axis=1).sum()
    assert np.linalg.norm(skill.policy((0.1, 0.08))) == pytest.approx(length / 2.0)
    np.testing.assert_allclose(skill.policy((0.4, 0.0)), 0.0, atol=1e-12)
    near = np.linalg.norm(skill.policy((0.4, 0.3 * skill.area_of_influence)))
    assert near == pytest.approx(0.3 * length / 2.0, rel=1e-6)


def test_policy_to_another_goal_goes_around_obstacles(skill):
    box = lt.Box((0.05, 0.05, 0.2), (0.2, 0.1, 0.0))
    policy = skill.policy_to((0.45, 0.05), obstacles=[box])
    points = walk(policy, (0.0, 0.0))
    np.testing.assert_allclose(points[-1], (0.45, 0.05), atol=1e-4)
    assert box.distance(np.column_stack([points, np.zeros(len(points))])).min() > 0.0


def test_nowhere_to_go_is_said(skill):
    with pytest.raises(NoPath):
        skill.policy((5.0, 5.0))
    with pytest.raises(NoPath) as error:
        skill.policy_to(obstacles=[lt.Box((0.1, 0.1, 0.1), (0.4, 0.0, 0.0))])
    assert error.value.reason == "goal_in_wall"
    with pytest.raises(InvalidInput, match="position: expected finite"):
        skill.policy((np.nan, 0.0))
    with pytest.raises(InvalidInput, match="no demonstration"):
        lt.FastMarching().fit([]).policy((0.0, 0.0))

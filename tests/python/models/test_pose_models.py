"""Probabilistic models of poses: orientations in the tangent spaces of a reference."""

import numpy as np
import pytest

import leadthrough as lt
from leadthrough import rotations
from leadthrough.errors import InvalidInput, UnsupportedQuery

U = np.linspace(0.0, 1.0, 120)


def turning(count=6, *, angle=5.0, seed=0):
    """Poses that turn by an angle, rad, about an axis that varies a little."""
    rng = np.random.default_rng(seed)
    shown = []
    for _ in range(count):
        axis = np.array([0.1, 0.2, 1.0]) + 0.05 * rng.standard_normal(3)
        axis /= np.linalg.norm(axis)
        quaternions = rotations.exp(np.outer(angle * U, axis))
        points = np.column_stack([U, np.sin(U), 0.1 * rng.standard_normal() * U])
        shown.append(lt.Demonstration(lt.PoseTrajectory(3.0 * U, points, quaternions)))
    return shown


@pytest.fixture(scope="module", params=[lt.ProMP(), lt.GMR(10)], ids=["ProMP", "GMR"])
def skill(request):
    return request.param.fit(turning())


def test_motion_turns_as_it_was_shown_beyond_a_half_turn(skill):
    motion = skill.generate(dt=0.02)
    assert isinstance(motion, lt.PoseTrajectory)
    mean = rotations.exp(np.outer(5.0 * motion.times / 3.0, [0.1, 0.2, 1.0] / np.sqrt(1.05)))
    assert rotations.distance(motion.orientations, mean).max() < 0.2
    steps = rotations.distance(motion.orientations[1:], motion.orientations[:-1])
    assert steps.sum() == pytest.approx(5.0, abs=0.2)


def test_new_start_and_goal_are_met_in_position_and_orientation(skill):
    start = ((0.1, 0.0, 0.1), rotations.exp([[0.3, 0.0, 0.0]])[0])
    goal = ((1.0, 0.8, 0.0), rotations.exp([[0.0, 0.4, 5.0]])[0])
    motion = skill.generate(start=start, goal=goal)
    for row, (position, turned) in ((0, start), (-1, goal)):
        np.testing.assert_allclose(motion.positions[row], position, atol=1e-8)
        assert rotations.distance(motion.orientations[[row]], turned[None])[0] < 1e-8


def test_position_alone_may_be_given(skill):
    motion = skill.generate(start=(0.1, 0.0, 0.1))
    np.testing.assert_allclose(motion.positions[0], (0.1, 0.0, 0.1), atol=1e-8)


def test_frame_of_the_demonstrations_does_not_matter():
    turn = rotations.exp([[0.5, -1.0, 2.0]])
    shown = turning()
    turned = [
        lt.Demonstration(
            lt.PoseTrajectory(
                each.motion.times,
                each.motion.positions,
                rotations.compose(np.repeat(turn, len(U), axis=0), each.motion.orientations),
            )
        )
        for each in shown
    ]
    plain, other = (lt.ProMP().fit(each).generate() for each in (shown, turned))
    expected = rotations.compose(np.repeat(turn, len(plain.times), axis=0), plain.orientations)
    assert rotations.distance(other.orientations, expected).max() < 1e-7


def test_skill_of_poses_is_saved(skill, tmp_path):
    skill.save(tmp_path / "skill.npz")
    loaded = lt.load_skill(tmp_path / "skill.npz")
    a, b = skill.generate(), loaded.generate()
    np.testing.assert_allclose(a.orientations, b.orientations, atol=1e-12)


def test_pose_via_point_and_samples():
    skill = lt.ProMP().fit(turning())
    mean = skill.generate(dt=0.1)
    turned = rotations.compose(mean.orientations[[15]], rotations.exp([[0.1, 0.0, 0.0]]))[0]
    via = skill.condition(mean.times[15], (mean.positions[15], turned))
    reached = via.generate(dt=0.1).orientations[[15]]
    assert rotations.distance(reached, turned[None])[0] < 1e-7
    assert all(isinstance(each, lt.PoseTrajectory) for each in skill.sample(2, seed=0))
    assert skill.log_likelihood(turning(1, seed=5)[0].motion) > -np.inf


def test_components_have_mean_orientations_on_the_sphere():
    skill = lt.GMR(6).fit(turning())
    means = skill.component_orientations()
    np.testing.assert_allclose(np.linalg.norm(means, axis=1), 1.0, atol=1e-12)
    times = skill.mixture.means[:, 0]
    expected = rotations.exp(np.outer(5.0 * times / 3.0, [0.1, 0.2, 1.0] / np.sqrt(1.05)))
    assert rotations.distance(means, expected).max() < 0.3
    points = [lt.Demonstration(lt.Trajectory(U, np.column_stack([U, U])))]
    with pytest.raises(UnsupportedQuery):
        lt.GMR(2).fit(points).component_orientations()


def test_points_and_poses_are_not_mixed():
    points = lt.Demonstration(lt.Trajectory(U, np.column_stack([U, U, U])))
    for model in (lt.ProMP(), lt.GMR()):
        with pytest.raises(InvalidInput, match="one type"):
            model.fit([*turning(1), points])

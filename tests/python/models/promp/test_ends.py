"""A ProMP between a new start and a new goal: exact there, and bounded in between."""

import numpy as np
import pytest

import leadthrough as lt
from leadthrough import rotations
from leadthrough.io import lasa
from leadthrough.models import MisalignmentWarning

U = np.linspace(0.0, 1.0, 100)
# What a motion may deviate by, in multiples of what its ends are moved by.
BOUND = 1.5
JOINTS = tuple(f"joint{i}" for i in range(1, 8))


def moved_by(motion, other):
    return float(np.linalg.norm(motion.positions - other.positions, axis=1).max())


def size_of(motion):
    return float(np.linalg.norm(np.ptp(motion.positions, axis=0)))


def joints_from_one_posture(count, seed=0):
    """Motions of seven joints that all start in the same posture."""
    rng = np.random.default_rng(seed)
    ready = np.array([0.0, -0.8, 0.0, -2.4, 0.0, 1.6, 0.8])
    shown = []
    for _ in range(count):
        reach = rng.normal(0.5, 0.1, 7)
        wiggle = rng.normal(0.0, 0.1, 7)
        path = ready + np.outer(U**2, reach) + np.outer(np.sin(np.pi * U) ** 2, wiggle)
        shown.append(lt.JointTrajectory(2.0 * U, path, joint_names=JOINTS))
    return shown


@pytest.mark.parametrize("count", [1, 2, 3, 4, 6])
def test_moved_ends_of_handwriting_never_throw_the_motion(count):
    for name in lasa.motions()[::3]:
        skill = lt.ProMP().fit(lasa.load(name)[:count])
        before = skill.generate(dt=0.05)
        for fraction in (0.05, 0.1, 0.5):
            for angle in (0.3, 1.9, 3.4, 5.0):
                offset = np.array([np.cos(angle), np.sin(angle)]) * fraction * size_of(before)
                start, goal = before.positions[0] + offset, before.positions[-1] - offset
                for asked in ({"start": start}, {"goal": goal}, {"start": start, "goal": goal}):
                    made = skill.generate(**asked, dt=0.05)
                    assert moved_by(made, before) <= BOUND * np.linalg.norm(offset), (name, asked)
                    if "start" in asked:
                        np.testing.assert_allclose(made.positions[0], start, atol=1e-9)
                    if "goal" in asked:
                        np.testing.assert_allclose(made.positions[-1], goal, atol=1e-9)


@pytest.mark.parametrize("count", [2, 5, 40])
@pytest.mark.parametrize("offset", [0.01, 0.3, 3.0])
def test_an_arm_shown_from_one_posture_starts_beside_it(count, offset):
    skill = lt.ProMP().fit(joints_from_one_posture(count))
    before = skill.generate()
    start = before.positions[0] + offset / np.sqrt(7.0)
    assert moved_by(skill.generate(start=start), before) <= BOUND * offset


def test_a_plane_drawing_is_raised_as_a_whole(recordings):
    shown = lt.read_demonstrations(
        [recordings / "panda_symbol" / "symbol17.mat"], rate=1000.0, columns={"positions": ["pos"]}
    )
    with pytest.warns(MisalignmentWarning):  # the hand pauses at different places
        skill = lt.ProMP().fit(shown)
    before = skill.generate()
    goal = before.positions[-1] + [0.0, 0.0, 0.02]
    assert moved_by(skill.generate(goal=goal), before) <= BOUND * 0.02


def test_a_moved_position_does_not_turn_a_pose_beyond_a_moved_orientation():
    rng = np.random.default_rng(2)
    shown = []
    for _ in range(4):
        positions = np.column_stack([U, rng.normal() * 0.1 * U, np.sin(U)])
        turned = rotations.exp(np.outer(U, [1.0, 0.2 * rng.normal(), 0.0]))
        shown.append(lt.PoseTrajectory(3.0 * U, positions, turned))
    skill = lt.ProMP().fit(shown)
    before = skill.generate()
    turn = rotations.exp(np.array([[0.0, 0.0, 0.1]]))
    goal = before.positions[-1] + 0.2, rotations.compose(turn, before.orientations[-1:])[0]
    made = skill.generate(goal=goal)
    assert moved_by(made, before) <= BOUND * 0.2 * np.sqrt(3.0)
    assert rotations.distance(made.orientations, before.orientations).max() <= BOUND * 0.1
    assert rotations.distance(made.orientations[-1:], goal[1][None])[0] < 1e-6


def test_inside_what_was_shown_the_ends_tell_the_way():
    # Whoever starts higher passes higher, and comes down late; a shift alone fades evenly.
    heights = np.linspace(-1.0, 1.0, 40)
    shown = [lt.Trajectory(U, np.column_stack([U, y * (1.0 - U**3)])) for y in heights]
    made = lt.ProMP().fit(shown).generate(start=(0.0, 0.8), dt=0.01)
    np.testing.assert_allclose(made.positions[:, 1], 0.8 * (1.0 - made.times**3), atol=0.05)


def test_a_pose_turns_as_poses_that_began_there_did():
    shown = []
    for y in np.linspace(-1.0, 1.0, 20):
        fading = y * (1.0 - U**3)
        points = np.column_stack([0.1 * U, fading, 0.0 * U])
        turned = rotations.exp(np.outer(0.5 * fading, [1.0, 0.0, 0.0]))
        shown.append(lt.PoseTrajectory(U, points, turned))
    made = lt.ProMP().fit(shown).generate(start=(0.0, 0.8, 0.0), dt=0.01)
    expected = rotations.exp(np.outer(0.4 * (1.0 - made.times**3), [1.0, 0.0, 0.0]))
    np.testing.assert_allclose(made.positions[:, 1], 0.8 * (1.0 - made.times**3), atol=0.05)
    assert rotations.distance(made.orientations, expected).max() < 0.05


def test_novelty_counts_standard_deviations_of_the_ends():
    starts = np.array([-1.0, 0.0, 1.0])  # standard deviation 1
    shown = [lt.Trajectory(U, np.column_stack([U, y * (1.0 - U)])) for y in starts]
    skill = lt.ProMP().fit(shown)
    assert skill.novelty() == 0.0
    assert skill.novelty(start=skill.generate().positions[0]) == pytest.approx(0.0, abs=1e-6)
    assert skill.novelty(start=(0.0, 2.0)) == pytest.approx(2.0, rel=0.05)
    assert skill.novelty(start=(0.0, 6.0)) == pytest.approx(6.0, rel=0.05)
    assert skill.novelty(goal=(1.0, 0.5)) > 3.0  # where all demonstrations agree
    assert skill.condition(0.0, (0.0, 1.0)).novelty(start=(0.0, 0.0)) == np.inf


def test_via_points_stay_where_start_and_goal_move():
    skill = lt.ProMP().fit(joints_from_one_posture(4)).condition(1.0, np.full(7, 0.2))
    made = skill.generate(start=np.full(7, 0.1), goal=np.full(7, 0.4))
    np.testing.assert_allclose(made.positions[100], 0.2, atol=1e-6)
    np.testing.assert_allclose(made.positions[[0, -1]], [[0.1] * 7, [0.4] * 7], atol=1e-6)

"""Rhythmic primitives."""

import numpy as np
import pytest

import leadthrough as lt
from leadthrough import rotations
from leadthrough.sanity import ImplausibleInputWarning

PERIOD = 1.5


def stirring(*, rounds=1.0, noise=0.0, whole_turns=False):
    """A hand that stirs; the tool sways, or turns once a round as well."""
    t = np.linspace(0.0, rounds * PERIOD, int(rounds * 300) + 1)
    w = 2.0 * np.pi * t / PERIOD
    points = np.column_stack(
        [
            0.4 + 0.05 * np.cos(w),
            0.04 * np.sin(w) + 0.01 * np.sin(2 * w),
            0.2 + 0.01 * np.cos(3 * w),
        ]
    )
    points += np.random.default_rng(0).normal(0.0, noise, points.shape)
    sway = rotations.exp(np.column_stack([0.3 * np.cos(w), 0.2 * np.sin(w), 0.0 * w]))
    spin = rotations.exp(np.outer(w if whole_turns else 0.0 * w, [0.0, 0.0, 1.0]))
    return lt.PoseTrajectory(t, points, rotations.compose(sway, spin))


def points_of(motion):
    return lt.Trajectory(motion.times, motion.positions)


SHOWN = stirring()
SKILL = lt.RhythmicDMP().fit([points_of(SHOWN)])


def test_rounds_repeat_what_was_shown():
    made = SKILL.generate(duration=3 * PERIOD, dt=PERIOD / 300)
    for i in range(3):
        rows = made.positions[300 * i : 300 * i + 301]
        np.testing.assert_allclose(rows, SHOWN.positions, atol=1e-4)


def test_several_rounds_are_averaged():
    long = points_of(stirring(rounds=5.4, noise=1e-3))
    made = lt.RhythmicDMP(period=PERIOD).fit([long]).generate(dt=PERIOD / 300)
    assert np.linalg.norm(made.positions - SHOWN.positions, axis=1).mean() < 1e-3


@pytest.mark.parametrize(
    ("rounds", "period"), [(2.5, None), (5.0, 0.5 * PERIOD), (5.0, 0.9 * PERIOD)]
)
def test_what_repeats_nothing_is_warned_of(rounds, period):
    with pytest.warns(ImplausibleInputWarning, match="periods of .* give whole periods"):
        lt.RhythmicDMP(period=period).fit([points_of(stirring(rounds=rounds))])


def test_joints_go_round_with_the_tool():
    angle = 2.0 * np.pi * SHOWN.times / PERIOD
    joints = np.column_stack([np.sin(angle), np.cos(angle), 0.2 * np.sin(2.0 * angle)])
    stood = lt.JointTrajectory(SHOWN.times, joints, joint_names=("a", "b", "c"))
    skill = lt.RhythmicDMP().fit([lt.Demonstration(points_of(SHOWN), joints=stood)])
    made = skill.generate(duration=2 * PERIOD, dt=PERIOD / 300)
    for i in range(2):
        rows = made.joints.positions[300 * i : 300 * i + 301]
        np.testing.assert_allclose(rows, joints, atol=1e-3)


def test_rhythm_is_swung_into_from_anywhere():
    made = SKILL.generate(start=(1.0, -1.0, 2.0), duration=4 * PERIOD, dt=PERIOD / 300)
    np.testing.assert_allclose(made.positions[0], (1.0, -1.0, 2.0), atol=1e-12)
    np.testing.assert_allclose(made.positions[-301:], SHOWN.positions, atol=1e-4)


def test_centre_period_and_amplitude_are_met():
    shift = np.array([0.1, 0.2, -0.1])
    centre = SKILL.system.ends.goal
    made = SKILL.generate(goal=centre + shift, period=3.0, amplitude=0.5, duration=3.0, dt=0.01)
    expected = centre + shift + 0.5 * (SHOWN.positions - centre)
    np.testing.assert_allclose(made.positions, expected, atol=1e-4)


def test_steps_lead_where_generate_does_and_the_centre_can_move():
    state = SKILL.begin()
    for position in SKILL.generate(duration=2 * PERIOD, dt=0.01).positions[1:]:
        state = SKILL.step(state, 0.01)
        np.testing.assert_allclose(state.position, position, atol=1e-9)
    moved = SKILL.step(state, 1e-9, goal=SKILL.system.ends.goal + 0.1)
    np.testing.assert_allclose(moved.position, state.position, atol=1e-6)
    after = SKILL.step(moved, 10 * PERIOD)
    np.testing.assert_allclose(after.position, SHOWN.positions[0] + 0.1, atol=1e-4)
    pushed = SKILL.step(state, 0.1, coupling=(0.0, 0.0, 5.0))
    assert pushed.position[2] > SKILL.step(state, 0.1).position[2] + 0.01


@pytest.mark.parametrize("whole_turns", [False, True])
def test_tool_sways_or_turns_on_and_on(whole_turns):
    shown = stirring(whole_turns=whole_turns)
    skill = lt.RhythmicDMP().fit([shown])
    made = skill.generate(duration=3 * PERIOD, dt=PERIOD / 300)
    for i in range(3):
        rows = slice(300 * i, 300 * i + 301)
        np.testing.assert_allclose(made.positions[rows], shown.positions, atol=1e-4)
        angles = rotations.distance(made.orientations[rows], shown.orientations)
        assert np.degrees(angles).max() < 0.05
    steps = rotations.distance(made.orientations[:-1], made.orientations[1:])
    assert np.degrees(steps).max() < 3.0


def test_pose_rhythm_starts_anywhere_and_turns_about_a_new_centre():
    skill = lt.RhythmicDMP().fit([SHOWN])
    centre = rotations.exp(np.array([[0.0, 0.5, 0.0]]))[0]
    start = rotations.exp(np.array([[0.0, 0.0, 1.0]]))[0]
    made = skill.generate(
        start=((0.0, 0.0, 0.0), start), goal=((1.0, 0.0, 0.0), centre), duration=5 * PERIOD
    )
    assert rotations.distance(made.orientations[:1], start[None])[0] < 1e-7
    assert rotations.distance(made.orientations[-1:], centre[None])[0] < 1e-3
    np.testing.assert_allclose(made.positions[0], 0.0, atol=1e-12)
    state = skill.begin(goal=((1.0, 0.0, 0.0), centre))
    state = skill.step(skill.step(state, 2 * PERIOD), 3 * PERIOD, goal=(1.0, 0.0, 0.0))
    assert rotations.distance(state.orientation[None], centre[None])[0] < 1e-3
    nudged = skill.step(state, 0.05, coupling=(0.0, 0.0, 1.0))
    assert nudged.position[2] > skill.step(state, 0.05).position[2]

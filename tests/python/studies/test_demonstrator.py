"""The simulated person."""

from dataclasses import replace

import numpy as np
import pytest

from leadthrough_studies.demonstrator import JointTeaching, Teaching, guide, guide_joints, wander
from leadthrough_studies.metrics import dimensionless_jerk, turning

ENDS = np.array([[0.0, 0.0, 0.0], [0.4, 0.3, 0.0]])
STEADY = Teaching(duration=2.0, spread=0.0, bow=0.0, tremor=0.0)


def shown(teaching, seed=0, points=ENDS):
    return guide(points, teaching, np.random.default_rng(seed)).motion


def test_a_steady_hand_moves_straight_with_minimum_jerk():
    motion = shown(STEADY)
    np.testing.assert_allclose(motion.positions[[0, -1]], ENDS, atol=1e-12)
    assert motion.duration == 2.0
    assert turning(motion.positions, step=0.01) < 1e-6
    assert dimensionless_jerk(motion) == pytest.approx(720.0, rel=0.1)
    speed = np.linalg.norm(np.gradient(motion.positions, motion.times, axis=0), axis=1)
    assert speed.max() == pytest.approx(1.875 * 0.5 / 2.0, rel=1e-2)  # of the mean speed


def test_tremor_has_the_amplitude_asked_for_and_makes_the_path_rough():
    trembling = replace(STEADY, tremor=0.002)
    offsets = np.concatenate(
        [shown(trembling, seed).positions - shown(STEADY).positions for seed in range(50)]
    )
    # The sine that fades it in and out has a mean square of one half.
    assert np.sqrt((offsets**2).mean()) == pytest.approx(0.002 / np.sqrt(2.0), rel=0.1)
    assert turning(shown(trembling).positions, step=0.005) > 1.0
    assert dimensionless_jerk(shown(trembling)) > 1e4


def test_ends_scatter_as_asked():
    starts = np.array([shown(replace(STEADY, spread=0.01), i).positions[0] for i in range(300)])
    np.testing.assert_allclose(starts.std(axis=0), 0.01, rtol=0.15)
    np.testing.assert_allclose(starts.mean(axis=0), 0.0, atol=0.002)


def test_points_on_the_way_are_passed():
    via = np.array([ENDS[0], [0.2, 0.0, 0.3], ENDS[1]])
    gaps = np.linalg.norm(shown(STEADY, points=via).positions - via[1], axis=1)
    assert gaps.min() < 0.01


def test_the_same_seed_gives_the_same_motion():
    first, again, other = (shown(Teaching(), seed) for seed in (1, 1, 2))
    assert first.positions.tobytes() == again.positions.tobytes()
    assert not np.allclose(first.positions, other.positions)


def test_wandering_stays_about_its_box():
    motion = wander(np.zeros(3), np.ones(3), STEADY, np.random.default_rng(0)).motion
    assert motion.positions.min() > -0.5
    assert motion.positions.max() < 1.5
    assert turning(motion.positions, step=0.01) > 2.0


POSTURES = np.array([[0.0, 1.0, -0.5], [0.8, 0.2, -0.5], [1.5, 0.6, 0.5]])
CALM = JointTeaching(pace=0.0, pauses=0, tremor=0.0, encoder=2**24)


def recorded(teaching, seed=0):
    return guide_joints(POSTURES, teaching, np.random.default_rng(seed)).motion


def test_joints_pass_through_the_postures_and_stay_between_them():
    motion = recorded(CALM)
    np.testing.assert_allclose(motion.positions[[0, -1]], POSTURES[[0, -1]], atol=1e-6)
    gaps = np.linalg.norm(motion.positions - POSTURES[1], axis=1)
    assert gaps.min() < 0.02
    assert (motion.positions >= POSTURES.min(axis=0) - 1e-6).all()
    assert (motion.positions <= POSTURES.max(axis=0) + 1e-6).all()


def test_encoders_count_in_steps():
    steps = recorded(JointTeaching(encoder=1000)).positions / (2.0 * np.pi / 1000)
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-9)


def test_people_pause_up_to_the_given_number_of_times():
    hasty = replace(CALM, pauses=1, pause=(1.0, 1.0))
    rests = []
    for seed in range(20):
        motion = recorded(hasty, seed)
        inside = (motion.times > 1.5) & (motion.times < motion.times[-1] - 1.5)
        speed = np.abs(np.gradient(motion.positions, motion.times, axis=0)).max(axis=1)
        rests.append(float((speed[inside] < 1e-4).mean()) * motion.duration)
    assert max(rests) > 0.4
    assert min(rests) == 0.0  # some do not pause


def test_the_pace_varies_from_one_demonstration_to_the_next():
    durations = [recorded(JointTeaching(), seed).duration for seed in range(20)]
    assert min(durations) >= 10.0 - 0.02
    assert max(durations) <= 18.0
    assert np.std(durations) > 0.5


def test_the_same_seed_gives_the_same_joints():
    first, again = (recorded(JointTeaching(), 3).positions for _ in range(2))
    assert first.tobytes() == again.tobytes()

"""Progress along a path, learned from demonstrations."""

import numpy as np
import pytest

from leadthrough.models.phase import mean_progress, progress_at


def minimum_jerk(count=500):
    t = np.linspace(0.0, 1.0, count)
    return t, 10 * t**3 - 15 * t**4 + 6 * t**5


def test_progress_of_a_minimum_jerk_motion_is_minimum_jerk():
    t, u = minimum_jerk()
    progress = mean_progress([3.0 + 2.0 * t], [np.outer(u, [3.0, 4.0])])
    expected = np.interp(np.linspace(0, 1, len(progress)), t, u)
    assert np.abs(progress - expected).max() < 0.02


def test_progress_rises_from_zero_to_one_at_rest_even_if_the_recording_starts_moving():
    t = np.linspace(0.0, 1.0, 100)
    progress = mean_progress([t], [np.outer(t, [1.0, 0.0])])
    assert progress[0] == 0.0
    assert progress[-1] == pytest.approx(1.0)
    speed = np.diff(progress)
    assert (speed >= 0.0).all()
    assert speed[[0, -1]].max() < 0.1 * speed.max()


def test_pause_in_a_demonstration_stays_a_pause():
    t = np.linspace(0.0, 1.0, 300)
    u = np.interp(t, [0.0, 0.35, 0.65, 1.0], [0.0, 0.5, 0.5, 1.0])
    progress = mean_progress([t], [np.outer(u, [1.0, 0.0])])
    middle = progress_at(progress, np.array([0.45, 0.55]))
    assert np.ptp(middle) < 1e-3


def test_sampled_progress_stays_inside_zero_and_one():
    t, u = minimum_jerk()
    progress = mean_progress([t], [np.outer(u, [1.0, 0.0])])
    sampled = progress_at(progress, np.linspace(0.0, 1.0, 12345))
    assert sampled.min() >= 0.0
    assert sampled.max() <= 1.0

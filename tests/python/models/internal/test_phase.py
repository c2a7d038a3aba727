"""Progress along a path, learned from demonstrations."""

import motions
import numpy as np
import pytest

from leadthrough.models import curves
from leadthrough.models.marching import time_law


def rising(count=500):
    t = np.linspace(0.0, 1.0, count)
    return t, motions.minimum_jerk(t)


def test_progress_of_a_minimum_jerk_motion_is_minimum_jerk():
    t, u = rising()
    progress = curves.progress_of(3.0 + 2.0 * t, np.outer(u, [3.0, 4.0]))
    expected = np.interp(np.linspace(0, 1, curves.PROGRESS_SAMPLES), t, u)
    np.testing.assert_allclose(progress, expected, atol=1e-6)
    assert np.abs(time_law.rest_to_rest(progress) - expected).max() < 0.02


def test_motion_comes_to_rest_at_both_ends_even_if_the_recording_does_not():
    progress = time_law.rest_to_rest(curves.uniform_progress())
    assert progress[0] == 0.0
    assert progress[-1] == pytest.approx(1.0)
    speed = np.diff(progress)
    assert (speed >= 0.0).all()
    assert speed[[0, -1]].max() < 0.01 * speed.max()


def test_speed_stays_proportional_to_the_map():
    path = np.linspace([0.0, 0.0], [3.0, 4.0], 400)
    speed = np.where(path[:, 0] < 1.5, 1.0, 0.25)
    progress = time_law.progress_by_speed(path, speed)
    # Half the way at full speed takes a fifth of the time, the other half the rest.
    at_half = np.interp(0.5, progress, np.linspace(0, 1, curves.PROGRESS_SAMPLES))
    assert at_half == pytest.approx(0.2, abs=0.01)


def test_path_without_length_counts_as_uniform():
    still = np.zeros((5, 2))
    np.testing.assert_array_equal(
        time_law.progress_by_speed(still, np.ones(5)), curves.uniform_progress()
    )
    progress = curves.progress_of(np.arange(5.0), still)
    np.testing.assert_allclose(progress, curves.uniform_progress())


def test_pause_in_a_demonstration_stays_a_pause():
    t = np.linspace(0.0, 1.0, 300)
    u = np.interp(t, [0.0, 0.35, 0.65, 1.0], [0.0, 0.5, 0.5, 1.0])
    progress = time_law.rest_to_rest(curves.progress_of(t, np.outer(u, [1.0, 0.0])))
    assert np.ptp(progress[450:551]) < 1e-3


def test_progress_stays_inside_zero_and_one():
    t, u = rising()
    progress = time_law.rest_to_rest(curves.progress_of(t, np.outer(u, [1.0, 0.0])))
    assert progress.min() >= 0.0
    assert progress.max() <= 1.0

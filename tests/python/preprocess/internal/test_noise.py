"""White noise of recorded paths, and the paths without it."""

import numpy as np
import pytest
from motions import minimum_jerk

from leadthrough.io import lasa
from leadthrough.noise import noise_of, without_noise
from leadthrough.preprocess import arc_length
from leadthrough.preprocess.smooth import smooth_path
from leadthrough.rest import white_noise


def reach(count):
    """A bow of 1.09 m in minimum-jerk time."""
    t = np.linspace(0.0, 1.0, count)
    u = minimum_jerk(t)
    return np.column_stack([u, 0.2 * np.sin(np.pi * u)])


@pytest.mark.parametrize("count", [200, 1000, 5000, 30_000])
@pytest.mark.parametrize("noise", [0.003, 0.01, 0.03])
def test_noise_is_measured_and_adds_no_length(count, noise):
    clean = reach(count)
    noisy = clean + np.random.default_rng(count).normal(0.0, noise, clean.shape)
    assert noise_of(noisy) == pytest.approx(noise, rel=0.1)
    length = arc_length(clean)[-1]
    assert arc_length(noisy)[-1] > 1.3 * length
    assert arc_length(without_noise(noisy))[-1] == pytest.approx(length, rel=0.08)
    assert np.linalg.norm(without_noise(noisy) - clean, axis=1).max() < 2.5 * noise


@pytest.mark.parametrize("name", lasa.motions())
def test_clean_recordings_are_kept_to_the_bit(name):
    for demonstration in lasa.load(name):
        path = demonstration.motion.positions
        assert without_noise(path) is path


def test_straight_lines_and_polygons_are_kept():
    line = np.linspace([0.1, 0.2], [0.7, 0.9], 300)
    zigzag = np.array([[0.0, 0.0], [1.0, 1.0], [2.0, 0.0], [3.0, 1.0], [4.0, 0.0], [5.0, 1.0]])
    still = np.zeros((50, 3))
    for path in (line, zigzag, still, line[:2]):
        assert without_noise(path) is path


def test_one_sample_moved_a_little_changes_the_path_a_little():
    clean = reach(400)
    for off in (1e-9, 1e-6, 1e-3):
        spiked = clean.copy()
        spiked[150, 1] += off
        assert np.linalg.norm(without_noise(spiked) - clean, axis=1).max() <= 1.01 * off


def test_detail_beyond_the_noise_is_kept():
    """A long still recording with a few quick wiggles: most of it asks for much smoothing."""
    t = np.linspace(0.0, 60.0, 1500)
    wiggles = sum(np.exp(-(((t - at) / 0.15) ** 2)) for at in (10.0, 30.0, 50.0))
    clean = np.column_stack([0.001 * t, 0.02 * wiggles, 0.0 * t])
    noisy = clean + np.random.default_rng(5).normal(0.0, 3e-4, clean.shape)
    assert np.linalg.norm(without_noise(noisy) - noisy, axis=1).max() <= 5.0 * 3e-4
    still = np.abs(wiggles) < 1e-9
    errors = [np.std((path - clean)[still]) for path in (without_noise(noisy), noisy)]
    assert errors[0] < 0.5 * errors[1]


def test_no_spike_of_long_noise_is_taken_for_detail():
    """Of ten minutes at 1 kHz some samples are farther off than any of a short recording."""
    clean = np.sin(np.linspace(0.0, 100.0, 100_000)[:, None] + np.arange(7))
    noisy = clean + np.random.default_rng(3).normal(0.0, 1e-4, clean.shape)
    assert np.abs(np.diff(without_noise(noisy) - clean, 2, axis=0)).max() < 0.1 * 1e-4


def test_noise_scales_with_the_unit_and_turns_with_the_frame():
    noisy = reach(300) + np.random.default_rng(2).normal(0.0, 0.01, (300, 2))
    angle = np.deg2rad(37.0)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    moved = without_noise(1000.0 * noisy @ turn.T + 5.0)
    np.testing.assert_allclose(moved, 1000.0 * without_noise(noisy) @ turn.T + 5.0, atol=1e-6)


def circle(count, noise=0.0, seed=0):
    angle = np.linspace(0.0, np.pi, count)
    points = np.column_stack([np.cos(angle), np.sin(angle)])
    return points + noise * np.random.default_rng(seed).standard_normal(points.shape)


def test_smooth_path_keeps_a_smooth_curve_and_its_ends():
    path = circle(400)
    smoothed = smooth_path(path, knot_spacing=0.1)
    assert np.abs(np.linalg.norm(smoothed, axis=1) - 1.0).max() < 1e-4
    np.testing.assert_array_equal(smoothed[[0, -1]], path[[0, -1]])


def test_smoothing_takes_out_what_is_shorter_than_the_knots():
    path = circle(400, noise=1e-3)
    smoothed = smooth_path(path, knot_spacing=0.3)
    radius = np.linalg.norm(smoothed[10:-10], axis=1)
    assert np.abs(radius - 1.0).std() < 0.5e-3


def test_refused_candidates_get_closer_to_the_path_and_end_in_the_path_itself():
    corner = np.array([[0.0, 0.0], [0.5, 0.0], [1.0, 0.0], [1.0, 0.5], [1.0, 1.0]])
    deviations = []

    def refuse(points):
        gaps = np.minimum(np.abs(points[:, 1]), np.abs(points[:, 0] - 1.0))
        deviations.append(gaps.max())
        return False

    result = smooth_path(corner, knot_spacing=0.5, accept=refuse)
    assert result is corner
    assert len(deviations) == 5
    assert deviations[-1] < 0.3 * deviations[0]


def test_noise_of_joints_is_found_in_spite_of_spikes():
    rows = reach(500) + np.random.default_rng(9).normal(0.0, 5e-4, (500, 2))
    np.testing.assert_allclose(white_noise(rows), 5e-4, rtol=0.15)
    rows[::37] += 0.2
    np.testing.assert_allclose(white_noise(rows), 5e-4, rtol=0.25)

"""Smoothing of grid paths."""

import numpy as np

from leadthrough.preprocess.smooth import smooth_path


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

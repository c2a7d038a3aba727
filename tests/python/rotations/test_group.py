"""Against SciPy, at 0, at pi and between."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from leadthrough import rotations

ANGLES = [0.0, 1e-300, 1e-12, 1e-8, 1e-4, 0.5, 3.0, np.pi - 1e-8, np.pi - 1e-13, np.pi]

vectors = arrays(float, (3,), elements=st.floats(-10, 10))
unit_quaternions = (
    arrays(float, (4,), elements=st.floats(-1, 1))
    .filter(lambda q: np.linalg.norm(q) > 0.1)
    .map(lambda q: q / np.linalg.norm(q))
)


def axes(count):
    directions = np.random.default_rng(0).normal(size=(count, 3))
    return directions / np.linalg.norm(directions, axis=1, keepdims=True)


def scipy_of(quaternions):
    return Rotation.from_quat(np.asarray(quaternions)[:, [1, 2, 3, 0]])


@pytest.mark.parametrize("angle", ANGLES)
def test_exp_agrees_with_scipy(angle):
    rotation_vectors = angle * axes(20)
    difference = scipy_of(rotations.exp(rotation_vectors)).inv() * Rotation.from_rotvec(
        rotation_vectors
    )
    assert difference.magnitude().max() < 1e-15


@pytest.mark.parametrize("angle", ANGLES)
def test_log_agrees_with_scipy_up_to_the_sign_at_pi(angle):
    quaternions = rotations.exp(angle * axes(20))
    ours, theirs = rotations.log(quaternions), scipy_of(quaternions).as_rotvec()
    if angle == np.pi:
        theirs *= np.sign(np.sum(ours * theirs, axis=1, keepdims=True))
    np.testing.assert_allclose(ours, theirs, rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("angle", ANGLES[:-1])
def test_log_inverts_exp_below_pi(angle):
    expected = angle * axes(20)
    np.testing.assert_allclose(rotations.log(rotations.exp(expected)), expected, atol=2e-15)


@given(unit_quaternions)
def test_exp_inverts_log_for_any_rotation(quaternion):
    back = rotations.exp(rotations.log([quaternion]))
    assert rotations.distance(back, [quaternion])[0] < 1e-14


@given(vectors)
def test_exp_has_unit_length_and_log_at_most_pi(vector):
    quaternion = rotations.exp([vector])
    assert abs(np.linalg.norm(quaternion) - 1) < 1e-15
    assert np.linalg.norm(rotations.log(quaternion)) <= np.pi * (1 + 1e-15)


@given(unit_quaternions, unit_quaternions)
def test_composition_and_matrices_agree_with_scipy(a, b):
    ours = rotations.to_matrix(rotations.compose([a], [b]))[0]
    np.testing.assert_allclose(ours, (scipy_of([a]) * scipy_of([b])).as_matrix()[0], atol=1e-14)


@given(unit_quaternions, unit_quaternions, unit_quaternions)
def test_distance_is_a_metric_on_rotations(a, b, c):
    def d(p, q):
        return rotations.distance([p], [q])[0]

    assert d(a, a) < 1e-15
    assert d(a, -a) < 1e-15
    assert abs(d(a, b) - d(b, a)) < 1e-15
    assert 0 <= d(a, b) <= np.pi
    assert d(a, c) <= d(a, b) + d(b, c) + 1e-14
    moved_a, moved_b = (rotations.compose([c], [q])[0] for q in (a, b))
    assert abs(d(moved_a, moved_b) - d(a, b)) < 1e-13


def test_distance_is_the_angle_between_even_when_it_is_tiny():
    for angle in ANGLES:
        turned = rotations.exp([[angle, 0, 0]])
        measured = rotations.distance([[1.0, 0, 0, 0]], turned)[0]
        assert measured == pytest.approx(angle, rel=1e-14, abs=1e-320)


@given(arrays(bool, (12,)))
def test_align_signs_undoes_any_flips(flips):
    angles = np.linspace(0, 3 * np.pi, 12)
    smooth = np.column_stack([np.cos(angles / 2), np.sin(angles / 2), 0 * angles, 0 * angles])
    flips[0] = False
    aligned = rotations.align_signs(np.where(flips[:, None], -smooth, smooth))
    np.testing.assert_allclose(aligned, smooth, atol=1e-15)


def test_empty_batches_stay_empty():
    none = np.zeros((0, 4))
    assert rotations.exp(np.zeros((0, 3))).shape == (0, 4)
    assert rotations.log(none).shape == (0, 3)
    assert rotations.compose(none, none).shape == (0, 4)
    assert rotations.distance(none, none).shape == (0,)
    assert rotations.to_matrix(none).shape == (0, 3, 3)
    assert rotations.align_signs(none).shape == (0, 4)

"""Rotation matrices against SciPy, and what is none."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from leadthrough import rotations
from leadthrough.errors import InvalidInput

unit_quaternions = (
    arrays(float, (4,), elements=st.floats(-1, 1))
    .filter(lambda q: np.linalg.norm(q) > 0.1)
    .map(lambda q: q / np.linalg.norm(q))
)


@given(unit_quaternions)
def test_matrices_agree_with_scipy_both_ways(quaternion):
    matrix = Rotation.from_quat(quaternion[[1, 2, 3, 0]]).as_matrix()
    np.testing.assert_allclose(rotations.to_matrix([quaternion])[0], matrix, atol=1e-15)
    back = rotations.from_matrix([matrix])
    assert rotations.distance(back, [quaternion])[0] < 1e-15
    assert back[0, 0] >= 0


@pytest.mark.parametrize("angle", [0.0, 1e-9, np.pi - 1e-9, np.pi])
@pytest.mark.parametrize("axis", [*np.eye(3), [0.6, 0, -0.8], [1e-9, 1, 1e-9]])
def test_matrices_near_the_identity_and_half_turns_are_read(angle, axis):
    q = rotations.exp([angle * np.array(axis) / np.linalg.norm(axis)])
    assert rotations.distance(rotations.from_matrix(rotations.to_matrix(q)), q)[0] < 1e-15


@given(unit_quaternions, arrays(float, (3, 3), elements=st.floats(-1e-3, 1e-3)))
def test_of_a_rounded_matrix_the_nearest_rotation_is_taken(quaternion, noise):
    rounded = rotations.to_matrix([quaternion])[0] + noise
    left, _, right = np.linalg.svd(rounded)
    nearest = rotations.from_matrix([left @ right])
    assert rotations.distance(rotations.from_matrix([rounded]), nearest)[0] < 1e-14


def test_no_matrices_are_no_rotations():
    assert rotations.from_matrix(np.zeros((0, 3, 3))).shape == (0, 4)


@pytest.mark.parametrize(
    ("matrices", "message"),
    [
        ([np.eye(3), np.diag([1, 1, -1])], "expected rotations, got .* at index 1, determinant -1"),
        ([np.zeros((3, 3))], "matrices: expected rotations"),
        ([1.1 * np.eye(3)], "matrices: expected rotations"),
        ([np.full((3, 3), 1e300)], "matrices: expected rotations"),
        ([np.full((3, 3), np.nan)], "matrices: expected finite"),
        (np.eye(3), "matrices: expected shape"),
    ],
)
def test_what_is_no_rotation_is_refused(matrices, message):
    with pytest.raises(InvalidInput, match=message):
        rotations.from_matrix(matrices)

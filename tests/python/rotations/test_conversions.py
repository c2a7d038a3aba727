"""Rotation matrices, and Euler angles in all twelve conventions."""

import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from leadthrough import rotations
from leadthrough.rotations.conversions import CONVENTIONS

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


angles = arrays(float, (3,), elements=st.floats(-7, 7))
unit_quaternions = (
    arrays(float, (4,), elements=st.floats(-1, 1))
    .filter(lambda q: np.linalg.norm(q) > 0.1)
    .map(lambda q: q / np.linalg.norm(q))
)


def in_turn(values, convention):
    """The moving axes' turns follow from the left to the right, the fixed axes' the other way."""
    turns = [
        rotations.exp([v * np.eye(3)["XYZ".index(a.upper())]])
        for v, a in zip(values, convention, strict=True)
    ]
    if convention.islower():
        turns.reverse()
    return rotations.compose(rotations.compose(turns[0], turns[1]), turns[2])


def test_there_are_twelve_conventions_about_moving_and_as_many_about_fixed_axes():
    assert len(set(CONVENTIONS)) == 24
    assert {"ZYZ", "xyz", "ZYX"} <= {*CONVENTIONS}


@given(angles, st.sampled_from(CONVENTIONS))
def test_angles_are_turns_one_after_the_other(values, convention):
    ours = rotations.from_euler([values], convention=convention)
    assert rotations.distance(ours, in_turn(values, convention))[0] < 1e-14


@given(unit_quaternions, st.sampled_from(CONVENTIONS))
def test_angles_give_the_rotation_back(quaternion, convention):
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Gimbal lock")
        values = rotations.to_euler([quaternion], convention=convention)
    back = rotations.from_euler(values, convention=convention)
    assert rotations.distance(back, [quaternion])[0] < 1e-6  # next to gimbal lock; else 1e-14


@pytest.mark.parametrize(("convention", "locked"), [("ZYZ", 0.0), ("xyz", np.pi / 2)])
def test_gimbal_lock_is_warned_of_and_keeps_the_rotation(convention, locked):
    q = rotations.from_euler([[0.3, locked, 0.5]], convention=convention)
    with pytest.warns(UserWarning, match="Gimbal lock"):
        values = rotations.to_euler(q, convention=convention)
    assert values[0, 2] == 0.0
    back = rotations.from_euler(values, convention=convention)
    assert rotations.distance(back, q)[0] < 1e-7


def test_empty_batches_stay_empty():
    assert rotations.from_euler(np.zeros((0, 3)), convention="ZYZ").shape == (0, 4)
    assert rotations.to_euler(np.zeros((0, 4)), convention="ZYZ").shape == (0, 3)

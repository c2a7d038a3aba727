"""All conventions against products of single turns, and back."""

import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from leadthrough import rotations
from leadthrough.errors import InvalidInput
from leadthrough.rotations.conversions import CONVENTIONS

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


@pytest.mark.parametrize("convention", ["ZZY", "XyZ", "ZY", "", None, "abc"])
def test_unknown_conventions_are_refused(convention):
    for call, rows in ((rotations.from_euler, np.zeros((1, 3))), (rotations.to_euler, np.eye(4))):
        with pytest.raises(InvalidInput, match="convention: expected one of"):
            call(rows, convention=convention)


def test_bad_angles_are_refused():
    with pytest.raises(InvalidInput, match="angles: expected finite"):
        rotations.from_euler([[0, np.inf, 0]], convention="ZYZ")
    with pytest.raises(InvalidInput, match="quaternions: expected unit"):
        rotations.to_euler([[0, 0, 0, 0]], convention="ZYZ")

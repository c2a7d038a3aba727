"""Slerp against SciPy and mpmath."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation, Slerp

from leadthrough import rotations
from leadthrough.errors import InvalidInput

unit_quaternions = (
    arrays(float, (4,), elements=st.floats(-1, 1))
    .filter(lambda q: np.linalg.norm(q) > 0.1)
    .map(lambda q: q / np.linalg.norm(q))
)


@given(unit_quaternions, unit_quaternions, st.floats(0, 1))
def test_slerp_agrees_with_scipy(a, b, fraction):
    if rotations.distance([a], [b])[0] > np.pi - 1e-6:
        return
    theirs = Slerp([0, 1], Rotation.from_quat([a[[1, 2, 3, 0]], b[[1, 2, 3, 0]]]))(fraction)
    ours = rotations.slerp([a], [b], [fraction])
    assert rotations.distance(ours, [theirs.as_quat()[[3, 0, 1, 2]]])[0] < 1e-9
    along = rotations.distance([a], ours)[0]
    assert along == pytest.approx(fraction * rotations.distance([a], [b])[0], abs=1e-14)


@given(unit_quaternions, unit_quaternions)
def test_slerp_leaves_a_and_arrives_at_b(a, b):
    assert np.array_equal(
        rotations.slerp([a], [b], [0])[0], rotations.compose([a], [[1, 0, 0, 0]])[0]
    )
    assert rotations.distance(rotations.slerp([a], [b], [1]), [b])[0] < 1e-14


def test_slerp_of_half_a_turn_takes_the_way_to_b_as_given():
    a, b = [[1.0, 0, 0, 0]], [[0.0, 0, 0, 1]]
    half = np.sqrt(0.5)
    np.testing.assert_allclose(rotations.slerp(a, b, [0.5]), [[half, 0, 0, half]], atol=1e-15)
    np.testing.assert_allclose(
        rotations.slerp(a, np.negative(b), [0.5]), [[half, 0, 0, -half]], atol=1e-15
    )


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((np.eye(4)[:1], np.eye(4)[:1], [[0.5]]), r"fractions: expected shape \(1,\)"),
        ((np.eye(4)[:1], np.eye(4)[:1], [np.inf]), "fractions: expected finite"),
        ((np.eye(4)[:1], np.eye(4)[:1], [1.5]), "fractions: expected numbers from 0 to 1"),
        ((np.eye(4)[:1], np.eye(4)[:2], [0.5]), "b: expected as many rotations as a"),
    ],
)
def test_bad_slerps_are_refused(arguments, message):
    with pytest.raises(InvalidInput, match=message):
        rotations.slerp(*arguments)

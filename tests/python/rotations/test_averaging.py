"""Against SciPy, against slerp, and by the laws of a mean."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from leadthrough import rotations
from leadthrough.errors import InvalidInput

# At most 69 degrees from the identity.
near_identity = arrays(float, (5, 3), elements=st.floats(-0.7, 0.7)).map(rotations.exp)
unit_quaternions = (
    arrays(float, (4,), elements=st.floats(-1, 1))
    .filter(lambda q: np.linalg.norm(q) > 0.1)
    .map(lambda q: q / np.linalg.norm(q))
)
weights = arrays(float, (5,), elements=st.floats(0.01, 1))


def pull(mean, quaternions, weights):
    """The weighted sum of the logarithms towards the rotations: zero at a Karcher mean."""
    back = np.tile(rotations.inverse([mean]), (len(quaternions), 1))
    return weights @ rotations.log(rotations.compose(back, quaternions))


@given(near_identity, weights)
def test_mean_is_where_the_pulls_cancel(quaternions, weights):
    mean = rotations.mean(quaternions, weights=weights)
    assert np.linalg.norm(pull(mean, quaternions, weights)) < 1e-14


@given(arrays(float, (5, 3), elements=st.floats(-2, 2)).map(rotations.exp), weights)
def test_wide_spreads_have_an_exact_mean_or_are_refused(quaternions, weights):
    try:
        mean = rotations.mean(quaternions, weights=weights)
    except InvalidInput:
        return
    assert np.linalg.norm(pull(mean, quaternions, weights)) < 1e-13


@given(near_identity, weights, unit_quaternions)
def test_mean_moves_with_the_rotations(quaternions, weights, turn):
    mean = rotations.mean(quaternions, weights=weights)
    turns = np.tile(turn, (5, 1))
    from_left = rotations.mean(rotations.compose(turns, quaternions), weights=weights)
    from_right = rotations.mean(rotations.compose(quaternions, turns), weights=weights)
    assert rotations.distance([from_left], rotations.compose([turn], [mean]))[0] < 1e-13
    assert rotations.distance([from_right], rotations.compose([mean], [turn]))[0] < 1e-13


@given(near_identity, weights, arrays(bool, (5,)))
def test_mean_is_blind_to_signs_but_for_its_own(quaternions, weights, flips):
    flipped = np.where(flips[:, None], -quaternions, quaternions)
    mean = rotations.mean(quaternions, weights=weights)
    expected = -mean if flips[0] else mean
    np.testing.assert_allclose(rotations.mean(flipped, weights=weights), expected, atol=1e-13)
    assert quaternions[0] @ mean > 0


@given(unit_quaternions, unit_quaternions, st.floats(0, 1))
def test_weighted_mean_of_two_is_slerp(a, b, fraction):
    if rotations.distance([a], [b])[0] > np.pi - 0.01:
        return
    mean = rotations.mean([a, b], weights=[1 - fraction, fraction])
    assert rotations.distance([mean], rotations.slerp([a], [b], [fraction]))[0] < 1e-13


@pytest.mark.parametrize("gap", [1e-3, 1e-5])
@pytest.mark.parametrize("weight", [0.5, 0.1])
def test_rotations_almost_half_a_turn_apart_have_a_mean(gap, weight):
    pair = rotations.exp([[0, 0, 0], [0, 0, np.pi - gap]])
    expected = rotations.slerp(pair[:1], pair[1:], [weight])[0]
    mean = rotations.mean(pair, weights=[1 - weight, weight])
    np.testing.assert_allclose(mean, expected, atol=1e-12)


@pytest.mark.parametrize("gap", [1e-7, 1e-9, 0.0])
@pytest.mark.parametrize("weight", [0.5, 0.1])
def test_rotations_half_a_turn_apart_have_no_mean(gap, weight):
    pair = rotations.exp([[0, 0, 0], [0, 0, np.pi - gap]])
    with pytest.raises(InvalidInput, match="within a quarter turn of their middle"):
        rotations.mean(pair, weights=[1 - weight, weight])


def test_mean_of_small_spreads_is_close_to_scipys_chordal_mean():
    vectors = np.random.default_rng(0).normal(size=(20, 3)) * 1e-4
    turn = Rotation.from_rotvec([1.0, 2.0, -0.5])
    theirs = (turn * Rotation.from_rotvec(vectors)).mean()
    quaternions = (turn * Rotation.from_rotvec(vectors)).as_quat()[:, [3, 0, 1, 2]]
    ours = rotations.mean(quaternions)
    assert rotations.distance([ours], theirs.as_quat()[None, [3, 0, 1, 2]])[0] < 1e-11


def test_many_means_at_once_equal_one_by_one_bit_for_bit():
    rng = np.random.default_rng(1)
    base = rotations.exp(rng.normal(size=(30, 3)))
    layers = [rotations.compose(base, rotations.exp(rng.normal(size=(30, 3)) / 4)) for _ in "abcd"]
    means = rotations.mean(layers, weights=[1, 2, 3, 4])
    singles = [rotations.mean(column, weights=[1, 2, 3, 4]) for column in np.swapaxes(layers, 0, 1)]
    assert np.array_equal(means, singles)


@given(near_identity)
def test_a_rotation_of_weight_zero_does_not_count(quaternions):
    quaternions[0] = [0, 1, 0, 0]
    mean = rotations.mean(quaternions, weights=[0, 1, 1, 1, 1])
    assert np.array_equal(mean, rotations.mean(quaternions[1:]))


@pytest.mark.parametrize("scale", [1e-300, 1e300])
def test_only_the_ratio_of_weights_counts(scale):
    quaternions = rotations.exp([[0.1, 0, 0], [0, 0.2, 0]])
    expected = rotations.mean(quaternions, weights=[1, 2])
    scaled = rotations.mean(quaternions, weights=[scale, 2 * scale])
    np.testing.assert_allclose(scaled, expected, atol=1e-15)


def test_one_rotation_is_its_own_mean_and_no_columns_give_no_means():
    q = rotations.exp([[0.3, -2.0, 0.1]])
    np.testing.assert_allclose(rotations.mean(q), q[0], atol=1e-15)
    assert rotations.mean(np.zeros((3, 0, 4))).shape == (0, 4)

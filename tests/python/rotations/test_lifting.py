"""The continuous logarithm: continuous, exact, and loud where there is none."""

import numpy as np
import pytest
from hypothesis import given, strategies as st
from hypothesis.extra.numpy import arrays
from scipy.optimize import brentq

import leadthrough as lt
from leadthrough import rotations
from leadthrough.errors import NoContinuousLogarithm

# Motions of 40 samples from the identity, at most 5.2 rad away from it.
gentle = arrays(float, (3, 3), elements=st.floats(-1, 1)).map(
    lambda c: np.sin(np.outer(np.linspace(0, 3, 40), [1, 2, 3])) @ c
)
directions = (
    arrays(float, (3,), elements=st.floats(-1, 1))
    .filter(lambda v: np.linalg.norm(v) > 0.1)
    .map(lambda v: v / np.linalg.norm(v))
)


def spin(axis, angles):
    return rotations.exp(np.outer(angles, axis))


@given(gentle, arrays(bool, (40,)))
def test_lift_gives_the_vectors_back_whatever_the_signs(vectors, flips):
    q = rotations.exp(vectors)
    lifted = rotations.lift(np.where(flips[:, None], -q, q))
    np.testing.assert_allclose(lifted, vectors, atol=2e-14)
    assert rotations.distance(rotations.exp(lifted), q).max() < 1e-14
    assert np.array_equal(rotations.lift(q[::-1], anchor="goal"), rotations.lift(q)[::-1])


@given(gentle, st.sampled_from(["start", "goal"]))
def test_the_anchor_is_at_most_half_a_turn_long(vectors, anchor):
    lifted = rotations.lift(rotations.exp(0.6 * vectors), anchor=anchor)
    assert np.linalg.norm(lifted[0 if anchor == "start" else -1]) <= np.pi * (1 + 1e-15)


@given(directions, st.floats(-60, 60), st.floats(0, 3))
def test_turns_about_a_fixed_axis_are_kept(axis, angle, first):
    angles = np.linspace(first, first + angle, 101)
    q = spin(axis, angles)
    np.testing.assert_allclose(rotations.lift(q), np.outer(angles, axis), atol=1e-12)
    from_goal = rotations.lift(q[::-1], anchor="goal")
    np.testing.assert_allclose(from_goal, np.outer(angles[::-1], axis), atol=1e-12)


@given(directions, directions)
def test_two_turns_in_a_turned_frame_pass_the_whole_turn(axis, other):
    """Conjugation leaves rounding in what was exactly the identity."""
    angles = np.linspace(0, 4 * np.pi, 401)
    frame = np.tile(rotations.exp([other * 2.0]), (401, 1))
    q = rotations.compose(rotations.compose(frame, spin(axis, angles)), rotations.inverse(frame))
    lifted = rotations.lift(q)
    np.testing.assert_allclose(np.linalg.norm(lifted, axis=1), angles, atol=1e-12)
    assert np.linalg.norm(np.diff(lifted, axis=0), axis=1).max() < 0.04


@pytest.mark.parametrize("offset", [0.0, 1e-16, 1e-13, 1e-11, 3e-11, 1e-9, 1e-6, 1e-3])
def test_a_pause_at_a_whole_turn_stays_there(offset):
    angles = [0, 2, 4, 6, *[2 * np.pi - offset] * 20, *[2 * np.pi + offset] * 20, 7, 9, 11]
    axis = np.array([0.6, 0.0, 0.8])
    tilt = rotations.exp([[0.3, -0.4, 1.0]] * len(angles))
    q = rotations.compose(rotations.compose(tilt, spin(axis, angles)), rotations.inverse(tilt))
    expected = np.outer(angles, rotations.to_matrix(tilt)[0] @ axis)
    np.testing.assert_allclose(rotations.lift(q), expected, atol=1e-3)
    assert rotations.distance(rotations.exp(rotations.lift(q)), q).max() < 3e-11


def test_a_motion_through_a_whole_turn_while_its_axis_moves_is_lifted():
    phase = np.linspace(0, 1, 500)
    axes = np.column_stack([np.sin(0.5 * phase), np.zeros(500), np.cos(0.5 * phase)])
    vectors = 3.9 * np.pi * phase[:, None] * axes
    np.testing.assert_allclose(rotations.lift(rotations.exp(vectors)), vectors, atol=1e-9)


@pytest.mark.parametrize("miss", [1e-3, 0.03])
@pytest.mark.parametrize("anchor", ["start", "goal"])
def test_passing_beside_a_whole_turn_is_refused_with_its_sample(miss, anchor):
    """Turned off its axis by `miss`, the motion never is the identity: the axis swings round."""
    angles = np.linspace(1, 4 * np.pi - 1, 5000)
    q = rotations.compose(
        np.tile(rotations.exp([[miss, 0, 0]]), (5000, 1)), spin([0, 0, 1], angles)
    )
    if anchor == "goal":
        q = q[::-1]
    with pytest.raises(NoContinuousLogarithm, match="no rotation vector of sample") as caught:
        rotations.lift(q, anchor=anchor)
    beside = angles[caught.value.index if anchor == "start" else 4999 - caught.value.index]
    assert abs(beside - 2 * np.pi) < 0.5


@pytest.mark.parametrize(("gain", "refused"), [(9.0, False), (11.0, True)])
def test_beside_a_whole_turn_a_vector_may_move_ten_times_as_far_as_its_rotation(gain, refused):
    half = brentq(lambda x: x / np.sin(x) - gain, 1.0, np.pi - 1e-3)
    about = np.linspace(0.0, 0.5, 50)
    circle = 2.0 * half * np.column_stack([np.cos(about), np.sin(about), 0.0 * about])
    vectors = np.concatenate([np.linspace(0.0, 1.0, 100)[1:, None] * circle[0], circle])
    if refused:
        with pytest.raises(NoContinuousLogarithm):
            rotations.lift(rotations.exp(vectors))
    else:
        np.testing.assert_allclose(rotations.lift(rotations.exp(vectors)), vectors, atol=1e-9)


def test_half_a_turn_between_samples_is_refused():
    for gap, refused in [(1e-3, False), (1e-9, True), (0.0, True)]:
        q = rotations.exp([[0, 0, 0.5], [0, 0, 0.5 + np.pi - gap]])
        if refused:
            with pytest.raises(NoContinuousLogarithm, match="180 degrees away") as caught:
                rotations.lift(q)
            assert caught.value.index == 1
        else:
            assert rotations.lift(q)[1, 2] == pytest.approx(0.5 + np.pi - gap)


def test_an_anchor_half_a_turn_away_takes_the_sign_as_given():
    q = np.array([[0.0, 0, 0, 1]])
    np.testing.assert_allclose(rotations.lift(q), [[0, 0, np.pi]], rtol=1e-15)
    np.testing.assert_allclose(rotations.lift(-q), [[0, 0, -np.pi]], rtol=1e-15)


def test_recorded_orientations_are_lifted(recordings):
    columns = {
        "positions": [f"current_pos_{axis}" for axis in "xyz"],
        "orientations": [f"current_orientation_{part}" for part in "wxyz"],
    }
    path = recordings / "panda_execution" / "trial1.csv"
    recorded = lt.read_motion(path, columns=columns, rate=20)
    q = recorded.orientations
    from_first = rotations.compose(q, np.tile(rotations.inverse(q[:1]), (len(q), 1)))
    assert np.pi - np.linalg.norm(rotations.log(from_first), axis=1).max() < 1e-5
    signs = np.where(np.random.default_rng(0).random(len(q)) < 0.5, -1.0, 1.0)
    for motion in (q, from_first):
        for anchor in ("start", "goal"):
            lifted = rotations.lift(motion * signs[:, None], anchor=anchor)
            assert rotations.distance(rotations.exp(lifted), motion).max() < 1e-14
            steps = np.linalg.norm(np.diff(lifted, axis=0), axis=1)
            turned = rotations.distance(motion[1:], motion[:-1])
            half = np.linalg.norm(lifted, axis=1).max() / 2
            assert (steps <= 1.01 * half / np.sin(half) * turned + 1e-12).all()
            assert steps.max() < 0.1  # the plain logarithm jumps by a whole turn

"""Slerp and squad, and derivatives of rotations, against SciPy and closed forms."""

import numpy as np
import pytest
from hypothesis import given, strategies as st
from hypothesis.extra.numpy import arrays
from rotations.test_group import unit_quaternions
from scipy.spatial.transform import Rotation, Slerp

from leadthrough import rotations, trajectories
from leadthrough.errors import InvalidInput


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


def curve(times):
    t = np.asarray(times)[:, None]
    first = rotations.exp(np.sin(2 * t) * [0, 0.6, 0.8])
    return rotations.compose(first, rotations.exp((np.cos(3 * t) + t) * [1.0, 0, 0]))


def uneven(count):
    """Times from 0 to 2 s whose steps differ by a factor of up to four."""
    steps = np.random.default_rng(0).uniform(1, 4, count)
    return np.concatenate([[0], np.cumsum(steps)]) * 2 / steps.sum()


@pytest.mark.parametrize("between", [rotations.interpolate, rotations.squad])
def test_curves_pass_through_their_samples_with_continuous_signs(between):
    times = uneven(30)
    q = curve(times)
    flipped = q * np.where(np.arange(31) % 3 == 1, -1.0, 1.0)[:, None]
    np.testing.assert_allclose(between(times, flipped, times), q, atol=1e-14)
    dense = between(times, flipped, np.linspace(0, times[-1], 5000))
    assert np.abs(np.diff(dense, axis=0)).max() < 0.01


def test_interpolate_agrees_with_scipy():
    times, at = uneven(30), np.linspace(0, 1.99, 501)
    q = curve(times)
    theirs = Slerp(times, Rotation.from_quat(q[:, [1, 2, 3, 0]]))(at).as_quat()[:, [3, 0, 1, 2]]
    assert rotations.distance(rotations.interpolate(times, q, at), theirs).max() < 1e-14


def test_the_curve_of_slerps_is_scipys_and_passes_through_every_sample():
    times, between = uneven(30), np.linspace(0, 1.99, 301)
    q = curve(times)
    slerps = trajectories.Slerp(times, q)
    theirs = Slerp(times, Rotation.from_quat(q[:, [1, 2, 3, 0]]))(between).as_quat()
    found = slerps.evaluate(between)
    assert rotations.distance(found, theirs[:, [3, 0, 1, 2]]).max() < 1e-14
    np.testing.assert_array_equal(slerps.evaluate(times), slerps.quaternions)


def test_squad_has_the_velocity_of_the_samples_on_both_sides_of_each():
    times = uneven(12)
    q = curve(times)
    expected = rotations.angular_velocity(times, q)
    step = 1e-6
    for side, rows in ((step, slice(0, -1)), (-step, slice(1, None))):
        near = rotations.squad(times, q, times[rows] + side)
        turned = rotations.log(rotations.compose(near, rotations.inverse(q[rows])))
        np.testing.assert_allclose(turned / side, expected[rows], atol=1e-4)


def test_squad_is_nearer_to_a_smooth_motion_than_slerp():
    times, at = uneven(40), np.linspace(0, 1.99, 2001)
    off = [
        rotations.distance(between(times, curve(times), at), curve(at)).max()
        for between in (rotations.interpolate, rotations.squad)
    ]
    assert off[1] < 0.1 * off[0]


def test_squad_on_even_times_is_shoemakes_curve():
    times = np.arange(6.0)
    q = curve(times / 5)
    back, onwards = (
        rotations.log(rotations.compose(rotations.inverse(q[1:-1]), q[rows]))
        for rows in (slice(0, -2), slice(2, None))
    )
    inner = rotations.compose(q[1:-1], rotations.exp(-(back + onwards) / 4))
    u = np.full(3, 0.3)
    chord = rotations.slerp(q[1:-2], q[2:-1], u)
    expected = rotations.slerp(chord, rotations.slerp(inner[:-1], inner[1:], u), 2 * u * (1 - u))
    ours = rotations.squad(times, q, times[1:4] + 0.3)
    assert rotations.distance(ours, expected).max() < 1e-14


def test_two_samples_are_joined_by_slerp():
    q = rotations.exp([[0.1, 0.2, 0.3], [1.0, -1.0, 0.5]])
    at = [1.0, 2.0, 4.5, 5.0]
    fractions = (np.array(at) - 1) / 4
    expected = rotations.slerp(*(np.repeat(end[None], 4, axis=0) for end in q), fractions)
    for between in (rotations.interpolate, rotations.squad):
        np.testing.assert_allclose(between([1, 5], q, at), expected, atol=1e-14)
        assert between([1, 5], q, []).shape == (0, 4)


U, V = np.array([0, 0.6, 0.8]), np.array([1.0, 0, 0])
vectors = arrays(float, (3,), elements=st.floats(-8, 8))


def motion(times):
    """Turned by b(t) about V, then by a(t) about U; velocity and acceleration in the base frame."""
    t = times[:, None]
    a, da, dda = np.sin(2 * t), 2 * np.cos(2 * t), -4 * np.sin(2 * t)
    b, db, ddb = np.cos(3 * t) + t, 1 - 3 * np.sin(3 * t), -9 * np.cos(3 * t)
    outer = rotations.exp(a * U)
    axis = rotations.to_matrix(outer) @ V
    velocities = da * U + db * axis
    accelerations = dda * U + ddb * axis + np.cross(da * U, db * axis)
    return rotations.compose(outer, rotations.exp(b * V)), velocities, accelerations


def errors(times):
    q, velocities, accelerations = motion(times)
    return np.array(
        [
            np.abs(rotations.angular_velocity(times, q) - velocities).max(),
            np.abs(rotations.angular_acceleration(times, q) - accelerations).max(),
            rotations.distance(rotations.integrate(times, velocities, q[0]), q).max(),
        ]
    )


def test_errors_fall_with_the_square_of_even_steps_ends_included():
    coarse, fine = (errors(np.linspace(0, 2, count + 1)) for count in (100, 400))
    assert (coarse / fine > 14).all()
    assert (fine < [3e-4, 3e-3, 1e-4]).all()


def test_errors_fall_with_the_square_of_uneven_steps():
    coarse, fine = (errors(uneven(count)) for count in (100, 1600))
    assert (coarse / fine > 150).all()  # 256 when the largest steps fall together
    assert (fine < [1e-4, 1e-3, 1e-4]).all()


@given(vectors.filter(lambda v: np.linalg.norm(v) < 2), vectors)
def test_even_turning_is_exact(velocity, first):
    times = uneven(20)
    start = rotations.exp([first])
    q = rotations.compose(rotations.exp(np.outer(times, velocity)), np.repeat(start, 21, axis=0))
    np.testing.assert_allclose(
        rotations.angular_velocity(times, q), np.tile(velocity, (21, 1)), atol=1e-12
    )
    np.testing.assert_allclose(rotations.angular_acceleration(times, q), 0, atol=1e-10)
    turned = rotations.integrate(times, np.tile(velocity, (21, 1)), start[0])
    assert rotations.distance(turned, q).max() < 1e-13


@given(vectors, arrays(float, (3,), elements=st.floats(-1, 1)))
def test_left_jacobian_turns_vector_derivatives_into_angular_velocity(vector, derivative):
    step = 1e-5
    ends = rotations.exp([vector - step * derivative, vector + step * derivative])
    turned = rotations.log(rotations.compose(ends[1:], rotations.inverse(ends[:1])))[0]
    expected = rotations.left_jacobian([vector])[0] @ derivative
    np.testing.assert_allclose(turned / (2 * step), expected, atol=1e-8)


@pytest.mark.parametrize("turns", [1, 2, -3])
@pytest.mark.parametrize("offset", [0.0, 1e-7, -1e-7])
def test_at_whole_turns_there_is_no_inverse_jacobian(turns, offset):
    with pytest.raises(InvalidInput, match=r"whole number of turns long, got .* at row 1"):
        rotations.left_jacobian_inverse([[0, 0, 0], [0, 0, 2 * np.pi * turns + offset]])
    assert np.isfinite(rotations.left_jacobian_inverse([[0, 0, 2 * np.pi * turns + 3e-6]])).all()


def test_few_samples_give_what_they_can():
    q = rotations.exp([[0, 0, 0], [0, 0, 0.2], [0, 0, 0.6]])
    np.testing.assert_allclose(rotations.angular_velocity([0, 2], q[:2]), [[0, 0, 0.1]] * 2)
    np.testing.assert_allclose(rotations.angular_acceleration([0, 1, 2], q), [[0, 0, 0.2]] * 3)
    assert np.array_equal(rotations.integrate([5.0], [[1, 2, 3]], q[1]), q[1:2])


def test_huge_vectors_have_finite_jacobians():
    huge = [[1.7e308, 1.7e308, 1.7e308], [0, 0, 1e300]]
    assert np.isfinite(rotations.left_jacobian(huge)).all()
    assert np.isfinite(rotations.left_jacobian_inverse(huge)).all()
    assert np.isfinite(rotations.exp(huge)).all()

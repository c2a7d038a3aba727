"""Angular velocity and acceleration against a motion known in closed form, and by their laws."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from leadthrough import rotations
from leadthrough.errors import InvalidInput

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


def uneven(count):
    """Times from 0 to 2 s whose steps differ by a factor of up to four."""
    steps = np.random.default_rng(0).uniform(1, 4, count)
    return np.concatenate([[0], np.cumsum(steps)]) * 2 / steps.sum()


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


def test_integrating_the_velocity_of_samples_gives_them_back():
    times = uneven(1000)
    q = motion(times)[0]
    back = rotations.integrate(times, rotations.angular_velocity(times, q), q[0])
    assert rotations.distance(back, q).max() < 1e-4


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


@given(vectors)
def test_the_inverse_jacobian_is_the_inverse(vector):
    angle = np.linalg.norm(vector)
    assume(angle < 6 or abs(np.sin(angle / 2)) > 1e-3)
    product = rotations.left_jacobian([vector])[0] @ rotations.left_jacobian_inverse([vector])[0]
    np.testing.assert_allclose(product, np.eye(3), atol=1e-11)


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


def test_empty_batches_stay_empty():
    assert rotations.left_jacobian(np.zeros((0, 3))).shape == (0, 3, 3)
    assert rotations.left_jacobian_inverse(np.zeros((0, 3))).shape == (0, 3, 3)

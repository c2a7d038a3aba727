"""Every formula with a branch or a singularity against 50 digits, on both sides of each."""

import mpmath
import numpy as np
import pytest

from leadthrough import rotations

mpmath.mp.dps = 50

AXES = np.array([[1.0, 2, -2], [0, 0, 1], [-0.3, 0.1, 1e-8], [1, -1, 1]])
AXES /= np.linalg.norm(AXES, axis=1, keepdims=True)

SMALL = [0.0, 5e-324, 1e-300, 1e-160, 1e-12, 1e-8]
SERIES = [1.999e-4, 2e-4, 2.001e-4]  # exp changes its formula at half an angle of 1e-4
TURNS = [
    centre + offset
    for centre in (np.pi, 2 * np.pi, 4 * np.pi)
    for offset in (-0.1, -1e-5, -1e-8, 0.0, 1e-8, 1e-5, 0.1)
]
ANGLES = [*SMALL, *SERIES, 1.0, *TURNS, 1e3]


def exact_exp(vector):
    v = mpmath.matrix(vector.tolist())
    half = mpmath.norm(v) / 2
    scale = mpmath.sin(half) / (2 * half) if half else mpmath.mpf(1) / 2
    return np.array([mpmath.cos(half), *(scale * v)], dtype=object)


def exact_log(quaternion):
    w, *v = (mpmath.mpf(float(component)) for component in quaternion)
    sine = mpmath.norm(mpmath.matrix(v))
    if not sine:
        return np.array(v, dtype=object)
    scale = 2 * mpmath.atan2(sine, abs(w)) / sine * (-1 if w < 0 else 1)
    return np.array([scale * component for component in v], dtype=object)


def exact_left_jacobian(vector):
    """The integral of exp(s phi) over s from 0 to 1, in closed form."""
    v = mpmath.matrix(vector.tolist())
    angle = mpmath.norm(v)
    if not angle:
        return mpmath.eye(3)
    k = mpmath.matrix([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]]) / angle
    across = (1 - mpmath.cos(angle)) / angle
    return mpmath.eye(3) + across * k + (1 - mpmath.sin(angle) / angle) * k * k


def as_array(matrix):
    return np.array(matrix.tolist(), dtype=float)


@pytest.mark.parametrize("angle", ANGLES)
def test_exp(angle):
    vectors = angle * AXES
    exact = np.array([exact_exp(vector) for vector in vectors])
    tolerance = 3e-16 * max(1.0, angle)  # the rounding of half the angle
    assert np.abs(rotations.exp(vectors) - exact).max() < tolerance


@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize("sign", [-1, 1])
def test_log(angle, sign):
    quaternions = sign * rotations.exp(angle * AXES)
    quaternions /= np.linalg.norm(quaternions, axis=1, keepdims=True)
    exact = np.array([exact_log(quaternion) for quaternion in quaternions])
    error = np.abs(rotations.log(quaternions) - exact).max(axis=1)
    # Normalising may turn the last bit of w over: at half a turn that is an angle of 2e-16.
    assert (error <= 1e-15).all()
    small = np.abs(exact).max(axis=1) < 1e-3
    assert (error[small] <= 1e-15 * np.abs(exact[small]).max(axis=1) + 5e-324).all()


@pytest.mark.parametrize("angle", ANGLES)
def test_left_jacobian(angle):
    vectors = angle * AXES
    exact = [as_array(exact_left_jacobian(vector)) for vector in vectors]
    np.testing.assert_allclose(rotations.left_jacobian(vectors), exact, rtol=0, atol=1e-15)


@pytest.mark.parametrize("angle", [a for a in ANGLES if a < 6 or abs(np.sin(a / 2)) > 1e-6])
def test_left_jacobian_inverse(angle):
    vectors = angle * AXES
    exact = np.array([as_array(exact_left_jacobian(vector) ** -1) for vector in vectors])
    beside = abs(np.sin(angle / 2)) if angle > 6 else 1.0
    relative = 1e-15 * max(1.0, angle) / beside  # of the distance to the whole turn
    error = np.abs(rotations.left_jacobian_inverse(vectors) - exact).max()
    assert error < relative * np.abs(exact).max()


@pytest.mark.parametrize("angle", [a for a in ANGLES if a < np.pi])
@pytest.mark.parametrize("fraction", [0.0, 1e-9, 0.3, 1.0])
def test_slerp_from_the_identity(angle, fraction):
    ends = rotations.exp(angle * AXES)
    ours = rotations.slerp([[1.0, 0, 0, 0]] * 4, ends, [fraction] * 4)
    exact = [
        exact_exp(np.array([mpmath.mpf(fraction) * x for x in exact_log(end)], dtype=object))
        for end in ends
    ]
    assert np.abs(ours - np.array(exact)).max() < 1e-15


@pytest.mark.parametrize("angle", [a for a in ANGLES if a > np.pi and a < 20])
def test_lift_counts_turns_to_the_last_digits(angle):
    for axis in AXES:
        spin = np.linspace(0, angle, 13)[:, None] * axis
        ours = rotations.lift(rotations.exp(spin))
        np.testing.assert_allclose(ours, spin, rtol=0, atol=5e-15 * angle)

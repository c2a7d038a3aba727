"""Group operations, conversions and means of rotations, against SciPy."""

import warnings
from itertools import product

import mpmath
import numpy as np
import pytest
from hypothesis import given, strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from leadthrough import rotations
from leadthrough.errors import InvalidInput

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


@given(unit_quaternions)
def test_exp_inverts_log_for_any_rotation(quaternion):
    back = rotations.exp(rotations.log([quaternion]))
    assert rotations.distance(back, [quaternion])[0] < 1e-14


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


NO_ROTATIONS, NO_VECTORS = np.zeros((0, 4)), np.zeros((0, 3))


@pytest.mark.parametrize(
    ("made", "shape"),
    [
        (rotations.exp(NO_VECTORS), (0, 4)),
        (rotations.log(NO_ROTATIONS), (0, 3)),
        (rotations.compose(NO_ROTATIONS, NO_ROTATIONS), (0, 4)),
        (rotations.distance(NO_ROTATIONS, NO_ROTATIONS), (0,)),
        (rotations.to_matrix(NO_ROTATIONS), (0, 3, 3)),
        (rotations.from_matrix(np.zeros((0, 3, 3))), (0, 4)),
        (rotations.align_signs(NO_ROTATIONS), (0, 4)),
        (rotations.from_euler(NO_VECTORS, convention="ZYZ"), (0, 4)),
        (rotations.to_euler(NO_ROTATIONS, convention="ZYZ"), (0, 3)),
        (rotations.mean(np.zeros((3, 0, 4))), (0, 4)),
        (rotations.left_jacobian(NO_VECTORS), (0, 3, 3)),
        (rotations.left_jacobian_inverse(NO_VECTORS), (0, 3, 3)),
        (rotations.lift(NO_ROTATIONS), (0, 3)),
        (rotations.lift(NO_ROTATIONS, anchor="goal"), (0, 3)),
    ],
)
def test_empty_batches_stay_empty(made, shape):
    assert made.shape == shape


@given(unit_quaternions)
def test_matrices_agree_with_scipy_both_ways(quaternion):
    matrix = Rotation.from_quat(quaternion[[1, 2, 3, 0]]).as_matrix()
    np.testing.assert_allclose(rotations.to_matrix([quaternion])[0], matrix, atol=1e-15)
    back = rotations.from_matrix([matrix])
    assert rotations.distance(back, [quaternion])[0] < 1e-15
    assert back[0, 0] >= 0


@given(unit_quaternions, arrays(float, (3, 3), elements=st.floats(-1e-3, 1e-3)))
def test_of_a_rounded_matrix_the_nearest_rotation_is_taken(quaternion, noise):
    rounded = rotations.to_matrix([quaternion])[0] + noise
    left, _, right = np.linalg.svd(rounded)
    nearest = rotations.from_matrix([left @ right])
    assert rotations.distance(rotations.from_matrix([rounded]), nearest)[0] < 1e-14


angles = arrays(float, (3,), elements=st.floats(-7, 7))


AXES = [a + b + c for a, b, c in product("XYZ", repeat=3) if a != b != c]
CONVENTIONS = [*AXES, *map(str.lower, AXES)]  # about moving and about fixed axes


def in_turn(values, convention):
    """The moving axes' turns follow from the left to the right, the fixed axes' the other way."""
    turns = [
        rotations.exp([v * np.eye(3)["XYZ".index(a.upper())]])
        for v, a in zip(values, convention, strict=True)
    ]
    if convention.islower():
        turns.reverse()
    return rotations.compose(rotations.compose(turns[0], turns[1]), turns[2])


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


# At most 69 degrees from the identity.
near_identity = arrays(float, (5, 3), elements=st.floats(-0.7, 0.7)).map(rotations.exp)
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


def test_one_rotation_is_its_own_mean():
    q = rotations.exp([[0.3, -2.0, 0.1]])
    np.testing.assert_allclose(rotations.mean(q), q[0], atol=1e-15)


I = np.eye(4)  # four unit quaternions  # noqa: E741
QUARTERS = rotations.exp([[0, 0, 0], [0, 0, 1.6], [0, 0, 3.2], [0, 0, 4.8]])
UNEVEN = [-2e250, -1e250, 0.0, 1e-100, 1e250, 2e250]
CURVE = rotations.exp(np.outer(np.arange(6), [0.1, 0.3, 0.2]))
NOT_MATRICES = (
    [np.eye(3), np.diag([1, 1, -1])],
    [np.zeros((3, 3))],
    [1.1 * np.eye(3)],
    [np.full((3, 3), 1e300)],
    [np.full((3, 3), np.nan)],
    np.eye(3),
)
CALLS = [
    (rotations.exp, "rotation_vectors", ([1.0, 2.0, 3.0],)),
    (rotations.exp, "rotation_vectors", ([[np.nan, 0, 0]],)),
    (rotations.log, "quaternions", ([[0.0, 0, 0, 0]],)),
    (rotations.log, "quaternions", (np.eye(3),)),
    (rotations.to_matrix, "quaternions", ([[np.inf, 0, 0, 0]],)),
    (rotations.compose, "b", (I[:1], I[:2])),
    (rotations.distance, "b", (I, "q")),
    (rotations.align_signs, "quaternions", (None,)),
    *((rotations.from_matrix, "matrices", (each,)) for each in NOT_MATRICES),
    (rotations.from_euler, "angles", ([[0, np.inf, 0]], "ZYZ")),
    (rotations.to_euler, "quaternions", ([[0, 0, 0, 0]], "ZYZ")),
    *(
        (call, "convention", (rows, name))
        for name in ("ZZY", "XyZ", "ZY", "", None, "abc")
        for call, rows in ((rotations.from_euler, np.zeros((1, 3))), (rotations.to_euler, I))
    ),
    (rotations.lift, "quaternions", ([1.0, 0, 0, 0],)),
    (rotations.lift, "quaternions", ([[np.nan, 0, 0, 0]],)),
    (rotations.lift, "anchor", (I[:1], "middle")),
    (rotations.mean, "quaternions", (np.zeros((0, 4)),)),
    (rotations.mean, "quaternions", ([1.0, 0, 0, 0],)),
    (rotations.mean, "quaternions", ([[1.0, 0, 0, 0], [1.0]],)),
    (rotations.mean, "quaternions", ([[1.0, 0, 0, np.nan]],)),
    (rotations.mean, "quaternions", (I,)),  # not within a quarter turn of their middle
    (rotations.mean, "quaternions", (I[:2, None],)),
    (rotations.mean, "weights", (I[:2], [1.0])),
    (rotations.mean, "weights", (I[:2], [1.0, -1.0])),
    (rotations.mean, "weights", (I[:2], [0.0, 0.0])),
    (rotations.slerp, "fractions", (I[:1], I[:1], [[0.5]])),
    (rotations.slerp, "fractions", (I[:1], I[:1], [np.inf])),
    (rotations.slerp, "fractions", (I[:1], I[:1], [1.5])),
    (rotations.slerp, "b", (I[:1], I[:2], [0.5])),
    *(
        (between, argument, given)
        for between in (rotations.interpolate, rotations.squad)
        for argument, given in (
            ("at", ([0, 1], I[:2], [1.5])),
            ("at", ([0, 1], I[:2], [np.nan])),
            ("at", ([0, 1], I[:2], 0.5)),
            ("quaternions", ([0, 1], I[:3], [0.5])),
            ("times", ([0], I[:1], [0.0])),
            ("times", ([1, 0], I[:2], [0.5])),
        )
    ),
    (rotations.squad, "times", (UNEVEN, CURVE, [1.0])),  # no velocity is carried over
    (rotations.angular_velocity, "quaternions", ([0, 1], QUARTERS)),
    (rotations.angular_velocity, "quaternions", ([0, 1, 2, 3], QUARTERS)),  # half a turn
    (rotations.angular_velocity, "times", ([0], QUARTERS[:1])),
    (rotations.angular_velocity, "times", ([0, 0], QUARTERS[:2])),
    (rotations.angular_velocity, "times", ([0, 1e-320], QUARTERS[:2])),
    (rotations.angular_acceleration, "times", ([0, 1], QUARTERS[:2])),
    (rotations.integrate, "angular_velocities", ([0, 1], [[1, 0, 0]], I[0])),
    (rotations.integrate, "angular_velocities", ([0, 1e200], [[1e200, 0, 0]] * 2, I[0])),
    (rotations.integrate, "start", ([0], [[1, 0, 0]], [1, 0, 0])),
    (rotations.left_jacobian, "rotation_vectors", ([1, 2, 3],)),
    (rotations.left_jacobian_inverse, "rotation_vectors", ([[np.nan, 0, 0]],)),
]
KEYWORDS = {
    rotations.from_euler: "convention",
    rotations.to_euler: "convention",
    rotations.lift: "anchor",
    rotations.mean: "weights",
}


@pytest.mark.parametrize(
    ("call", "argument", "given"), CALLS, ids=lambda each: getattr(each, "__name__", None)
)
def test_wrong_arguments_are_refused_by_name(call, argument, given):
    first, *rest = given
    keyword = KEYWORDS.get(call)
    with pytest.raises(InvalidInput) as error:
        call(first, **dict(zip([keyword], rest, strict=False))) if keyword else call(*given)
    assert error.value.argument == argument


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
HARD_ANGLES = [*SMALL, *SERIES, 1.0, *TURNS, 1e3]


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


@pytest.mark.parametrize("angle", HARD_ANGLES)
def test_exp(angle):
    vectors = angle * AXES
    exact = np.array([exact_exp(vector) for vector in vectors])
    tolerance = 3e-16 * max(1.0, angle)  # the rounding of half the angle
    assert np.abs(rotations.exp(vectors) - exact).max() < tolerance


@pytest.mark.parametrize("angle", HARD_ANGLES)
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


@pytest.mark.parametrize("angle", HARD_ANGLES)
def test_left_jacobian(angle):
    vectors = angle * AXES
    exact = [as_array(exact_left_jacobian(vector)) for vector in vectors]
    np.testing.assert_allclose(rotations.left_jacobian(vectors), exact, rtol=0, atol=1e-15)


@pytest.mark.parametrize("angle", [a for a in HARD_ANGLES if a < 6 or abs(np.sin(a / 2)) > 1e-6])
def test_left_jacobian_inverse(angle):
    vectors = angle * AXES
    exact = np.array([as_array(exact_left_jacobian(vector) ** -1) for vector in vectors])
    beside = abs(np.sin(angle / 2)) if angle > 6 else 1.0
    relative = 1e-15 * max(1.0, angle) / beside  # of the distance to the whole turn
    error = np.abs(rotations.left_jacobian_inverse(vectors) - exact).max()
    assert error < relative * np.abs(exact).max()


@pytest.mark.parametrize("angle", [a for a in HARD_ANGLES if a < np.pi])
@pytest.mark.parametrize("fraction", [0.0, 1e-9, 0.3, 1.0])
def test_slerp_from_the_identity(angle, fraction):
    ends = rotations.exp(angle * AXES)
    ours = rotations.slerp([[1.0, 0, 0, 0]] * 4, ends, [fraction] * 4)
    exact = [
        exact_exp(np.array([mpmath.mpf(fraction) * x for x in exact_log(end)], dtype=object))
        for end in ends
    ]
    assert np.abs(ours - np.array(exact)).max() < 1e-15


@pytest.mark.parametrize("angle", [a for a in HARD_ANGLES if a > np.pi and a < 20])
def test_lift_counts_turns_to_the_last_digits(angle):
    for axis in AXES:
        spin = np.linspace(0, angle, 13)[:, None] * axis
        ours = rotations.lift(rotations.exp(spin))
        np.testing.assert_allclose(ours, spin, rtol=0, atol=5e-15 * angle)

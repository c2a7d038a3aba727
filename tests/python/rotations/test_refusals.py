"""Wrong arguments of rotations: each is refused by its name."""

import numpy as np
import pytest

from leadthrough import rotations
from leadthrough.errors import InvalidInput

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

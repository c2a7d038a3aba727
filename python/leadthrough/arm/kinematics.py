"""Poses, Jacobians and what they tell, of one configuration or of many at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from leadthrough import _core, check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput

# A singular value below this share of the largest one is rounding.
_SINGULAR = 6 * np.finfo(np.float64).eps


def forward_kinematics(chain: _core.Chain, q: Any) -> tuple[Float64Array, Float64Array]:
    """See `Arm.forward_kinematics`."""
    batch, (rows,) = joint_rows(chain, q=q)
    positions, orientations = chain.forward_kinematics(rows)
    return (positions, orientations) if batch else (positions[0], orientations[0])


def jacobian(chain: _core.Chain, q: Any) -> Float64Array:
    """See `Arm.jacobian`."""
    return _matrices(_core.jacobian, chain, q=q)


def jacobian_derivative(chain: _core.Chain, q: Any, qd: Any) -> Float64Array:
    """See `Arm.jacobian_derivative`."""
    return _matrices(_core.jacobian_derivative, chain, q=q, qd=qd)


def jacobian_second_derivative(chain: _core.Chain, q: Any, qd: Any, qdd: Any) -> Float64Array:
    """See `Arm.jacobian_second_derivative`."""
    return _matrices(_core.jacobian_second_derivative, chain, q=q, qd=qd, qdd=qdd)


def manipulability(chain: _core.Chain, q: Any) -> Float64Array:
    """See `Arm.manipulability`."""
    return np.asarray(_singular_values(jacobian(chain, q)).prod(axis=-1))


def condition_number(chain: _core.Chain, q: Any, *, rotation_weight: float = 0.3) -> Float64Array:
    """See `Arm.condition_number`."""
    weight = check.number(rotation_weight, "rotation_weight", above=0.0)
    weights = np.repeat((1.0, weight), 3)[:, None]
    values = _singular_values(weights * jacobian(chain, q))
    largest, smallest = values[..., 0], values[..., -1]
    regular = smallest > _SINGULAR * largest
    return np.asarray(
        np.divide(largest, smallest, out=np.full_like(largest, np.inf), where=regular)
    )


def joint_rows(chain: _core.Chain, **values: Any) -> tuple[bool, list[Float64Array]]:
    """Whether the values are batches, and each as checked rows (m, joints).

    values: all (joints,) or all (m, joints) with the same m. Raises InvalidInput.
    """
    shapes: Sequence[tuple[int | str, ...]] = ((chain.joints,), ("m", chain.joints))
    rows = []
    for name, value in values.items():
        rows.append(check.array_of_rank(value, name, shapes=shapes))
        shapes = (rows[0].shape,)
    if rows[0].ndim == 2:
        return True, rows
    return False, [row[None] for row in rows]


def finite(result: Float64Array) -> Float64Array:
    """`result`, unless numbers too large to compute with went into it. Raises InvalidInput."""
    if not np.isfinite(result).all():
        raise InvalidInput("joint values, velocities or accelerations are too large: they overflow")
    return result


def _singular_values(matrices: Float64Array) -> Float64Array:
    return np.asarray(np.linalg.svd(finite(matrices), compute_uv=False))


def _matrices(
    kernel: Callable[..., Float64Array], chain: _core.Chain, **values: Any
) -> Float64Array:
    batch, rows = joint_rows(chain, **values)
    matrices = finite(kernel(chain, *rows)).reshape(len(rows[0]), 6, chain.joints)
    return matrices if batch else matrices[0]

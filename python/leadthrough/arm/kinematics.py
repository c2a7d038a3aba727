"""Poses, Jacobians and measures of dexterity, of one configuration or of many at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput

# A singular value below this fraction of the largest one is rounding.
_SINGULAR = 6 * np.finfo(np.float64).eps
# m per rad: about the reach of an arm's wrist.
ROTATION_WEIGHT = 0.3


def jacobian(chain: core.Chain, q: ArrayLike) -> Float64Array:
    """Jacobian (6, joints) of a configuration, or (m, 6, joints) of a batch."""
    matrix = core.jacobian_of_one(chain, q)
    if matrix is not None:
        return matrix
    return matrices(core.jacobian, chain, q=q)


def matrices(
    kernel: Callable[..., Float64Array], chain: core.Chain, **values: ArrayLike
) -> Float64Array:
    """A kernel's matrices (6, joints) of a configuration, or (m, 6, joints) of a batch."""
    batch, rows = joint_rows(chain, **values)
    result = finite(kernel(chain, *rows)).reshape(len(rows[0]), 6, chain.joints)
    return result if batch else result[0]


def manipulability(jacobians: Float64Array) -> Float64Array:
    """Yoshikawa's measure (...) of Jacobians (..., 6, joints)."""
    return np.asarray(_singular_values(jacobians).prod(axis=-1))


def condition_number(jacobians: Float64Array, rotation_weight: float) -> Float64Array:
    """Condition number (...) of Jacobians (..., 6, joints), rotations weighted in m per rad."""
    weights = np.repeat((1.0, rotation_weight), 3)[:, None]
    values = _singular_values(weights * jacobians)
    largest, smallest = values[..., 0], values[..., -1]
    regular = smallest > _SINGULAR * largest
    return np.asarray(
        np.divide(largest, smallest, out=np.full_like(largest, np.inf), where=regular)
    )


def joint_rows(chain: core.Chain, **values: ArrayLike) -> tuple[bool, list[Float64Array]]:
    """Whether the values are batches, and each as checked rows (m, joints)."""
    shapes: Sequence[tuple[int | str, ...]] = ((chain.joints,), ("m", chain.joints))
    rows = []
    for name, value in values.items():
        rows.append(check.array_of_rank(value, name, shapes=shapes))
        shapes = (rows[0].shape,)
    if rows[0].ndim == 2:
        return True, rows
    return False, [row[None] for row in rows]


def finite(result: Float64Array) -> Float64Array:
    """`result`, if it is finite."""
    if not np.isfinite(result).all():
        raise InvalidInput(
            "q, qd or qdd: the values are too large, the result overflows; use rad, rad/s and "
            "rad/s^2 (m for prismatic joints)"
        )
    return result


def _singular_values(jacobians: Float64Array) -> Float64Array:
    return np.asarray(np.linalg.svd(finite(jacobians), compute_uv=False))

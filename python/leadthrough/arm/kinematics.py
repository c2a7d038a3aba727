"""Poses, Jacobians and measures of dexterity, of one configuration or of many at once."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import _core, check
from leadthrough.arm.definition import ArmDefinition
from leadthrough.arm.joint_rows import finite, joint_rows
from leadthrough.check import Float64Array

# A singular value below this fraction of the largest one is rounding.
_SINGULAR = 6 * np.finfo(np.float64).eps
# m per rad: about the reach of an arm's wrist.
ROTATION_WEIGHT = 0.3


class ArmKinematics(ArmDefinition):
    """The methods of an `Arm` that tell where its tip is and how it moves."""

    def forward_kinematics(self, q: ArrayLike) -> tuple[Float64Array, Float64Array]:
        """Position in m and orientation w, x, y, z of the tip in the base frame.

        Args:
            q: configuration (joints,) or a batch (m, joints); may lie outside the limits.

        Returns:
            Position (3,) and orientation (4,), or (m, 3) and (m, 4) for a batch.

        Raises:
            InvalidInput: if q has another shape or is not finite.
        """
        pose = self._chain.pose(q)  # the usual case, without the cost of checks
        if pose is not None:
            return pose
        batch, (rows,) = joint_rows(self._chain, q=q)
        positions, orientations = self._chain.forward_kinematics(rows)
        return (positions, orientations) if batch else (positions[0], orientations[0])

    def jacobian(self, q: ArrayLike) -> Float64Array:
        """Geometric Jacobian J of the tip: linear rows first, in the base frame.

        Args:
            q: configuration (joints,) or a batch (m, joints).

        Returns:
            (6, joints), or (m, 6, joints) for a batch.

        Raises:
            InvalidInput: if q has another shape, is not finite or so large that J overflows.
        """
        return jacobian(self._chain, q)

    def jacobian_derivative(self, q: ArrayLike, qd: ArrayLike) -> Float64Array:
        """Time derivative J' of the Jacobian while the joints move; qdd below is acceleration.

        The tip's acceleration is J qdd + J' qd.

        Args:
            q: configuration (joints,) or a batch (m, joints).
            qd: joint velocities, shape of q, rad/s (m/s).

        Returns:
            (6, joints), or (m, 6, joints) for a batch.

        Raises:
            InvalidInput: if the shapes differ, or a number is not finite or too large.
        """
        return _matrices(_core.jacobian_derivative, self._chain, q=q, qd=qd)

    def jacobian_second_derivative(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike
    ) -> Float64Array:
        """Second time derivative J'' of the Jacobian while the joints move.

        The tip's jerk is J qddd + 2 J' qdd + J'' qd.

        Args:
            q: configuration (joints,) or a batch (m, joints).
            qd: joint velocities, shape of q, rad/s (m/s).
            qdd: joint accelerations, shape of q, rad/s^2 (m/s^2).

        Returns:
            (6, joints), or (m, 6, joints) for a batch.

        Raises:
            InvalidInput: if the shapes differ, or a number is not finite or too large.
        """
        return _matrices(_core.jacobian_second_derivative, self._chain, q=q, qd=qd, qdd=qdd)

    def manipulability(self, q: ArrayLike) -> Float64Array:
        """Yoshikawa's measure sqrt(det(J J^T)), the product of J's singular values.

        It is 0 at a singularity. Its unit is a product of m and rad, so it doesn't compare
        different arms. For an arm of fewer than six joints it is sqrt(det(J^T J)), which measures
        the directions in which the arm can move.

        Args:
            q: configuration (joints,) or a batch (m, joints).

        Returns:
            (), or (m,) for a batch.

        Raises:
            InvalidInput: if q has another shape, is not finite or too large.

        Source: Yoshikawa 1985.
        """
        return np.asarray(_singular_values(self.jacobian(q)).prod(axis=-1))

    def condition_number(
        self, q: ArrayLike, *, rotation_weight: float = ROTATION_WEIGHT
    ) -> Float64Array:
        """Largest singular value of the Jacobian over its smallest; infinite at a singularity.

        Args:
            q: configuration (joints,) or a batch (m, joints).
            rotation_weight: weight of the rotation rows in m per rad, > 0. The Jacobian mixes m
                and rad, so without a weight the number would change with the unit of length. A
                rotation counts as the path of a point this far from the tip: 0.3 is about the
                reach of an arm's wrist, 1.0 gives the plain SI number.

        Returns:
            (), or (m,) for a batch.

        Raises:
            InvalidInput: if q has another shape, is not finite or too large, or the weight is not
                positive.
        """
        weight = check.number(rotation_weight, "rotation_weight", above=0.0)
        return condition_number(self.jacobian(q), weight)


def condition_number(jacobians: Float64Array, rotation_weight: float) -> Float64Array:
    """Condition number (...) of Jacobians (..., 6, joints), rotations weighted in m per rad."""
    weights = np.repeat((1.0, rotation_weight), 3)[:, None]
    values = _singular_values(weights * jacobians)
    largest, smallest = values[..., 0], values[..., -1]
    regular = smallest > _SINGULAR * largest
    return np.asarray(
        np.divide(largest, smallest, out=np.full_like(largest, np.inf), where=regular)
    )


def jacobian(chain: _core.Chain, q: ArrayLike) -> Float64Array:
    """See `Arm.jacobian`."""
    matrix = _core.jacobian_of_one(chain, q)
    if matrix is not None:
        return matrix
    return _matrices(_core.jacobian, chain, q=q)


def _singular_values(matrices: Float64Array) -> Float64Array:
    return np.asarray(np.linalg.svd(finite(matrices), compute_uv=False))


def _matrices(
    kernel: Callable[..., Float64Array], chain: _core.Chain, **values: ArrayLike
) -> Float64Array:
    batch, rows = joint_rows(chain, **values)
    matrices = finite(kernel(chain, *rows)).reshape(len(rows[0]), 6, chain.joints)
    return matrices if batch else matrices[0]

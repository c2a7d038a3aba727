"""The C2 spline on the rotations: pieces that are cubic in the rotation vector.

On piece i the rotation is exp(phi(t)) q_i with a cubic phi from 0 to the turn to q_(i+1). With
angular velocities w at the samples, phi starts with w_i and ends with J^-1 w_(i+1); the angular
acceleration J phi'' + dJ/dt phi' agrees at the inner samples if w solves a system that is
tridiagonal apart from the small term dJ/dt phi', which is iterated.

Source: Park and Ravani 1997; Sola et al. 2018, eq. 145 for J.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from leadthrough import check, rotations
from leadthrough.check import Float64Array
from leadthrough.errors import FitError, InvalidInput
from leadthrough.trajectories.rotation_curve import RotationCurve, checked_samples
from leadthrough.trajectories.rotation_rates import Turning, drift, products, turning_of

_AT_REST = (0.0, 0.0, 0.0)
_MOST_ROUNDS = 200
# Angular accelerations agree to this, relative to the largest velocity over the shortest step.
_SETTLED = 1e-13


@dataclass(frozen=True, eq=False, init=False)
class RotationSpline(RotationCurve):
    """The curve through quaternions with continuous angular velocity and acceleration.

    Attributes:
        times: strictly increasing, s, (n,).
        quaternions: unit quaternions (n, 4), neighbours less than half a turn apart; made
            continuous in sign.
        start_velocity: rad/s in the base frame, (3,); at rest by default.
        end_velocity: rad/s in the base frame, (3,); at rest by default.
        velocities: rad/s in the base frame at all times, (n, 3).

    Raises:
        InvalidInput: if an argument is malformed, or neighbours are half a turn apart.
        FitError: if the turns are too large or uneven.
    """

    times: Float64Array
    quaternions: Float64Array
    start_velocity: Float64Array
    end_velocity: Float64Array
    velocities: Float64Array = field(init=False)
    _cubics: Float64Array = field(init=False, repr=False)

    def __init__(
        self,
        times: ArrayLike,
        quaternions: ArrayLike,
        start_velocity: ArrayLike = _AT_REST,
        end_velocity: ArrayLike = _AT_REST,
    ) -> None:
        t, q = checked_samples(times, quaternions)
        turns = rotations.log(rotations.compose(q[1:], rotations.inverse(q[:-1])))
        if (np.linalg.norm(turns, axis=1) >= np.pi - 1e-6).any():
            raise InvalidInput("quaternions: expected neighbours less than half a turn apart")
        start = check.frozen(start_velocity, "start_velocity", shape=(3,))
        end = check.frozen(end_velocity, "end_velocity", shape=(3,))
        velocities = _velocities(np.diff(t), turns, start, end)
        velocities.setflags(write=False)
        vars(self).update(
            times=t,
            quaternions=q,
            start_velocity=start,
            end_velocity=end,
            velocities=velocities,
            _cubics=_cubics(np.diff(t), turns, velocities),
        )

    @property
    def knots(self) -> Float64Array:
        """The times."""
        return self.times

    def _rotations(self, t: Float64Array) -> Float64Array:
        i, (phi, _, _) = self._vectors(t)
        return rotations.compose(rotations.exp(phi), self.quaternions[i])

    def _turning(self, t: Float64Array) -> Turning:
        i, vectors = self._vectors(t)
        return Turning.still(self.quaternions[i]).then(turning_of(*vectors))

    def _vectors(
        self, t: Float64Array
    ) -> tuple[NDArray[np.intp], tuple[Float64Array, Float64Array, Float64Array]]:
        """The piece of each time, and phi with two derivatives there."""
        i = np.clip(np.searchsorted(self.times, t, side="right") - 1, 0, len(self.times) - 2)
        s = (t - self.times[i])[:, None]
        a, b, c = (self._cubics[i, k] for k in range(3))
        return i, (
            s * (a + s * (b + s * c)),
            a + s * (2.0 * b + 3.0 * s * c),
            2.0 * b + 6.0 * s * c,
        )


def _cubics(steps: Float64Array, turns: Float64Array, velocities: Float64Array) -> Float64Array:
    """(pieces, 3, 3) coefficients of t, t^2 and t^3."""
    h = steps[:, None]
    start = velocities[:-1]
    end = products(rotations.left_jacobian_inverse(turns), velocities[1:])
    return np.stack(
        [
            start,
            (3.0 * turns / h - 2.0 * start - end) / h,
            (start + end - 2.0 * turns / h) / h**2,
        ],
        axis=1,
    )


def _velocities(
    steps: Float64Array, turns: Float64Array, first: Float64Array, last: Float64Array
) -> Float64Array:
    """Angular velocities (n, 3) at the samples, the given ones at the ends."""
    from scipy.linalg import solve_banded

    velocities = np.vstack([first, np.zeros((len(steps) - 1, 3)), last])
    if len(steps) == 1:
        return velocities
    matrix = _matrix(steps, turns)
    scale = np.abs(turns).max() / steps.min() + np.abs(velocities).max() + 1e-300
    for _ in range(_MOST_ROUNDS):
        with np.errstate(all="ignore"):
            found = solve_banded((5, 5), matrix, _right_side(steps, turns, velocities).ravel())
        if not np.isfinite(found).all():
            break
        change = np.abs(found.reshape(-1, 3) - velocities[1:-1]).max()
        velocities[1:-1] = found.reshape(-1, 3)
        if change <= _SETTLED * scale:
            return velocities
    raise FitError("times: the turns are too large or uneven for a spline of rotations")


def _matrix(steps: Float64Array, turns: Float64Array) -> Float64Array:
    """Banded matrix of the inner velocities, without the drift."""
    inner = len(steps) - 1
    rows = np.zeros((inner, 3, inner, 3))
    leaving = 2.0 * rotations.left_jacobian(turns) / steps[:, None, None]
    arriving = 2.0 * rotations.left_jacobian_inverse(turns) / steps[:, None, None]
    for k in range(inner):
        rows[k, :, k] = 4.0 * (1.0 / steps[k] + 1.0 / steps[k + 1]) * np.eye(3)
        if k > 0:
            rows[k, :, k - 1] = leaving[k]
        if k + 1 < inner:
            rows[k, :, k + 1] = arriving[k + 1]
    square = rows.reshape(3 * inner, 3 * inner)
    banded = np.zeros((11, 3 * inner))
    for offset in range(-5, 6):
        diagonal = np.diagonal(square, offset)
        columns = slice(max(offset, 0), max(offset, 0) + len(diagonal))
        banded[5 - offset, columns] = diagonal
    return banded


def _right_side(steps: Float64Array, turns: Float64Array, velocities: Float64Array) -> Float64Array:
    h = steps[:, None]
    right = 6.0 * (turns[1:] / h[1:] ** 2 + turns[:-1] / h[:-1] ** 2)
    arriving = products(rotations.left_jacobian_inverse(turns), velocities[1:])
    right -= drift(turns[:-1], arriving[:-1])
    leaving = products(rotations.left_jacobian(turns), velocities[:-1])
    right[0] -= 2.0 * leaving[0] / steps[0]
    right[-1] -= 2.0 * arriving[-1] / steps[-1]
    return np.asarray(right)

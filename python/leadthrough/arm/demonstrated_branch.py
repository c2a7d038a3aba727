"""Joints along a path that keep the branch of demonstrated ones, through singularities.

Beside a singularity the exact path asks for large motions of the joints. Here the whole path is
one least-squares problem: the tip's errors, and the rates at which the joints leave the
demonstrated ones. Away from singularities the first vanish; beside them the tip leaves the path a
little. Levenberg-Marquardt steps solve it; their matrices are block tridiagonal.

Sources: Wampler 1986 and Nakamura and Hanafusa 1986 for the damping, which is of rates here;
Marquardt 1963.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

import leadthrough._core as core
from leadthrough import rotations
from leadthrough.arm.tip_path import TipPath, Track
from leadthrough.blas_threads import one_blas_thread
from leadthrough.check import Float64Array
from leadthrough.noise import without_noise

# m per rad: through a singularity of the wrist the tip turns, and hardly moves, off its path.
_PER_RADIAN = 0.1
# A joint that leaves the demonstrated rates by 1 rad/s (m/s) costs as much as 3 mrad of the tip to
# begin with, which converges from far away, and a tenth of that in the end, unless the joints leap
# then; m^2 s^2/rad^2.
_RATE_COSTS = (1e-7, 1e-8, 1e-9)
_ITERATIONS = 30
_CONVERGED = 1e-7  # rad or m of a step
_LEAST_DAMPING, _MOST_DAMPING, _DAMPING_STEP = 1e-12, 1e3, 10.0
_HELD = 1e9  # damping of a joint at its limit


def track_on_branch(
    chain: core.Chain, path: TipPath, allowed: tuple[float, float], max_step: float
) -> Track:
    """The track near a path's postures, all samples, with errors as small as these allow."""
    path = replace(path, postures=without_noise(path.postures))
    q = closer = np.ascontiguousarray(np.clip(path.postures, chain.lower, chain.upper))
    for cost in _RATE_COSTS:
        closer = _Branch(chain, path, cost).solve(closer)
        if np.abs(np.diff(closer, axis=0)).max(initial=0.0) > max_step:
            break
        q = closer
    errors = _errors(chain, path, q)
    far = np.linalg.norm(errors[:, :3], axis=1)
    angles = np.linalg.norm(errors[:, 3:], axis=1) / _PER_RADIAN
    missed = (far > allowed[0]) | (angles > allowed[1])
    return Track(q, far, angles, int(np.argmax(missed)) if missed.any() else len(q))


def _errors(chain: core.Chain, path: TipPath, q: Float64Array) -> Float64Array:
    """Errors (n, 6) of the tip, m, rotations weighted."""
    positions, orientations = chain.forward_kinematics(q)
    turns = rotations.compose(path.orientations, rotations.inverse(orientations))
    return np.hstack([path.positions - positions, _PER_RADIAN * rotations.log(turns)])


@dataclass(frozen=True, eq=False)
class _Branch:
    """The least-squares problem of a path."""

    chain: core.Chain
    path: TipPath
    rate_cost: float  # m^2 s^2

    @cached_property
    def _weights(self) -> Float64Array:
        """Of the samples' errors (n,), s."""
        return np.abs(np.gradient(self.path.times))

    @cached_property
    def _stiffness(self) -> Float64Array:
        """Of the steps from sample to sample (n - 1,)."""
        return self.rate_cost / np.diff(self.path.times)

    def solve(self, q: Float64Array) -> Float64Array:
        """The configurations (n, joints) of least cost that are reached from q."""
        damping, cost = _LEAST_DAMPING, self._cost(q)
        for _ in range(_ITERATIONS):
            step_of = self._steps(q)
            while damping < _MOST_DAMPING:
                moved = np.clip(q + step_of(damping), self.chain.lower, self.chain.upper)
                its_cost = self._cost(moved)
                if its_cost <= cost:
                    break
                damping *= _DAMPING_STEP
            else:
                return q
            converged = np.abs(moved - q).max() < _CONVERGED
            q, cost, damping = moved, its_cost, max(damping / _DAMPING_STEP, _LEAST_DAMPING)
            if converged:
                break
        return q

    def _cost(self, q: Float64Array) -> float:
        steps = np.diff(q - self.path.postures, axis=0)
        errors = _errors(self.chain, self.path, q)
        return float(
            np.sum(self._weights[:, None] * errors**2) + np.sum(self._stiffness[:, None] * steps**2)
        )

    def _steps(self, q: Float64Array) -> Callable[[float], Float64Array]:
        """Maps a damping to a step (n, joints); joints at a limit that it would push stay."""
        samples, joints = q.shape
        jacobians = core.jacobian(self.chain, q).reshape(samples, 6, joints).copy()
        jacobians[:, 3:] *= _PER_RADIAN
        weighted = self._weights[:, None, None] * jacobians
        blocks = np.einsum("nij,nik->njk", weighted, jacobians)
        pull = np.einsum("nij,ni->nj", weighted, _errors(self.chain, self.path, q))
        tension = self._stiffness[:, None] * np.diff(q - self.path.postures, axis=0)
        pull[:-1] += tension
        pull[1:] -= tension
        held = (q <= self.chain.lower) & (pull < 0.0) | (q >= self.chain.upper) & (pull > 0.0)
        diagonal = np.zeros(samples)
        diagonal[:-1] += self._stiffness
        diagonal[1:] += self._stiffness
        bands = np.zeros((2 * joints, samples * joints))  # lower ones, by their distance
        for i in range(joints):
            for j in range(i + 1):
                bands[i - j, j::joints] = blocks[:, i, j]
            bands[0, i::joints] += diagonal + _HELD * held[:, i]
            bands[joints, i : (samples - 1) * joints : joints] = -self._stiffness
        right = np.where(held, 0.0, pull).ravel()
        return lambda damping: _solved(bands, right, damping).reshape(samples, joints)


@one_blas_thread
def _solved(bands: Float64Array, right: Float64Array, damping: float) -> Float64Array:
    """Solution of a damped symmetric positive definite system of these lower bands."""
    from scipy.linalg import solveh_banded

    damped = bands.copy()
    damped[0] += damping
    return np.asarray(solveh_banded(damped, right, lower=True, overwrite_ab=True))

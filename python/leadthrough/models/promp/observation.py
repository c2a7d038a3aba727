"""What an observation says about the weights of a ProMP."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from leadthrough import _core, check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.models.promp.gaussian import Gaussian

if TYPE_CHECKING:
    from leadthrough.models.promp.skill import ProMPSkill, Task

# Standard deviations, in shares of the scale, of which a Cholesky root loses nothing that matters.
_SURELY_UNCERTAIN = 1e-5
_MOST_STEPS = 50
# A task's value counts as reached within this share of the length of the value's change.
_REACHED = 1e-9


def of_columns(
    weights: Gaussian,
    rows: Float64Array,
    columns: NDArray[np.int64],
    values: Float64Array,
    noise: Float64Array | None,
    *,
    scale: Float64Array,
    name: str,
) -> Gaussian:
    """The weights given the values (m, p) of p columns where the basis has rows (m, k).

    noise: (p, p) of the values at each, or None: exactly. scale: (p,) what counts as large.
    Raises InvalidInput, about the argument `name`, where the distribution rules the values out.
    """
    certain, mean, covariance = _core.condition_weights(
        weights.mean,
        weights.covariance,
        rows,
        columns,
        values,
        np.zeros((len(columns), len(columns))) if noise is None else noise,
        scale,
        _SURELY_UNCERTAIN,
    )
    if not certain:
        return Gaussian(mean, covariance)
    # Step by step only where something is known already: it takes the directions apart.
    picked = np.eye(len(weights.mean) // rows.shape[1])[columns]
    return weights.observe(
        np.concatenate([np.kron(picked, row) for row in rows]),
        values.ravel(),
        None if noise is None else np.asarray(np.kron(np.eye(len(rows)), noise)),
        scale=np.tile(scale, len(rows)),
        name=name,
    )


def through(
    skill: ProMPSkill,
    rows: Float64Array,
    value: Any,
    task: Task,
    noise: Float64Array | None,
) -> Gaussian:
    """The weights given a task's value at the columns rows @ weights, by Gauss-Newton steps.

    Every step linearises the task at the last mean and starts again from the prior, so that it
    ends at the most likely motion (Bell and Cathey 1993, "The iterated Kalman filter update as a
    Gauss-Newton method").
    """
    wanted = check.array(value, "value", shape=("p",))
    q = rows @ skill.weights.mean
    for _ in range(_MOST_STEPS):
        reached, jacobian = _evaluated(task, q, len(wanted))
        scale = np.linalg.norm(jacobian * skill.scale, axis=1)
        scale = np.maximum(scale, 1e-6 * float(scale.max()))
        if not scale.max() > 0.0:
            raise InvalidInput("task: expected a Jacobian that is not zero")
        linear = wanted - reached + jacobian @ q
        weights = skill.weights.observe(jacobian @ rows, linear, noise, scale=scale, name="value")
        step = rows @ weights.mean - q
        q = q + step
        if np.abs(step / skill.scale).max() < _REACHED:
            return weights
    raise InvalidInput(
        f"value: expected one that the motion can reach, got {wanted}, nearest {reached}"
    )


def log_density(skill: ProMPSkill, phases: Float64Array, values: Float64Array) -> float:
    """Of the values (n, d) of noisy samples at phases (n,), by the matrix inversion lemma."""
    seen = _Seen(skill, phases, values)
    log_noise = len(values) * float(np.log(2.0 * np.pi * skill.noise).sum())
    log_volume = 2.0 * float(np.log(np.diag(seen.lower)).sum())
    squared = float((seen.residual**2 / skill.noise).sum() - seen.white @ seen.white)
    return -0.5 * (squared + log_noise + log_volume)


def along(skill: ProMPSkill, phases: Float64Array, values: Float64Array) -> ProMPSkill:
    """The skill given the values (n, d) of noisy samples at phases (n,)."""
    seen = _Seen(skill, phases, values)
    shrunk = np.linalg.solve(seen.lower, skill.weights.root.T)
    mean = skill.weights.mean + shrunk.T @ seen.white
    return skill.with_weights(Gaussian(mean, shrunk.T @ shrunk))


class _Seen:
    """What noisy samples say about the weights, in coordinates where these are white before."""

    def __init__(self, skill: ProMPSkill, phases: Float64Array, values: Float64Array) -> None:
        size, count = values.shape[1], skill.basis.count
        rows = skill.basis(phases)
        self.residual = values - rows @ skill.weights.mean.reshape(size, count).T
        root = skill.weights.root
        scaled = root.reshape(size, count, -1) / np.sqrt(skill.noise)[:, None, None]
        reached = np.matmul(rows, scaled).reshape(-1, root.shape[1])
        inner = reached.T @ reached
        inner[np.diag_indices(len(inner))] += 1.0
        self.lower = np.linalg.cholesky(inner)
        seen = reached.T @ (self.residual / np.sqrt(skill.noise)).T.ravel()
        self.white = np.linalg.solve(self.lower, seen)


def _evaluated(task: Task, q: Float64Array, size: int) -> tuple[Float64Array, Float64Array]:
    reached, jacobian = task(q)
    return (
        check.array(reached, "task's value", shape=(size,)),
        check.array(jacobian, "task's Jacobian", shape=(size, len(q))),
    )


def noise_of(value: Any, size: int) -> Float64Array:
    """A user's covariance (size, size) of what was observed. Raises InvalidInput."""
    result = check.array(value, "covariance", shape=(size, size))
    if not _core.is_covariance(result):
        raise InvalidInput("covariance: expected a symmetric positive semi-definite matrix")
    return result

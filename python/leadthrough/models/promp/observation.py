"""The weights of a ProMP after observing columns, or noisy samples, of its motion."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from leadthrough import _core, check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.models.chart import Chart
from leadthrough.models.promp.dense import log_determinant, product, solve_definite
from leadthrough.models.promp.gaussian import Gaussian
from leadthrough.motion import Motion, MotionT

if TYPE_CHECKING:
    from leadthrough.models.promp.skill import ProMPSkill

# Standard deviations, as fractions of the scale, of which a Cholesky root loses nothing that
# matters.
_SURELY_UNCERTAIN = 1e-5


def quickly(
    skill: ProMPSkill[MotionT], time: object, position: object, covariance: object
) -> ProMPSkill[MotionT] | None:
    """The skill after noisy via points, as `of_values`, in one call: controllers ask in a loop."""
    basis, weights = skill.basis, skill.free
    if basis.kind == "bspline" or skill.bounds is not None or skill.chart.kind == "poses":
        return None
    found = _core.condition_at(
        weights.mean,
        weights.covariance,
        basis.centres,
        basis.sharpness,
        basis.is_rhythmic,
        skill.scale,
        skill.duration,
        time,
        position,
        covariance,
        _SURELY_UNCERTAIN,
    )
    if found is None:
        return None
    # As `with_weights`, in half the time of the constructor, which sets what is frozen.
    made = object.__new__(type(skill))
    vars(made).update(
        model=skill.model,
        basis=basis,
        chart=skill.chart,
        free=Gaussian(*found),
        noise=skill.noise,
        scale=skill.scale,
        duration=skill.duration,
        bounds=None,
        experience=None,
    )
    return made


def of_values(
    skill: ProMPSkill[MotionT],
    phases: Float64Array,
    values: Float64Array,
    covariance: ArrayLike | None = None,
    *,
    columns: NDArray[np.int64] | None = None,
    order: int = 0,
    name: str,
) -> ProMPSkill[MotionT]:
    """The skill after observing values at one or several phases."""
    chosen = skill.chart.every[: values.shape[1]] if columns is None else columns
    noise = noise_of(covariance, len(chosen))
    rows, scale = skill.basis(phases, order), skill.scale[chosen]
    if order > 0:
        pace = skill.duration**-order
        rows, scale = rows * pace, scale * pace
    return skill.with_weights(
        of_columns(skill.free, rows, chosen, values, noise, scale=scale, name=name)
    )


def chosen(columns: Sequence[int] | None, chart: Chart) -> NDArray[np.int64]:
    """A user's choice of columns."""
    if columns is None:
        return chart.every
    most = chart.width - 1
    result = [check.integer(each, "columns", at_least=0, at_most=most) for each in columns]
    if not result or len(set(result)) != len(result):
        raise InvalidInput(
            f"columns: expected at least one of 0 to {most}, each once, got {list(columns)}"
        )
    return np.array(result)


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
    """The weights after observing some columns at one or several phases."""
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
    # The slower way, which takes the directions apart, only where some are certain already.
    picked = np.eye(len(weights.mean) // rows.shape[1])[columns]
    return weights.observe(
        np.concatenate([np.kron(picked, row) for row in rows]),
        values.ravel(),
        None if noise is None else np.asarray(np.kron(np.eye(len(rows)), noise)),
        scale=np.tile(scale, len(rows)),
        name=name,
    )


def noise_of(covariance: ArrayLike | None, size: int) -> Float64Array | None:
    """A user's covariance (size, size) of an observation, or None for an exact one."""
    if covariance is None:
        return None
    result = check.array(covariance, "covariance", shape=(size, size))
    if not _core.is_covariance(result):
        raise InvalidInput("covariance: expected a symmetric positive semi-definite matrix")
    return result


def check_seen(motion: Motion, name: str) -> None:
    """Checks that an observation is a motion with samples enough to have a duration."""
    samples = len(motion.times) if isinstance(motion, Motion) else 0
    if samples < 2:
        got = "one sample" if samples else type(motion).__name__
        raise InvalidInput(f"{name}: expected a motion of at least two samples, got {got}")


def log_density(skill: ProMPSkill, phases: Float64Array, values: Float64Array) -> float:
    """Log density of noisy samples under a skill."""
    evidence = _Evidence(skill, phases, values)
    log_noise = len(values) * float(np.log(2.0 * np.pi * skill.noise).sum())
    squared = float((evidence.residual**2 / skill.noise).sum()) - evidence.explained
    return -0.5 * (squared + log_noise + log_determinant(evidence.precision, least=1.0))


class _Evidence:
    """Noisy samples, by the matrix inversion lemma in z with weights = mean + root z."""

    def __init__(self, skill: ProMPSkill, phases: Float64Array, values: Float64Array) -> None:
        size, count = values.shape[1], skill.basis.count
        rows = skill.basis(phases)
        self.residual = values - product(rows, skill.weights.mean.reshape(size, count).T)
        root = skill.weights.steady_root
        scaled = root.reshape(size, count, -1) / np.sqrt(skill.noise)[:, None, None]
        reached = np.concatenate([product(rows, each) for each in scaled])
        self.precision = product(reached.T, reached)
        self.precision[np.diag_indices(len(self.precision))] += 1.0
        seen = product(reached.T, (self.residual / np.sqrt(skill.noise)).T.reshape(-1, 1))
        self.explained = float((seen * solve_definite(self.precision, seen)).sum())

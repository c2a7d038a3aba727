"""Weights of a ProMP after observations, and of motions between a new start and a new goal.

Columns, noisy samples or a value in a task space are observed; exact via points too close for the
basis are refused. Motions are moved to new ends by a mixture of two: conditioned near them, as far
as they lie within the demonstrations' spread and no phase moves by much more than they do; the rest
is shifted, by offsets that fade along the path.

Sources: Gomez-Gonzalez et al. 2020, "Adaptation and robust learning of probabilistic movement
primitives", section IV-D, iterated as by Bell and Cathey 1993, "The iterated Kalman filter update
as a Gauss-Newton method"; Zhou, Gao and Asfour 2019, "Learning via-movement primitives with inter-
and extrapolation capabilities", for the shift.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Generic, Self, TypeAlias, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

import leadthrough._core as core
from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.models.coordinates import Coordinates
from leadthrough.models.curves import arc_phases
from leadthrough.models.promp import gaussian
from leadthrough.models.promp.basis import Basis, fades, inner_prior, prior_phases
from leadthrough.models.promp.gaussian import Gaussian, log_determinant, product, solve_definite
from leadthrough.motion import Motion, MotionT_co, Target
from leadthrough.preprocess.moved_ends import MAX_GAIN, fraction_inside

# Standard deviations, in scales, of which a Cholesky root loses nothing that matters.
_SURELY_UNCERTAIN = 1e-5
# Takes the columns (d,) of a motion, returns their value (p,) in the task space and the Jacobian
# (p, d) of that value.
TaskMap: TypeAlias = Callable[[Float64Array], tuple[ArrayLike, ArrayLike]]
_MAX_STEPS = 50
# The iteration ends when no column moves by more than this fraction of its reach.
_REACHED = 1e-9
# A row of the Jacobian counts as at least this fraction of the largest.
_MIN_ROW = 1e-6
# Elsewhere a motion may move this many times as far as its via points do, relative to its reach.
_MAX_GAIN = 5.0
# Via points farther apart than this many spacings of the basis functions are resolved.
_RESOLVED = 2.0
# Fraction of a via point's row, squared, that points fixed before may determine.
_MAX_DETERMINED = 0.5
_PHASES_PER_WEIGHT = 4
_ROUNDING = 1e-6  # fraction of the reach that counts as no move
# Standard deviations up to which ends count as demonstrated.
_MAX_DEVIATIONS = 3.0
# Variance of ends to which motions are moved, of the squared reach and of the ends' own.
_OF_REACH, _OF_SPREAD = 0.01, 0.05
_SAME_END = 1e-9  # fraction of the reach that counts as nothing


@dataclass(frozen=True, eq=False)
class Primitive(Generic[MotionT_co]):
    """Attributes of a ProMP's skill that observations need, documented where they are public."""

    model: Any
    basis: Basis
    coordinates: Coordinates[MotionT_co]
    free: Gaussian
    noise: Float64Array
    scale: Float64Array
    duration: float

    @property
    @abstractmethod
    def weights(self) -> Gaussian:
        """Distribution of the weights (d k,) inside the limits."""

    @abstractmethod
    def with_weights(self, weights: Gaussian) -> Self:
        """The skill with another distribution of the weights."""


PrimitiveT = TypeVar("PrimitiveT", bound=Primitive[Any])


def quickly(
    skill: Primitive, time: object, position: object, covariance: object
) -> Gaussian | None:
    """The weights after noisy via points, in one call for loops; None where `of_values` must do."""
    basis, weights = skill.basis, skill.free
    if basis.kind == "bspline" or skill.coordinates.kind == "poses":
        return None
    observed = core.condition_at(
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
    return None if observed is None else Gaussian(*observed)


def of_values(
    skill: PrimitiveT,
    phases: Float64Array,
    values: Float64Array,
    covariance: ArrayLike | None = None,
    *,
    columns: NDArray[np.int64] | None = None,
    order: int = 0,
    name: str,
) -> PrimitiveT:
    """The skill after observing values at one or several phases."""
    chosen = skill.coordinates.every[: values.shape[1]] if columns is None else columns
    noise = noise_of(covariance, len(chosen))
    rows, scale = skill.basis(phases, order), skill.scale[chosen]
    if order > 0:
        pace = skill.duration**-order
        rows, scale = rows * pace, scale * pace
    return skill.with_weights(
        of_columns(skill.free, rows, chosen, values, noise, scale=scale, name=name)
    )


def chosen(columns: Sequence[int] | None, coordinates: Coordinates) -> NDArray[np.int64]:
    """A user's choice of columns."""
    if columns is None:
        return coordinates.every
    if check.rank(columns) != 1:
        raise check.refused("columns", "a sequence of integers", type(columns).__name__)
    most = coordinates.width - 1
    result = [check.integer(each, "columns", at_least=0, at_most=most) for each in columns]
    if not result or len(set(result)) != len(result):
        raise check.refused("columns", f"at least one of 0 to {most}, each once", list(columns))
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
    certain, mean, covariance = core.condition_weights(
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
    if not core.is_covariance(result):
        raise InvalidInput("covariance: expected a symmetric positive semi-definite matrix")
    return result


def check_seen(motion: Motion, name: str) -> None:
    """Checks that an observation is a motion with samples enough to have a duration."""
    samples = len(motion.times) if isinstance(motion, Motion) else 0
    if samples < 2:
        got = "one sample" if samples else type(motion).__name__
        raise InvalidInput(f"{name}: expected a motion of at least two samples, got {got}")


def log_density(skill: Primitive, phases: Float64Array, values: Float64Array) -> float:
    evidence = _Evidence(skill, phases, values)
    log_noise = len(values) * float(np.log(2.0 * np.pi * skill.noise).sum())
    squared = float((evidence.residual**2 / skill.noise).sum()) - evidence.explained
    return -0.5 * (squared + log_noise + log_determinant(evidence.precision, least=1.0))


class _Evidence:
    """Noisy samples, by the matrix inversion lemma in z with weights = mean + root z."""

    def __init__(self, skill: Primitive, phases: Float64Array, values: Float64Array) -> None:
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


def through(
    skill: Primitive,
    rows: Float64Array,
    value: ArrayLike,
    task: TaskMap,
    noise: Float64Array | None,
) -> Gaussian:
    """The weights after observing a value in a task space, by Gauss-Newton steps."""
    wanted = check.array(value, "value", shape=("p",))
    if len(wanted) == 0:
        raise InvalidInput("value: expected at least one number, got none")
    q = rows @ skill.free.mean
    for _ in range(_MAX_STEPS):
        reached, jacobian = _evaluated(task, q, len(wanted))
        scale = np.linalg.norm(jacobian * skill.scale, axis=1)
        scale = np.maximum(scale, _MIN_ROW * float(scale.max()))
        if not scale.max() > 0.0:
            raise InvalidInput("task: expected a Jacobian that is not zero")
        linear = wanted - reached + jacobian @ q
        weights = skill.free.observe(jacobian @ rows, linear, noise, scale=scale, name="value")
        step = rows @ weights.mean - q
        q = q + step
        if np.abs(step / skill.scale).max() < _REACHED:
            return weights
    raise check.refused(
        "value", "a value that the motion can reach", f"{wanted}; the last step reached {reached}"
    )


def _evaluated(task: TaskMap, q: Float64Array, size: int) -> tuple[Float64Array, Float64Array]:
    reached, jacobian = task(q)
    return (
        check.array(reached, "task's value", shape=(size,)),
        check.array(jacobian, "task's Jacobian", shape=(size, len(q))),
    )


def refuse_too_close(
    before: Primitive,
    after: Primitive,
    phases: Float64Array,
    values: Float64Array,
    columns: NDArray[np.int64],
) -> None:
    """Refuses exact via points that the basis can only pass by throwing the motion elsewhere."""
    size, count = before.coordinates.width, before.basis.count
    curves = before.free.mean.reshape(size, count)
    asked = np.abs(values - before.basis(phases) @ curves[columns].T) / before.scale[columns]
    rows = before.basis(np.linspace(0.0, 1.0, _PHASES_PER_WEIGHT * count + 1))
    change = rows @ (after.free.mean.reshape(size, count) - curves).T / before.scale
    if np.abs(change).max() <= _MAX_GAIN * float(asked.max()) + _ROUNDING:
        return
    spacing = float(np.diff(before.basis.centres).max())  # B-splines stand closer at the ends
    advice = (
        f"the {count} weights resolve times from {_RESOLVED * spacing * before.duration:.3g} s "
        "on; move them apart, let their values lie on a smooth curve, give a covariance, or fit "
        "with more weights"
    )
    times = np.sort(phases) * before.duration
    gaps = np.diff(np.sort(phases))
    if len(gaps) > 0 and gaps.min() < _RESOLVED * spacing:
        first = int(gaps.argmin())
        raise InvalidInput(
            f"time: expected via points that the motion can pass one after the other, got ones at "
            f"{times[first]:.6g} s and {times[first + 1]:.6g} s; {advice}"
        )
    if _is_determined(before, phases, columns):
        raise InvalidInput(
            f"time: expected via points that the motion can pass one after the other, got one at "
            f"{times[0]:.6g} s right beside a point fixed before; {advice}"
        )


def _is_determined(skill: Primitive, phases: Float64Array, columns: NDArray[np.int64]) -> bool:
    """Whether points fixed before, close by, leave a via point little freedom."""
    picked = np.eye(skill.coordinates.width)[columns]
    rows = np.concatenate([np.kron(picked, row) for row in skill.basis(phases)])
    known = ((rows @ skill.free.certain) ** 2).sum(axis=1)
    return bool((known > _MAX_DETERMINED * (rows**2).sum(axis=1)).any())


@dataclass(frozen=True, eq=False)
class Asked:
    name: str  # argument that asks for it
    phase: float  # 0 at the start, 1 at the end
    values: Float64Array  # the first columns (p,) there


def asked(coordinates: Coordinates, start: Target | None, goal: Target | None) -> list[Asked]:
    """The ends that a query asks for, in the columns of the coordinates."""
    return [
        Asked(name, phase, coordinates.target(place, name, phase))
        for name, place, phase in (("start", start, 0.0), ("goal", goal, 1.0))
        if place is not None
    ]


def moved(skill: PrimitiveT, asked: Sequence[Asked]) -> PrimitiveT:
    """The skill whose mean motion has the ends asked for."""
    size = skill.coordinates.width
    offsets = _offsets(skill, asked)
    shift = _shift(skill, asked, offsets)
    variances = [_unforetold(skill, each) for each in asked]
    near = exact = skill
    for each, own in zip(asked, variances, strict=True):
        at, values = np.array([each.phase]), each.values[None]
        near = of_values(near, at, values, np.diag(own), name=each.name)
        exact = of_values(exact, at, values, name=each.name)
    learned = (near.free.mean - skill.free.mean).reshape(size, -1) - shift
    learned += _shift(skill, asked, _offsets(near, asked))
    known = min(1.0, _MAX_DEVIATIONS / max(novelty(skill, asked, variances), _MAX_DEVIATIONS))
    rows = skill.basis(np.linspace(0.0, 1.0, _PHASES_PER_WEIGHT * skill.basis.count + 1))
    position = slice(0, skill.coordinates.size)  # of poses, the rotation has a unit of its own
    for group in (position, slice(position.stop, size))[: 1 + (position.stop < size)]:
        limit = MAX_GAIN * _moved_by(skill, asked, offsets, group)
        inside = fraction_inside(rows @ shift[group].T, rows @ learned[group].T, limit)
        shift[group] += min(known, inside) * learned[group]
    mean = skill.free.mean + shift.ravel()
    return skill.with_weights(Gaussian(mean, exact.free.covariance))


def _unforetold(skill: Primitive, asked: Asked) -> Float64Array:
    """Variances (p,) of an end: few demonstrations hardly foretell the rest of a motion by it."""
    count = len(asked.values)
    covariance = skill.free.columns_at(skill.basis(np.array([asked.phase])))[1][0]
    own = float(covariance.diagonal()[:count].mean())
    return np.asarray(_OF_REACH * skill.scale[:count] ** 2 + _OF_SPREAD * own)


def novelty(
    skill: Primitive, asked: Sequence[Asked], variances: Sequence[Float64Array] = ()
) -> float:
    """Distance of ends, with variances (p,) each, from the demonstrated ones, in deviations."""
    offsets = _offsets(skill, asked)
    selection, surprise = [], []
    for each, offset in zip(asked, offsets, strict=True):
        count = len(each.values)
        row = skill.basis(np.array([each.phase]))[0]
        unit = 1.0 / skill.scale[:count]
        selection.append(np.kron(np.eye(skill.coordinates.width)[:count] * unit[:, None], row))
        surprise.append(offset[:count] * unit)
    rows = np.concatenate(selection)
    covariance = rows @ skill.free.covariance @ rows.T
    if variances:
        units = [skill.scale[: len(own)] for own in variances]
        covariance += np.diag(np.concatenate(variances) / np.concatenate(units) ** 2)
    spread, axes = np.linalg.eigh(covariance)
    along = np.abs(axes.T @ np.concatenate(surprise))
    with np.errstate(divide="ignore", invalid="ignore"):
        deviations = along / np.sqrt(np.where(spread > gaussian.CERTAIN**2, spread, 0.0))
    # Fixed and asked to be as it is, up to rounding: nothing new.
    return float(np.where(along < _SAME_END, 0.0, deviations).max())


def _offsets(skill: Primitive, asked: Sequence[Asked]) -> list[Float64Array]:
    """Offset (d,) of each end; 0 in columns that were not asked for."""
    curves = skill.free.mean.reshape(skill.coordinates.width, -1)
    offsets = []
    for each in asked:
        offset = np.zeros(len(curves))
        present = curves @ skill.basis(np.array([each.phase]))[0]
        offset[: len(each.values)] = each.values - present[: len(each.values)]
        offsets.append(offset)
    return offsets


def _shift(
    skill: Primitive, asked: Sequence[Asked], offsets: Sequence[Float64Array]
) -> Float64Array:
    """Weights (d, k) of the shift; where the motion is fixed, at via points, it does not move."""
    # A rhythmic motion ends where it starts: all of it is shifted.
    fading = np.ones((skill.basis.count, 1)) if skill.basis.is_rhythmic else _fades(skill)
    shift = np.zeros((skill.coordinates.width, skill.basis.count))
    for each, offset in zip(asked, offsets, strict=True):
        shift += np.outer(offset, fading[:, int(each.phase)])
    fixed = skill.free.certain
    if fixed.shape[1] > 0:
        smooth = np.kron(np.diag(skill.scale**2), inner_prior(skill.basis)) @ fixed
        wrong = fixed.T @ shift.ravel()
        shift -= (smooth @ np.linalg.pinv(fixed.T @ smooth) @ wrong).reshape(shift.shape)
    return shift


def _fades(skill: Primitive) -> Float64Array:
    """Weights (k, 2) of curves from 1 to 0 and from 0 to 1 along the mean motion's path."""
    curves = skill.free.mean.reshape(skill.coordinates.width, -1) / skill.scale[:, None]
    return fades(skill.basis, arc_phases(skill.basis(prior_phases(skill.basis)) @ curves.T))


def _moved_by(
    skill: Primitive,
    asked: Sequence[Asked],
    offsets: Sequence[Float64Array],
    group: slice,
) -> float:
    """The largest offset of the ends in a group of columns, in its unit."""
    if any(len(each.values) >= group.stop for each in asked):
        return max(float(np.linalg.norm(offset[group])) for offset in offsets)
    position = slice(0, skill.coordinates.size)
    reach = np.linalg.norm(skill.scale[group]) / np.linalg.norm(skill.scale[position])
    return float(reach) * max(float(np.linalg.norm(offset[position])) for offset in offsets)

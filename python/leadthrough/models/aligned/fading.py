"""The curve that aligned demonstrations predict between a new start and a new goal.

Demonstrations are weighted by the nearness of their ends to the new ones. Their mean follows the
offsets of both ends as the demonstrations do: at each phase, regression on their own offsets tells
how much of an offset is left. That is the mean of a Gaussian over curves, conditioned on both ends,
whose prior covariance is a linear fade. The ways of weighting and fading that predict left-out
demonstrations best are averaged.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.models.aligned.curves import (
    Curves,
    arc_phases,
    even_phases,
    interpolated,
    with_ends,
)

# Width of the weights in median distances of the ends.
_WIDTHS = (np.inf, 1.0, 0.4, 0.15)
# Weight of the linear fade against the demonstrations'; infinite: the linear fade alone.
_PRIORS = (0.03, 0.3, 3.0, np.inf)
ROTATED = 1.0 / 3.0
# Between these ratios of a curve's chord to its length, rotation fades in: a motion that returns
# to its start has no direction to rotate from. Farther rotation or scaling says little.
_RETURNING = (0.05, 0.1)
_MIN_COSINE, _SCALES = -0.9, (0.2, 5.0)
_AVERAGED = 10
# An option is preferred as far as it surely predicts better than the first, at this confidence.
_SURE = 0.975
_COMPARED = 100  # even rows, at which a prediction is compared with the left-out curve
_TINY = 1e-300


@dataclass(frozen=True)
class Option:
    """One way of weighting demonstrations and of fading the offsets of their ends."""

    phase: int  # of the curves: 0 by arc length, 1 elastic
    width: float
    prior: float
    rotated: float = 0.0  # fraction that rotates with the chord, of a linear fade

    @staticmethod
    def of_row(row: Sequence[float]) -> Option:
        """The option of a row of an archive."""
        return Option(int(row[0]), *(float(each) for each in row[1:]))


DEFAULT = Option(0, 1.0, np.inf, ROTATED)
TIMING = Option(1, 1.0, np.inf)


def options(*, rotating: bool) -> list[Option]:
    """All options, the default first."""
    linear = [Option(*each) for each in product((0, 1), _WIDTHS, _PRIORS)]
    rotated = [Option(phase, width, np.inf, ROTATED) for phase in (0, 1) for width in _WIDTHS]
    return sorted(rotated, key=lambda each: each != DEFAULT) + linear if rotating else linear


@dataclass(frozen=True, eq=False)
class Predictor:
    """Aligned demonstrations of one way, in scaled columns.

    Attributes:
        phased: by arc length, and elastically.
        size: number of columns of the position; the others have fades of their own.
    """

    phased: tuple[Curves, Curves]
    size: int

    def between(
        self, option: Option, ends: Float64Array, *, without: int | None = None
    ) -> tuple[Float64Array, Float64Array]:
        """Rows (n, width) between ends (2, width) over the phase, and the demonstrations' weights.

        Args:
            option: weights and fade.
            ends: start and goal.
            without: a demonstration to leave out.
        """
        rows = self.phased[option.phase].rows
        weights = _weights(rows[:, [0, -1]], ends, option.width, without)
        if option.rotated:
            rotated = self._rotated(rows, ends, option.rotated)
            return np.asarray(np.tensordot(weights, rotated, 1)), weights
        mean = np.asarray(np.tensordot(weights, rows, 1))
        off, progress = rows - mean, arc_phases(mean)
        groups = [slice(0, self.size), slice(self.size, rows.shape[2])]
        for group in groups if rows.shape[2] > self.size else groups[:1]:
            left = fades(off[:, :, group], weights, option.prior, progress)
            mean[:, group] += left.T @ (ends[:, group] - mean[[0, -1], group])
        return mean, weights

    def _rotated(self, rows: Float64Array, ends: Float64Array, fraction: float) -> Float64Array:
        """Curves with new ends, partly shifted and partly rotated with their chords."""
        result = with_ends(rows, *ends)
        for shifted, each in zip(result, rows, strict=True):
            position = each[:, : self.size]
            own = fraction * _directed(position)
            if own and (turned := _turned(position, *ends[:, : self.size])) is not None:
                shifted[:, : self.size] += own * (turned - shifted[:, : self.size])
        return result

    def chosen(self, *, rotating: bool) -> list[Option]:
        """The options to average: those that surely predict left-out demonstrations best."""
        every, count = options(rotating=rotating), len(self.phased[0].rows)
        if count < 3:
            return every[:1]
        from scipy.stats import t

        few = Predictor(
            (self.phased[0].coarse(_COMPARED), self.phased[1].coarse(_COMPARED)), self.size
        )
        missed = np.array([[few._missed(each, i) for i in range(count)] for each in every])
        gain = np.log(missed + _TINY) - np.log(missed[0] + _TINY)
        error = gain.std(axis=1, ddof=1) / np.sqrt(count)
        order = np.argsort(gain.mean(axis=1) + t.ppf(_SURE, count - 1) * error, kind="stable")
        return [every[i] for i in order[:_AVERAGED]]

    def _missed(self, option: Option, index: int) -> float:
        """The mean distance of a left-out demonstration from its prediction."""
        rows = self.phased[0].rows[index]
        found, _ = self.between(option, rows[[0, -1]], without=index)
        return float(np.linalg.norm(_evened(found) - rows, axis=1).mean())

    def predicted(
        self, chosen: Sequence[Option], ends: Float64Array
    ) -> tuple[Float64Array, Float64Array, Float64Array]:
        """The mean rows (n, width) of options between ends (2, width), evenly spaced.

        With the phases (n,) of the elastic curves there, and the times (n,).
        """
        rows = np.mean([_evened(self.between(each, ends)[0]) for each in chosen], axis=0)
        rows[[0, -1]] = ends
        timed, weights = self.between(TIMING, ends)
        even = even_phases(len(rows))
        phases = np.interp(even, arc_phases(timed), even)
        clock = np.interp(phases, even, weights @ self.phased[TIMING.phase].times)
        return rows, phases, np.maximum.accumulate(clock)


def _evened(rows: Float64Array) -> Float64Array:
    """Rows (n, width) at even steps of their length."""
    return interpolated(even_phases(len(rows)), arc_phases(rows), rows)


def _weights(
    demonstrated: Float64Array, ends: Float64Array, width: float, without: int | None
) -> Float64Array:
    """Weights (k,) of demonstrations by the nearness of their ends (k, 2, width); sum 1."""
    kept = np.ones(len(demonstrated))
    if without is not None:
        kept[without] = 0.0
    if np.isfinite(width):
        squared = ((demonstrated - ends) ** 2).sum(axis=(1, 2))
        nearest_first = np.sort(squared[kept > 0.0])
        wide = 2.0 * width**2 * float(nearest_first[len(nearest_first) // 2]) + _TINY
        kept *= np.exp(-(squared - nearest_first[0]).clip(0.0) / wide)
    return np.asarray(kept / kept.sum())


def fades(
    off: Float64Array, weights: Float64Array, prior: float, progress: Float64Array
) -> Float64Array:
    """The fraction (2, n) of the offsets of start and goal that is left at each phase.

    Args:
        off: demonstrations (k, n, d) relative to their mean.
        weights: weights (k,), sum 1.
        prior: weight of the linear fade; infinite for that alone.
        progress: fraction (n,) of the mean's length.
    """
    linear = np.stack([1.0 - progress, progress])
    if not np.isfinite(prior):
        return linear
    ends = off[:, [0, -1]]
    gram = np.einsum("k,kid,kjd->ij", weights, ends, ends)
    pull = prior * (np.trace(gram) / off.shape[2] + _TINY)
    seen = np.einsum("k,knd,kid->in", weights, off, ends)
    left = np.linalg.solve(gram + pull * np.eye(2), seen + pull * linear)
    left[:, [0, -1]] = np.eye(2)
    return np.asarray(left)


def _directed(rows: Float64Array) -> float:
    """0 for a curve that returns to its start, 1 for one that leads somewhere."""
    length = float(np.linalg.norm(np.diff(rows, axis=0), axis=1).sum())
    ratio = float(np.linalg.norm(rows[-1] - rows[0])) / (length or 1.0)
    return min(max((ratio - _RETURNING[0]) / (_RETURNING[1] - _RETURNING[0]), 0.0), 1.0)


def _turned(rows: Float64Array, start: Float64Array, goal: Float64Array) -> Float64Array | None:
    """The curve rotated about the goal and scaled so that it begins at the start, or None."""
    own, wanted = rows[0] - rows[-1], start - goal
    before, after = float(np.linalg.norm(own)), float(np.linalg.norm(wanted))
    if not _SCALES[0] * before < after < _SCALES[1] * before:
        return None
    a, b = own / before, wanted / after
    if float(a @ b) < _MIN_COSINE:
        return None
    points, between = rows - rows[-1], a + b
    rotated = (
        points
        - np.outer(points @ between, between) / (1.0 + float(a @ b))
        + 2.0 * np.outer(points @ a, b)
    )
    return np.asarray(goal + after / before * rotated)

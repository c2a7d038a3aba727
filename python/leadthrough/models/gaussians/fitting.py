"""Gaussian mixtures fitted to points, with a given or a chosen number of components.

Columns are scaled to variance one first, so that their units do not matter.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import FitError, Float64Array, ShortRepr
from leadthrough.models.gaussians.kmeans import clustered, seeds
from leadthrough.models.gaussians.mixture import Blocks, Mixture, Steps, fit_blocks

FitT = TypeVar("FitT")
# The search for a number of components ends after this many numbers without improvement.
_PATIENCE = 3
_ROTATION_UNIT = 1.0  # rad
_POSITION, _ROTATION = slice(1, 4), slice(4, 7)  # columns after the time


@dataclass(frozen=True, eq=False)
class FittedMixture(ShortRepr):
    """A mixture fitted by EM.

    Attributes:
        mixture: the mixture that EM ended at.
        history: mean log-likelihood per point at every iteration.
    """

    mixture: Mixture
    history: tuple[float, ...]

    @property
    def log_likelihood(self) -> float:
        """Mean log-likelihood per point of the mixture."""
        return self.history[-1]


def fit_mixture(
    points: ArrayLike, components: int, *, seed: int = 0, starts: int = 5
) -> FittedMixture:
    """The most likely mixture with a given number of components, whatever the points' order.

    EM ends at the nearest maximum of the likelihood; the best of several starts is returned.
    Components are in the order of their means' first
    column, which for motions is the time.

    Args:
        points: points (n, d).
        components: number of components, 1 to n.
        seed: seed of the random number generator that draws the starts.
        starts: number of starts that are followed to the end, the most promising of four times as
            many; 1 for a single one from k-means, which is several times faster.

    Raises:
        FitError: if there are fewer points than components.
    """
    data, count = _checked(points, components, seed)
    check.integer(starts, "starts", at_least=1)
    units = own_units(data)
    scaled = units.scaled(data)
    blocks, history = fit_blocks([scaled], scaled, count, seed=seed, starts=starts)
    return FittedMixture(
        _unscaled(blocks, units), tuple(value - units.log_volume for value in history)
    )


def choose_components(
    points: ArrayLike, *, at_most: int = 15, seed: int = 0, starts: int = 5
) -> FittedMixture:
    """The mixture with the number of components of least Bayesian information criterion.

    Numbers are tried from 1 on; the search ends where three in a row have not lowered the
    criterion.

    Args:
        points: points (n, d).
        at_most: largest number of components to try, >= 1.
        seed: seed of the random number generator that draws the starts.
        starts: number of starts for each number of components, as in `fit_mixture`.

    Source: Schwarz 1978, "Estimating the dimension of a model".
    """
    data = check.array(points, "points", shape=("n", "d"))
    most = min(check.integer(at_most, "at_most", at_least=1), len(data))
    return least_criterion(
        lambda count: fit_mixture(data, count, seed=seed, starts=starts),
        lambda fit: bic(fit, len(data)),
        most,
    )


def least_criterion(
    fitted: Callable[[int], FitT], criterion: Callable[[FitT], float], most: int
) -> FitT:
    """The fit of least criterion, of those with 1, 2, ... components."""
    best, least = 1, np.inf
    fits = {}
    for count in range(1, most + 1):
        fits[count] = fitted(count)
        value = criterion(fits[count])
        if value < least:
            best, least = count, value
        if count - best == _PATIENCE:
            break
    return fits[best]


def trace_mixture(
    points: ArrayLike, components: int | Mixture, *, iterations: int, seed: int = 0
) -> list[Mixture]:
    """The mixtures after 0, 1, ... iterations of EM from one start, to draw or measure EM at work.

    Args:
        points: points (n, d).
        components: number of components, 1 to n, started by k-means; or a mixture to start from.
        iterations: number of iterations, >= 0.
        seed: seed of the random number generator that starts k-means.

    Returns:
        Mixtures, one more than iterations.

    Raises:
        FitError: if there are fewer points than components.
    """
    given = components if isinstance(components, Mixture) else None
    count = components.count if isinstance(components, Mixture) else components
    data, count = _checked(points, count, seed)
    rounds = check.integer(iterations, "iterations", at_least=0)
    units = own_units(data)
    scaled = units.scaled(data)
    steps = Steps([scaled])
    if given is None:
        labels = clustered(scaled, seeds(scaled, count, np.random.default_rng(seed))).labels
        traced = [steps.maximise(np.eye(count)[labels])]
    else:
        check.array(data, "points", shape=("n", given.size))
        traced = [_scaled(given, units)]
    for _ in range(rounds):
        traced.append(steps.maximise(steps.expect(traced[-1])[0]))
    return [_unscaled(each, units) for each in traced]


def bic(fit: FittedMixture, samples: int) -> float:
    """The Bayesian information criterion of a fitted mixture; less is better."""
    k, d = fit.mixture.count, fit.mixture.size
    free = k - 1 + k * d + k * d * (d + 1) // 2
    return free * float(np.log(samples)) - 2.0 * samples * fit.log_likelihood


def in_order(components: Blocks) -> Mixture:
    """The mixture of components of one block, ordered by their means' first column."""
    order = np.argsort(components.means[0][:, 0], kind="stable")
    return Mixture(
        components.weights[order], components.means[0][order], components.covariances[0][order]
    )


def _checked(points: ArrayLike, components: int, seed: int) -> tuple[Float64Array, int]:
    data = check.array(points, "points", shape=("n", "d"))
    count = check.integer(components, "components", at_least=1)
    check.integer(seed, "seed", at_least=0)
    if count > len(data):
        raise FitError(f"components: expected at most one per point, {len(data)}, got {count}")
    return data, count


def _scaled(mixture: Mixture, units: Units) -> Blocks:
    """The components of a mixture as one block of columns in units."""
    covariances = units.scaled_covariances(mixture.covariances)
    return Blocks(mixture.weights, (units.scaled(mixture.means),), (covariances,))


def _unscaled(blocks: Blocks, units: Units) -> Mixture:
    """The components of one block in their columns' own units, in order."""
    means, covariances = units.means(blocks.means[0]), units.covariances(blocks.covariances[0])
    return in_order(Blocks(blocks.weights, (means,), (covariances,)))


@dataclass(frozen=True, eq=False)
class Units:
    """Offsets and divisors of columns, on which EM's starts and least variance depend."""

    middle: Float64Array  # means (d,) of the columns
    scale: Float64Array  # units (d,) of the columns

    @property
    def log_volume(self) -> float:
        """Excess of log densities in these units over those in the columns' own units."""
        return float(np.log(self.scale).sum())

    def scaled(self, points: Float64Array) -> Float64Array:
        """Points (n, d) in these units."""
        return (points - self.middle) / self.scale

    def scaled_covariances(self, covariances: Float64Array) -> Float64Array:
        """Covariances (k, d, d) in these units."""
        return covariances / self.scale / self.scale[:, None]

    def means(self, scaled: Float64Array) -> Float64Array:
        """Means (k, d) in the columns' own units."""
        return scaled * self.scale + self.middle

    def covariances(self, scaled: Float64Array) -> Float64Array:
        """Covariances (k, d, d) in the columns' own units."""
        return scaled * self.scale * self.scale[:, None]


def own_units(points: Float64Array) -> Units:
    """Means and standard deviations of columns; deviation 1 where all values are the same."""
    middle, deviations = points.mean(axis=0), points.std(axis=0)
    rounding = 1e-12 * np.abs(middle)
    return Units(middle, np.where(deviations > rounding, deviations, 1.0))


def phase_units(own: Units, count: int, *, poses: bool) -> Units:
    """Units of the time and the columns of motions, for components that follow phases."""
    scale = own.scale.copy()
    scale[0] /= count
    if poses:
        scale[_POSITION] = scale[_POSITION].max()
        scale[_ROTATION] = _ROTATION_UNIT
    return Units(own.middle, scale)

"""LPV-DS: a mixture of linear systems with a learned quadratic energy.

x' = sum_k h_k(x) A_k x with the posteriors h_k of a mixture of positions and P A_k + A_k^T P < 0:
the energy x^T P x falls everywhere. In turn, the mixture is fitted so that a component holds
positions near each other with velocities in one direction, P is learned so that the energy falls
along the demonstrations, and the A_k are the least squares of a semidefinite programme.

Source: Figueroa and Billard 2018, "A physically-consistent Bayesian non-parametric mixture model
for dynamical system learning", CoRL, 927-946. Its mixture is drawn by Gibbs sampling from a
distance-dependent process; ours is the most likely one, by EM, of positions and directions of
motion that are independent of each other within a component. The number of components is chosen by
the paths of left-out demonstrations: the likelihood of positions says little of the motions, and
its criteria take too few. P is learned as the quadratic part of CLF-DM's energy.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from leadthrough import check
from leadthrough.check import FitError, Float64Array, NoPath
from leadthrough.models.dynamical.field import goal_trajectory
from leadthrough.models.dynamical.linear_mixture import (
    GaussianGates,
    LinearMixture,
    stable_matrices,
)
from leadthrough.models.dynamical.lyapunov import fitted_quadratics
from leadthrough.models.dynamical.model import DynamicalModel, Samples
from leadthrough.models.gaussians.mixture import Blocks, fit_blocks
from leadthrough.preprocess import dtw_distance
from leadthrough.preprocess.resample import by_arc_length

_DECAY, _RIDGE = 0.1, 1e-6
# The least deviation of a component, of positions and of directions.
_MIN_VARIANCE = 0.02**2
# Numbers of components that cross-validation compares, and the most demonstrations it leaves out.
_COUNTS = (1, 2, 3, 4, 6, 8, 11, 15, 20)
_MAX_FOLDS = 6
# Fraction by which the error of fewer components may be larger: with many, systems can be slow far
# away from the demonstrations.
_AS_GOOD = 0.1
# Evenly spaced samples of a reproduced path, by which it is compared.
_COMPARED = 100


@dataclass(frozen=True)
class LPVDS(DynamicalModel):
    """Linear systems mixed by position, for points, joints or poses; needs the extra `stable`.

    Attributes:
        components: number of components, 1 to 50; None for the fewest up to 20 with which
            demonstrations that are left out in turn are reproduced within 10 % of the least error;
            of a single one, every second of its samples is left out.
        seed: seed of the random number generator that draws the starts of EM, >= 0.
    """

    components: int | None = None
    seed: int = 0

    system = LinearMixture
    slider = ("components", 1, 15)

    def __post_init__(self) -> None:
        if self.components is not None:
            check.integer(self.components, "components", at_least=1, at_most=50)
        check.integer(self.seed, "seed", at_least=0)

    def learn(self, samples: Samples) -> LinearMixture:
        count = self.components
        return self._learned(samples, _best_count(self, samples) if count is None else count)

    def _learned(self, samples: Samples, count: int) -> LinearMixture:
        """The system of a number of components."""
        x, v = samples.x, samples.v
        blocks = self._mixture(x, v, count)
        gates = GaussianGates.of(blocks.weights, blocks.means[0], blocks.covariances[0])
        metric = fitted_quadratics(x, v, 0, seed=self.seed).symmetric
        metric = metric * len(metric) / np.trace(metric)
        weights = gates.weights(x)
        matrices = stable_matrices(weights, x, v, metric=metric, decay=_DECAY, ridge=_RIDGE)
        return LinearMixture(gates, matrices, metric)

    def _mixture(self, x: Float64Array, v: Float64Array, count: int) -> Blocks:
        """The components of positions and directions."""
        if count > len(x):
            raise FitError(f"components: expected at most one per sample, {len(x)}, got {count}")
        directions = v / np.maximum(np.linalg.norm(v, axis=1, keepdims=True), 1e-9)
        both = np.hstack([x, directions])
        blocks, _ = fit_blocks(
            [x, directions], both, count, seed=self.seed, starts=1, least=_MIN_VARIANCE
        )
        return blocks


def _best_count(model: LPVDS, samples: Samples) -> int:
    """The fewest components with about the least error of left-out demonstrations' paths."""
    folds = list(_folds(samples))
    fewest = min(len(known.x) for known, _ in folds)
    counts = [count for count in _COUNTS if count <= fewest]

    def error(count: int) -> float:
        model_of_count = replace(model, components=count)
        return sum(_path_error(model_of_count, known, left_out) for known, left_out in folds)

    errors = [error(count) for count in counts]
    least = (1.0 + _AS_GOOD) * min(errors)
    return next(count for count, found in zip(counts, errors, strict=True) if found <= least)


def _folds(samples: Samples) -> Iterator[tuple[Samples, Float64Array]]:
    """Samples to learn from, and the path (n, d) that they are to reproduce."""
    paths, rates = samples.positions, samples.velocities
    if len(paths) == 1:
        for rows in (slice(0, None, 2), slice(1, None, 2)):
            yield _with(samples, [paths[0][rows]], [rates[0][rows]]), paths[0]
        return
    for i in np.unique(np.linspace(0, len(paths) - 1, _MAX_FOLDS).round().astype(int)):
        others = [j for j in range(len(paths)) if j != i]
        yield _with(samples, [paths[j] for j in others], [rates[j] for j in others]), paths[i]


def _with(
    samples: Samples, positions: list[Float64Array], velocities: list[Float64Array]
) -> Samples:
    return replace(samples, positions=positions, velocities=velocities)


def _path_error(model: LPVDS, known: Samples, path: Float64Array) -> float:
    """Distance, under time warping, of a path (n, d) from the motion from its start."""
    try:
        made = goal_trajectory(model.learn(known), path[0])
    except (FitError, NoPath):
        return np.inf
    to_goal = np.vstack([path, np.zeros((1, path.shape[1]))])
    return dtw_distance(by_arc_length(made.positions, _COMPARED), by_arc_length(to_goal, _COMPARED))

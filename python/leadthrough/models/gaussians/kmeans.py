"""k-means clustering with the seeding of k-means++.

Sources: Lloyd 1982, "Least squares quantization in PCM"; Arthur and Vassilvitskii 2007, "k-means++:
the advantages of careful seeding".
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from leadthrough import check
from leadthrough.check import Float64Array, ShortRepr

_MAX_STEPS = 300


@dataclass(frozen=True, eq=False)
class Clusters(ShortRepr):
    """Points divided into clusters.

    Attributes:
        centres: centres (k, d).
        labels: index (n,) of each point's cluster.
        inertia: sum of squared distances of the points from their centres.
        steps: centres (k, d) before every step, the seeds first.
    """

    centres: Float64Array
    labels: NDArray[np.intp]
    inertia: float
    steps: tuple[Float64Array, ...]


SEEDINGS = ("plus_plus", "random")


def kmeans(
    points: ArrayLike,
    count: int,
    *,
    seed: int | np.random.Generator,
    seeding: Literal["plus_plus", "random"] = "plus_plus",
) -> Clusters:
    """Points divided into clusters, none of them empty.

    Columns are not scaled: scale them first where their units differ.

    Args:
        points: points (n, d).
        count: number of clusters, 1 to n.
        seed: seed of the random number generator, or a generator.
        seeding: "plus_plus", points far from those drawn before are likelier; "random", all points
            are as likely, as in Lloyd's algorithm by itself.
    """
    data = check.array(points, "points", shape=("n", "d"))
    size = check.integer(count, "count", at_least=1)
    if size > len(data):
        raise check.refused("count", f"at most one cluster per point, {len(data)}", size)
    if isinstance(seed, np.random.Generator):
        rng = seed
    else:
        rng = np.random.default_rng(check.integer(seed, "seed", at_least=0))
    if check.choice(seeding, "seeding", SEEDINGS) == "random":
        return clustered(data, data[rng.choice(len(data), size, replace=False)])
    return clustered(data, seeds(data, size, rng))


def seeds(points: Float64Array, count: int, rng: np.random.Generator) -> Float64Array:
    """Points drawn with probabilities proportional to squared distance from those drawn before."""
    chosen = [int(rng.integers(len(points)))]
    nearest = ((points - points[chosen[0]]) ** 2).sum(axis=1)
    for _ in range(count - 1):
        total = np.cumsum(nearest)
        if total[-1] > 0.0:
            drawn = int(np.searchsorted(total, rng.random() * total[-1], side="right"))
        else:  # only copies of the chosen points are left
            drawn = int(rng.integers(len(points)))
        chosen.append(min(drawn, len(points) - 1))
        nearest = np.minimum(nearest, ((points - points[chosen[-1]]) ** 2).sum(axis=1))
    return points[chosen]


def clustered(points: Float64Array, centres: Float64Array) -> Clusters:
    """Clusters after Lloyd's steps, taken until no point changes its cluster."""
    steps: list[Float64Array] = []
    labels = np.full(len(points), -1)
    while True:
        steps.append(centres)
        nearer, squared = _nearest(points, centres)
        if (nearer == labels).all() or len(steps) > _MAX_STEPS:
            return Clusters(centres, labels, float(squared.sum()), tuple(steps))
        labels = _without_empty(nearer, squared, len(centres))
        counts = np.bincount(labels, minlength=len(centres))
        centres = np.stack(
            [np.bincount(labels, column, len(centres)) / counts for column in points.T], axis=1
        )


def _nearest(points: Float64Array, centres: Float64Array) -> tuple[NDArray[np.intp], Float64Array]:
    """Index (n,) of each point's nearest centre, and the squared distance (n,) to it."""
    middle = points.mean(axis=0)  # so that the products cancel little
    a, b = points - middle, centres - middle
    labels = ((b**2).sum(axis=1)[:, None] - 2.0 * b @ a.T).argmin(axis=0)
    return labels, ((points - centres[labels]) ** 2).sum(axis=1)


def _without_empty(labels: NDArray[np.intp], squared: Float64Array, count: int) -> NDArray[np.intp]:
    """Labels (n,) in which each empty cluster has taken the farthest point of a larger one."""
    counts = np.bincount(labels, minlength=count)
    if counts.all():
        return labels
    labels = labels.copy()
    for point in np.argsort(-squared, kind="stable"):
        empty = np.flatnonzero(counts == 0)
        if len(empty) == 0:
            break
        if counts[labels[point]] > 1:
            counts[labels[point]] -= 1
            labels[point] = empty[0]
            counts[empty[0]] = 1
    return labels

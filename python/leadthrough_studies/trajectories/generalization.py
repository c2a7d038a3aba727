"""Chapter 4 of Grioli's notes (2023): weighted Gaussians, k-means, EM and regression, measured.

Four demonstrations of a motion in space, with scattered shape and timing, stand for the notes' own,
which are not public. Columns are time, x, y and z, each divided by its deviation.
"""

from __future__ import annotations

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.models import kmeans, trace_mixture
from leadthrough_studies.study import Row, Task
from leadthrough_studies.trajectories.forces import overlapping, shares_of

COMPONENTS = 6
_DEMONSTRATIONS, _SAMPLES = 4, 120
_SEEDS = 20  # starts of k-means with each seeding
_ITERATIONS = 30  # of EM
_KERNELS, _DECAY = 12, 4.0
_DRAWN = 60  # times of a curve that are kept for the figures


def tasks(seed: int) -> list[Task]:
    """A task for each of the notes' four figures, and one for k-means++.

    Args:
        seed: of the demonstrations and of all starts.
    """
    return [Task(each, {"seed": seed}) for each in (combination, clusters, seedings, regression)]


def demonstrations(seed: int) -> Float64Array:
    """Times and positions (demonstrations, samples, 4) of motions that differ in shape and pace."""
    rng = np.random.default_rng(seed)
    u = np.linspace(0.0, 1.0, _SAMPLES)
    shown = []
    for _ in range(_DEMONSTRATIONS):
        size, early = 1.0 + 0.08 * rng.standard_normal(3), 0.06 * rng.standard_normal()
        s = u + early * np.sin(2.0 * np.pi * u) / (2.0 * np.pi)
        x = 0.4 * size[0] * s
        y = 0.15 * size[1] * np.sin(2.0 * np.pi * s)
        z = 0.2 * size[2] * np.sin(np.pi * s) ** 2
        shown.append(np.column_stack([3.0 * u, x, y, z]))
    return np.array(shown)


def combination(seed: int) -> list[Row]:
    """Figure 4.1: a curve as a weighted sum of Gaussians of the decaying phase, and its error."""
    times, y = demonstrations(seed)[0][:, [0, 2]].T
    phase = np.exp(-_DECAY * times / times[-1])
    centres = np.exp(-_DECAY * np.arange(_KERNELS) / (_KERNELS - 1))
    shares = shares_of(phase, centres, overlapping(centres, 0.5))
    weights = np.linalg.lstsq(shares, y, rcond=None)[0]
    at = np.linspace(0, len(times) - 1, _DRAWN).astype(int)
    return [
        {
            "study": "combination",
            "error_m": float(np.abs(shares @ weights - y).max()),
            "times": times[at].tolist(),
            "shown": y[at].tolist(),
            "made": (shares @ weights)[at].tolist(),
            "parts": (shares * weights)[at].T.tolist(),
        }
    ]


def clusters(seed: int) -> list[Row]:
    """Figures 4.3 and 4.4: k-means from random points, one row for each of its steps."""
    points = _scaled(demonstrations(seed))
    found = kmeans(points, COMPONENTS, seed=seed, seeding="random")
    rows: list[Row] = []
    for i, centres in enumerate(found.steps):
        distances = np.linalg.norm(points[:, None] - centres, axis=2)
        nearest = distances.argmin(axis=1)
        before = rows[-1]["labels"] if rows else None
        rows.append(
            {
                "study": "k-means",
                "step": i,
                "inertia": float((distances.min(axis=1) ** 2).sum()),
                "changed": len(points) if before is None else int((nearest != before).sum()),
                "labels": nearest.tolist(),
                "centres": centres.tolist(),
            }
        )
    return rows


def seedings(seed: int) -> list[Row]:
    """Steps and inertia of k-means from random points and by k-means++, over many starts."""
    points = _scaled(demonstrations(seed))
    rows = []
    for seeding in ("random", "plus_plus"):
        found = [kmeans(points, COMPONENTS, seed=seed + i, seeding=seeding) for i in range(_SEEDS)]
        rows.append(
            {
                "study": "seeding",
                "seeding": seeding,
                "first_inertia": float(
                    np.mean([_inertia(points, each.steps[0]) for each in found])
                ),
                "inertia": float(np.mean([each.inertia for each in found])),
                "worst_inertia": float(max(each.inertia for each in found)),
                "steps": float(np.mean([len(each.steps) for each in found])),
            }
        )
    return rows


def regression(seed: int) -> list[Row]:
    """Figure 4.2: EM from k-means, its likelihood after each iteration, and the regression."""
    shown = demonstrations(seed)
    points = _scaled(shown)
    traced = trace_mixture(points, COMPONENTS, iterations=_ITERATIONS, seed=seed)
    likelihoods = [float(each.log_density(points).mean()) for each in traced]
    middle, scale = shown.mean(axis=(0, 1)), shown.std(axis=(0, 1))
    times = np.linspace(shown[0, 0, 0], shown[0, -1, 0], _DRAWN)
    inputs = ((times - middle[0]) / scale[0])[:, None]
    mean, covariance = traced[-1].regress(inputs, inputs=[0])
    made = mean * scale[1:] + middle[1:]
    true_mean = np.mean([[np.interp(times, d[:, 0], x) for x in d.T[1:]] for d in shown], axis=0).T
    return [
        {
            "study": "regression",
            "likelihoods": likelihoods,
            "least_ratio": float(np.divide(likelihoods[1:], likelihoods[:-1]).min()),
            "least_gain": float(np.diff(likelihoods).min()),
            "error_m": float(np.linalg.norm(made - true_mean, axis=1).max()),
            "times": times.tolist(),
            "mean": made.tolist(),
            "deviation": (np.sqrt(np.einsum("nii->ni", covariance)) * scale[1:]).tolist(),
            "components": (traced[-1].means * scale + middle).tolist(),
        }
    ]


def _scaled(shown: Float64Array) -> Float64Array:
    points = shown.reshape(-1, shown.shape[2])
    return np.asarray((points - points.mean(axis=0)) / points.std(axis=0))


def _inertia(points: Float64Array, centres: Float64Array) -> float:
    return float(((points[:, None] - centres) ** 2).sum(axis=2).min(axis=1).sum())

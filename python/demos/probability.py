"""Drawings of distributions for demos 15 and 16: bands, samples, mixtures, basis functions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Ellipse
from numpy.typing import NDArray

import leadthrough as lt
from leadthrough.drawing import palette
from leadthrough.models import Clusters, Mixture

Float64Array = NDArray[np.float64]
Style = dict[str, Any]  # Any: keywords of Matplotlib

BAND: Style = {"color": palette.BLUE, "alpha": 0.2, "linewidth": 0.0}
SAMPLE: Style = {"color": palette.BLUE, "linewidth": 0.6, "alpha": 0.6}
OBSERVED: Style = {"color": palette.VERMILION, "marker": "o", "linestyle": "none", "markersize": 5}


def draw_band(
    axes: Axes,
    times: Float64Array,
    mean: Float64Array,
    covariance: Float64Array,
    column: int,
    *,
    colour: str = palette.BLUE,
    label: str | None = None,
) -> None:
    """The mean (n, d) of one column over times (n,), and two standard deviations about it."""
    deviation = 2.0 * np.sqrt(np.maximum(covariance[:, column, column], 0.0))
    middle = mean[:, column]
    band = BAND | {"color": colour}
    axes.fill_between(times, middle - deviation, middle + deviation, **band)
    axes.plot(times, middle, color=colour, linewidth=1.6, label=label)
    axes.set_xlabel("time in s")


def draw_samples(axes: Axes, motions: Sequence[lt.Trajectory], column: int) -> None:
    """One column of motions over time."""
    for motion in motions:
        axes.plot(motion.times, motion.positions[:, column], **SAMPLE)


def draw_components(
    axes: Axes, mixture: Mixture, columns: tuple[int, int], *, deviations: float = 2.0
) -> None:
    """The components of a mixture in two columns, as ellipses of some standard deviations."""
    for i, (mean, covariance) in enumerate(zip(mixture.means, mixture.covariances, strict=True)):
        chosen = list(columns)
        values, axes_of = np.linalg.eigh(covariance[np.ix_(chosen, chosen)])
        width, height = 2.0 * deviations * np.sqrt(values)
        angle = float(np.degrees(np.arctan2(axes_of[1, 0], axes_of[0, 0])))
        x, y = mean[chosen]
        axes.add_patch(
            Ellipse((x, y), width, height, angle=angle, color=_colour(i), alpha=0.35, zorder=2)
        )
        axes.plot(x, y, marker="+", color="black", zorder=3)


def draw_ellipses(axes: Axes, means: Float64Array, matrices: Float64Array, style: Style) -> None:
    """Ellipses about points (n, 2) with half-axes as long as the roots of matrices (n, 2, 2)."""
    for (x, y), matrix in zip(means, matrices, strict=True):
        values, axes_of = np.linalg.eigh(matrix)
        width, height = 2.0 * np.sqrt(np.maximum(values, 0.0))
        angle = float(np.degrees(np.arctan2(axes_of[1, 0], axes_of[0, 0])))
        axes.add_patch(Ellipse((x, y), width, height, angle=angle, **style))


def draw_basis(axes: Axes, skill: lt.models.ProMPSkill[lt.Trajectory]) -> None:
    """The basis functions of a skill over the phase."""
    basis = skill.basis
    phases = np.linspace(0.0, 1.0, 50 * basis.count)
    for i, values in enumerate(basis(phases).T):
        axes.plot(phases, values, color=_colour(i), linewidth=1.0)
    axes.set_xlabel("phase")


def draw_kmeans_step(
    axes: Axes, points: Float64Array, clusters: Clusters, step: int, columns: tuple[int, int]
) -> None:
    """Points (n, d) in the colours of the nearest centre before a step, and the centres."""
    centres = clusters.steps[step]
    nearest = ((points[:, None] - centres) ** 2).sum(axis=2).argmin(axis=1)
    x, y = columns
    for i, centre in enumerate(centres):
        own = points[nearest == i]
        axes.plot(own[:, x], own[:, y], ".", color=_colour(i), markersize=2)
        axes.plot(centre[x], centre[y], marker="X", color=_colour(i), markeredgecolor="black")
    axes.set_title(f"step {step}", fontsize=9)


def draw_em_steps(
    all_axes: Sequence[Axes],
    points: Float64Array,
    mixtures: Sequence[Mixture],
    columns: tuple[int, int],
) -> None:
    """Points (n, d) and the components after every iteration, one picture each."""
    for i, (axes, mixture) in enumerate(zip(all_axes, mixtures, strict=True)):
        axes.plot(points[:, columns[0]], points[:, columns[1]], ".", color="0.7", markersize=1)
        draw_components(axes, mixture, columns)
        axes.set_title(f"iteration {i}", fontsize=9)


def _colour(index: int) -> str:
    return f"C{index % 10}"

"""Figures with matplotlib, drawn without a display into given axes or a new figure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from leadthrough.arm.limits import JointLimits
from leadthrough.check import Float64Array
from leadthrough.drawing import palette
from leadthrough.drawing.figure import styled
from leadthrough.models.marching.model import FastMarchingSkill
from leadthrough.motion import JointTrajectory
from leadthrough.reachability.reach_map import Placement, ReachMap
from leadthrough.shapes import Box
from leadthrough.validation.validate import Validation

Style = dict[str, Any]  # keyword arguments of matplotlib, each of its own type

DEMONSTRATION: Style = {"color": palette.DEMONSTRATION, "linewidth": 0.8}
HELD_OUT: Style = {"color": palette.BLACK, "linewidth": 1.0, "linestyle": (0, (4, 2))}
PATH: Style = {"color": palette.PATH, "linewidth": 1.6}
DETOUR: Style = {"color": palette.DETOUR, "linewidth": 1.6}
LIMIT: Style = {"color": palette.VERMILION, "linewidth": 0.8, "linestyle": "--"}
OBSTACLE: Style = {"facecolor": palette.OBSTACLE, "edgecolor": "none"}


def draw_velocity_map(axes: Axes, skill: FastMarchingSkill) -> None:
    """Draws the velocity map of a two-dimensional skill; the brighter, the faster."""
    lower = skill.grid.origin - 0.5 * skill.grid.spacing
    upper = lower + skill.grid.spacing * np.array(skill.grid.shape)
    axes.imshow(
        skill.velocity_map.T,
        origin="lower",
        extent=(lower[0], upper[0], lower[1], upper[1]),
        cmap="YlGnBu_r",
        vmin=-0.6,
        vmax=1.0,
        alpha=0.55,
    )
    axes.set_aspect("equal")


def draw_paths(axes: Axes, paths: Sequence[Float64Array], style: Style, *, label: str) -> None:
    """Draws the first two coordinates of paths in one style."""
    for i, path in enumerate(paths):
        axes.plot(path[:, 0], path[:, 1], **style, label=label if i == 0 else None)


def draw_box(axes: Axes, box: Box) -> None:
    """Draws the footprint of a box whose edges are parallel to the axes."""
    corner = box.position[:2] - 0.5 * box.size[:2]
    axes.add_patch(Rectangle((corner[0], corner[1]), box.size[0], box.size[1], **OBSTACLE))


@styled()
def limits_figure(trajectory: JointTrajectory, limits: JointLimits) -> Figure:
    """Position and its three derivatives of all joints over time, as fractions of the limits."""
    figure = Figure(figsize=(9.0, 7.5), layout="constrained")
    panels = figure.subplots(4, 1, sharex=True)
    with np.errstate(invalid="ignore"):  # a joint that turns without end has no middle
        middle, half = 0.5 * (limits.lower + limits.upper), 0.5 * (limits.upper - limits.lower)
    _draw_fractions(panels[0], trajectory.times, (trajectory.positions - middle) / half, "position")
    rates = (limits.velocity, limits.acceleration, limits.jerk)
    names = ("velocity", "acceleration", "jerk")
    for order, (axes, limit, name) in enumerate(zip(panels[1:], rates, names, strict=True), 1):
        times, values = _differences(trajectory, order)
        _draw_fractions(axes, times, values / (np.inf if limit is None else limit), name)
    lines = panels[0].lines[: len(middle)]
    panels[0].legend(lines, limits.joint_names, fontsize=7, ncols=4, loc="upper right")
    panels[-1].set_xlabel("time in s")
    return figure


def _draw_fractions(axes: Axes, times: Float64Array, fractions: Float64Array, name: str) -> None:
    axes.plot(times, fractions, linewidth=1.0)
    for limit in (-1.0, 1.0):
        axes.axhline(limit, **LIMIT)
    axes.set_ylabel(f"{name}\nof its limit")
    axes.set_ylim(-1.15, 1.15)


def _differences(trajectory: JointTrajectory, order: int) -> tuple[Float64Array, Float64Array]:
    """Times and values (n - order, joints) of a derivative, by differences between samples."""
    times, values = trajectory.times, trajectory.positions
    for _ in range(order):
        values = np.diff(values, axis=0) / np.diff(times)[:, None]
        times = 0.5 * (times[1:] + times[:-1])
    return times, values


_SIDES = ((0, 2, "x", "z"), (0, 1, "x", "y"))  # seen from the side, and from above


def reach_figure(reach_map: ReachMap) -> Figure:
    """The best of each line of sight, from the side and from above: reach and manipulability."""
    with styled():
        figure = Figure(figsize=(8.5, 7.5))
        panels = figure.subplots(2, 2)
        values = {
            "orientations reached": reach_map.fraction,
            "manipulability": reach_map.manipulability,
        }
        for row, (first, second, *names) in zip(panels, _SIDES, strict=True):
            for axes, (label, value) in zip(row, values.items(), strict=True):
                seen = value.max(axis=3 - first - second)
                drawn = axes.pcolormesh(
                    _edges(reach_map.axes[first], reach_map.spacing),
                    _edges(reach_map.axes[second], reach_map.spacing),
                    np.where(seen > 0.0, seen, np.nan).T,
                    vmin=0.0,
                )
                axes.set(xlabel=f"{names[0]} / m", ylabel=f"{names[1]} / m", aspect="equal")
                figure.colorbar(drawn, ax=axes, label=label)
    return figure


def placement_figure(placement: Placement) -> Figure:
    """Best manipulability by base position, over all heights and yaws."""
    positions, where = np.unique(placement.bases[:, :2], axis=0, return_inverse=True)
    best, most = np.zeros(len(positions)), np.zeros(len(positions))
    np.maximum.at(best, where.ravel(), placement.manipulability)
    np.maximum.at(most, where.ravel(), placement.fraction)
    with styled():
        figure = Figure(figsize=(5.5, 4.5))
        axes = figure.add_subplot()
        whole = best > 0.0
        x, y = positions.T
        axes.scatter(x[~whole], y[~whole], c="lightgray", s=12 + 60 * most[~whole])
        drawn = axes.scatter(x[whole], y[whole], c=best[whole], s=80, vmin=0.0)
        if placement.best is not None:
            axes.plot(placement.best[0], placement.best[1], "x", color="black")
        axes.set(xlabel="x of the base / m", ylabel="y of the base / m", aspect="equal")
        figure.colorbar(drawn, ax=axes, label="least manipulability along the motion")
    return figure


def _edges(centres: Float64Array, spacing: float) -> Float64Array:
    return np.append(centres, centres[-1] + spacing) - 0.5 * spacing


_CELLS = 12  # of the map along each axis
_AXES = "xyz"


def success_map(validation: Validation) -> Figure:
    """The success rate over the region of goals, seen along its shortest side."""
    goals = validation.certificate.goals
    sides = goals.upper - goals.lower
    wide = sorted(np.argsort(-sides, kind="stable")[:2].tolist())
    with styled():
        figure = Figure(figsize=(5.5, 4.5))
        _draw_rates(figure, validation, wide, sides)
    return figure


def _draw_rates(
    figure: Figure, validation: Validation, wide: list[int], sides: Float64Array
) -> None:
    goals, axes = validation.certificate.goals, figure.add_subplot()
    names = [_AXES[i] if len(sides) == len(_AXES) else f"coordinate {i + 1}" for i in wide]
    axes.set(xlabel=f"{names[0]} / m", ylabel=f"{names[-1]} / m")
    at = validation.goals[:, wide] if validation.goals.size else np.empty((0, len(wide)))
    known = np.isfinite(at).all(axis=1)
    if len(wide) == 2 and sides[wide].min() > 0.0:
        edges = [np.linspace(goals.lower[i], goals.upper[i], _CELLS + 1) for i in wide]
        every = _counted(at[known], edges)
        good = _counted(at[known & validation.succeeded], edges)
        rate = np.divide(good, every, out=np.full_like(every, np.nan), where=every > 0)
        drawn = axes.pcolormesh(edges[0], edges[1], rate.T, vmin=0.0, vmax=1.0, cmap="viridis")
        figure.colorbar(drawn, ax=axes, label="success rate")
    failed = at[known & ~validation.succeeded]
    if len(failed):
        axes.plot(failed[:, 0], failed[:, -1], ".", color="black", markersize=3)


def _counted(at: Float64Array, edges: list[Float64Array]) -> Float64Array:
    """The number of positions (n, 2) in each cell between the edges."""
    cells = [np.searchsorted(edge, column) - 1 for edge, column in zip(edges, at.T, strict=True)]
    counts = np.zeros((_CELLS, _CELLS))
    np.add.at(counts, tuple(np.clip(each, 0, _CELLS - 1) for each in cells), 1.0)
    return counts

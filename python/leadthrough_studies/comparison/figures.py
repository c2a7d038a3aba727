"""Figures 16 to 18 of Prados et al. 2023 from our runs, and what stability looks like."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from leadthrough.check import Float64Array
from leadthrough.io import lasa
from leadthrough.models import FastMarching
from leadthrough.planning import arrival_times, plan
from leadthrough.show import plot
from leadthrough_studies.comparison.methods import SYSTEMS

# Width of the tubes, mm, that can be seen in print; the paper's 25 pixels are 3 mm.
_MODEL = FastMarching(area_of_influence=3.0, saturation=0.1, resolution=0.25, method="map")
_ARROWS = 24  # along each side
_STARTS = 6  # along each side of the box around the demonstrations
_AROUND = 0.5  # of the demonstrations' extent, on each side


def without_and_with_experience(motion: str) -> Figure:
    """Figure 16: the way through an empty workspace, and after demonstrations.

    Args:
        motion: name of a motion of the LASA set.
    """
    shown = lasa.load(motion)
    skill = _MODEL.fit(shown)
    path = skill.generate().positions
    empty = np.full(skill.grid.shape, skill.model.saturation)
    straight = plan(empty, skill.grid, path[0], path[-1]).path
    figure = Figure(figsize=(9.0, 4.2), layout="constrained")
    panels = figure.subplots(1, 2)
    for axes, speed, way in zip(panels, (empty, skill.velocity_map), (straight, path), strict=True):
        _map(axes, skill.grid, speed)
        plot.draw_paths(axes, [way], plot.PATH, label="made")
        _ends(axes, way)
    panels[0].set_title("no experience: the shortest way")
    panels[1].set_title(f"{len(shown)} demonstrations")
    return figure


def one_and_many_shots(motion: str) -> Figure:
    """Figure 17: the velocity maps of one demonstration and of all, and their ways.

    Args:
        motion: name of a motion of the LASA set.
    """
    shown = lasa.load(motion)
    figure = Figure(figsize=(9.0, 4.2), layout="constrained")
    for axes, used in zip(figure.subplots(1, 2), (shown[:1], shown), strict=True):
        skill = _MODEL.fit(used)
        way = skill.generate(start=shown[0].motion.positions[0]).positions
        _map(axes, skill.grid, skill.velocity_map)
        plot.draw_paths(axes, [way], plot.PATH, label="made")
        _ends(axes, way)
        axes.set_title("one demonstration" if len(used) == 1 else f"{len(used)} demonstrations")
    return figure


def decisions(motion: str) -> Figure:
    """Figure 18 as computed: the value of each state (arrival time) and the action taken there.

    The paper draws the decision process as a scheme: states are cells, the action is the direction
    of the policy, what is rewarded is an early arrival.

    Args:
        motion: name of a motion of the LASA set.
    """
    skill = _MODEL.fit(lasa.load(motion))
    path = skill.generate().positions
    grid = skill.grid
    value = arrival_times(skill.velocity_map, grid.cells_of(path[-1:]), spacing=grid.spacing)
    x, y = (np.linspace(low, high, _ARROWS) for low, high in zip(*_bounds(grid), strict=True))
    places = np.array([(a, b) for a in x for b in y])
    action = np.array([skill.policy(place) for place in places])
    action /= np.maximum(np.linalg.norm(action, axis=1, keepdims=True), 1e-9)
    figure = Figure(figsize=(5.4, 4.6), layout="constrained")
    axes = figure.subplots()
    image = _map(axes, grid, value)
    axes.quiver(*places.T, *action.T, color="white", width=0.003, scale=40.0)
    plot.draw_paths(axes, [path], plot.PATH, label="made")
    _ends(axes, path)
    figure.colorbar(image, ax=axes, label="value of the state: time to the goal")
    axes.set_title("states, actions and values")
    return figure


def stability(motion: str, methods: Sequence[str]) -> Figure:
    """Trajectories of systems from starts all around a motion, and the energies' levels.

    Args:
        motion: name of a motion of the LASA set.
        methods: keys of SYSTEMS.
    """
    shown = lasa.load(motion)
    figure = Figure(figsize=(11.0, 2.8 * -(-len(methods) // 4)), layout="constrained")
    panels = figure.subplots(-(-len(methods) // 4), 4).ravel()
    for axes in panels[len(methods) :]:
        axes.set_axis_off()
    for axes, name in zip(panels, methods, strict=False):
        skill = SYSTEMS[name][len(SYSTEMS[name]) // 2].fit(shown)
        starts = _around(skill)
        _levels(axes, skill)
        for start in starts:
            axes.plot(*skill.generate(start=start, dt=0.05).positions.T, "tab:blue", linewidth=0.7)
        places = [each.motion.positions for each in shown]
        plot.draw_paths(axes, places, plot.DEMONSTRATION, label="demonstrations")
        axes.plot(*skill.ends[1], "k*", markersize=8)
        axes.set_title(name, fontsize=9)
        low, high = _box(skill)
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
        axes.tick_params(labelsize=6)
    return figure


def _around(skill: Any) -> Float64Array:
    """Starts (n, 2) on the sides of a box around the demonstrations."""
    low, high = _box(skill)
    along = np.linspace(0.0, 1.0, _STARTS)
    edges = [(t, 0.0) for t in along] + [(t, 1.0) for t in along]
    edges += [(0.0, t) for t in along[1:-1]] + [(1.0, t) for t in along[1:-1]]
    return np.asarray(low + np.array(edges) * (high - low))


def _box(skill: Any) -> tuple[Float64Array, Float64Array]:
    places = skill.positions * skill.scale + skill.ends[1]
    low, high = places.min(axis=0), places.max(axis=0)
    return low - _AROUND * (high - low), high + _AROUND * (high - low)


def _levels(axes: Axes, skill: Any) -> None:
    """Levels of the energy of a system at rest, evenly spaced in its square root."""
    low, high = _box(skill)
    x, y = (np.linspace(a, b, 60) for a, b in zip(low, high, strict=True))
    places = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    states = skill.field.states((places - skill.ends[1]) / skill.scale)
    energy = skill.field.energy(states)
    axes.contour(x, y, np.sqrt(energy).reshape(60, 60).T, 12, colors="0.85", linewidths=0.6)


def _bounds(grid: Any) -> tuple[Float64Array, Float64Array]:
    low = np.asarray(grid.origin)
    return low, low + np.asarray(grid.spacing) * (np.array(grid.shape) - 1)


def _map(axes: Axes, grid: Any, values: Float64Array) -> Any:
    """An image of values on a grid; what it returns is for a colour bar."""
    low, high = _bounds(grid)
    axes.set_aspect("equal")
    axes.set_xlabel("x, mm")
    axes.set_ylabel("y, mm")
    extent = (low[0], high[0], low[1], high[1])
    return axes.imshow(values.T, origin="lower", extent=extent, cmap="viridis")


def _ends(axes: Axes, path: Float64Array) -> None:
    axes.plot(*path[0], "ro", *path[-1], "r*", markersize=7)

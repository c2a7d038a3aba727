"""Figures 2 to 5 and 12 to 15 of Prados et al. 2023 anew, and what the first four say, measured.

- `of_map`: FM beside FM^2 among random walls, the map saturated by a fraction or by a distance.
- `plane_figure`: these paths in one map (figures 2 to 5).
- `dilation_figure`: a steep demonstration dilated by discs and by balls, in a section (12 and 13),
  an obstacle known while teaching and one that comes later, by equation 7 (14 and 15).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from scipy.ndimage import binary_dilation

from leadthrough.check import Float64Array
from leadthrough.models import FastMarching
from leadthrough.motion import Demonstration, Trajectory
from leadthrough.planning import Grid, arrival_times, fm2_speed, occupied, plan
from leadthrough.preprocess.resample import arc_length, by_arc_length
from leadthrough.shapes import Box
from leadthrough.show import plot
from leadthrough_studies import intervals, metrics
from leadthrough_studies.study import Row, selected

_GRID = Grid(np.zeros(2), 0.01, (101, 101))  # 1 m by 1 m
_START, _GOAL = np.array([0.05, 0.05]), np.array([0.95, 0.95])
_WALLS, _SIDE = 12, 0.12  # m
_PIECE = 0.02  # m, between which a path turns
# Saturation, a fraction of the largest distance from a wall, or the distance itself, m.
WAYS: dict[str, dict[str, float]] = {
    "FM": {"saturation": 0.0},
    "saturation 0.25": {"saturation": 0.25},
    "saturation 0.5": {"saturation": 0.5},
    "FM2": {"saturation": 1.0},
    "area of influence 0.05 m": {"area_of_influence": 0.05},
    "area of influence 0.1 m": {"area_of_influence": 0.1},
}
_RADIUS = 5  # cells, of disc and ball


def of_map(*, seed: int) -> list[Row]:
    """A row for every way: length of the path, m, its distance from walls, m, and its turns, rad.

    Turns are the sum of all between pieces of 2 cm, and the largest of one.
    """
    walls = _random_walls(seed)
    rows = []
    for way in WAYS:
        path = plan(_speed(walls, way), _GRID, _START, _GOAL).path
        rows.append(
            {
                "study": "maps",
                "seed": seed,
                "way": way,
                "length_m": float(arc_length(path)[-1]),
                "clearance_m": min(float(wall.distance(_in_space(path)).min()) for wall in walls),
                "turning_rad": metrics.turning(path, step=_PIECE),
                "sharpest_rad": _sharpest(path),
            }
        )
    return rows


def maps_table(rows: list[Row]) -> list[Row]:
    """Medians over maps of every way, with intervals."""
    rows = selected(rows, study="maps")
    lines = []
    for way in WAYS if rows else ():
        own = selected(rows, way=way)
        line: Row = {"way": way, "maps": len(own)}
        for name in ("length_m", "clearance_m", "turning_rad", "sharpest_rad"):
            found = intervals.median([row[name] for row in own])
            line |= {f"{name}_{each}": value for each, value in found.items()}
        lines.append(line)
    return lines


def _random_walls(seed: int) -> list[Box]:
    """Squares that leave start and goal free."""
    drawn = np.random.default_rng(seed).uniform(0.15, 0.85, (_WALLS, 2))
    return [Box((_SIDE, _SIDE, 1.0), (*centre, 0.0)) for centre in drawn]


def _speed(walls: list[Box], way: str) -> Float64Array:
    return fm2_speed(_GRID, occupied(_GRID, walls), **WAYS[way])


def _sharpest(path: Float64Array) -> float:
    pieces = np.diff(by_arc_length(path, int(arc_length(path)[-1] / _PIECE)), axis=0)
    headings = np.unwrap(np.arctan2(pieces[:, 1], pieces[:, 0]))
    return float(np.abs(np.diff(headings)).max())


def _in_space(path: Float64Array) -> Float64Array:
    return np.column_stack([path, np.zeros(len(path))])


def plane_figure(seed: int) -> Figure:
    """Figures 2 to 5: arrival times of FM and FM^2, and paths by saturation and distance."""
    walls = _random_walls(seed)
    figure = Figure(figsize=(13.0, 3.6), layout="constrained")
    shown = (
        ("2: FM", ("FM",)),
        ("3: FM²", ("FM2",)),
        ("4: saturation", ("FM", "saturation 0.25", "saturation 0.5", "FM2")),
        ("5: area of influence", ("area of influence 0.05 m", "area of influence 0.1 m", "FM2")),
    )
    for axes, (title, ways) in zip(figure.subplots(1, 4), shown, strict=True):
        speed = _speed(walls, ways[-1])
        times = arrival_times(speed, _GRID.cells_of(_GOAL[None]), spacing=_GRID.spacing)
        drawn = speed if len(ways) > 1 else np.where(np.isinf(times), np.nan, times)
        axes.imshow(drawn.T, origin="lower", extent=(0.0, 1.0, 0.0, 1.0))
        for way in ways:
            path = plan(_speed(walls, way), _GRID, _START, _GOAL).path
            axes.plot(*path.T, linewidth=1.2, label=way)
        axes.set_title(title)
        axes.legend(fontsize=6)
    return figure


def dilation_figure() -> Figure:
    """Figures 12 to 15: discs and balls in a section, and obstacles known and unknown."""
    figure = Figure(figsize=(13.0, 3.6), layout="constrained")
    panels = figure.subplots(1, 4)
    ball = (np.indices((2 * _RADIUS + 1,) * 2) - _RADIUS) ** 2
    for axes, title, element in (
        (panels[0], "12, 13: discs", (ball.sum(axis=0) <= _RADIUS**2) & (ball[1] == 0)),
        (panels[1], "13: balls", ball.sum(axis=0) <= _RADIUS**2),
    ):
        axes.imshow(binary_dilation(_steep(), element).T, origin="lower", cmap="Greys")
        axes.set_title(f"{title}, a section across")
    box = Box((0.2, 0.2, 1.0), (0.5, 0.25, 0.0))
    for axes, title, height in ((panels[2], "14: known", 0.45), (panels[3], "15: later", 0.2)):
        _draw_obstacle(axes, box, _arches(height))
        axes.set_title(f"{title} obstacle")
    return figure


def _steep() -> Any:
    """Marked cells of a quick, steep demonstration in a section (x, z)."""
    marked = np.zeros((60, 120), dtype=bool)
    z = np.arange(10, 110, 4)
    marked[20 + z // 6, z] = True
    return marked


def _arches(height: float) -> list[Demonstration[Trajectory]]:
    u = np.linspace(0.0, 1.0, 60)
    return [
        Demonstration(Trajectory(u, np.column_stack([u, top * np.sin(np.pi * u)])))
        for top in (height - 0.03, height, height + 0.03)
    ]


def _draw_obstacle(axes: Any, box: Box, shown: list[Demonstration[Trajectory]]) -> None:
    skill = FastMarching(
        area_of_influence=0.05, saturation=0.1, method="map", obstacle_map="minimum"
    ).fit(shown)
    path = skill.generate(obstacles=[box]).positions
    low, grid = np.asarray(skill.grid.origin), skill.grid
    high = low + np.asarray(grid.spacing) * (np.array(grid.shape) - 1)
    extent = (low[0], high[0], low[1], high[1])
    axes.imshow(skill.map_with([box]).T, origin="lower", extent=extent)
    plot.draw_paths(axes, [each.motion.positions for each in shown], plot.DEMONSTRATION, label="")
    axes.plot(*path.T, "w")

"""Panels of lines, bands and dots, which describe a figure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from leadthrough.drawing import palette

Numbers = NDArray[np.float64]
Marks = Sequence[tuple[float, str]]  # vertical lines: where, and their names

# Directions on the paper of x to the front left, y to the right and z up: seen from the front and
# from above, by 20 degrees.
_ASPECT = np.array([[-0.574, 0.819, 0.0], [-0.28, -0.196, 0.94]])
_TRIAD = 0.18  # length of the axes that are drawn along, as a fraction of the extent


@dataclass(frozen=True, eq=False)
class Line:
    """A polyline."""

    x: Numbers  # (n,)
    y: Numbers  # (n,)
    name: str = ""  # for the legend; without one it is not in it
    colour: str | None = None  # by default the next of the cycle
    width: float = 1.4  # in points
    dashed: bool = False  # whether it is


@dataclass(frozen=True, eq=False)
class Band:
    """The area between two curves over the same x (n,), in the colour of line number `line`."""

    x: Numbers
    lower: Numbers
    upper: Numbers
    line: int


@dataclass(frozen=True)
class Dot:
    """A point, with a text beside it; a radius of 0 leaves the text alone."""

    x: float
    y: float
    text: str = ""
    colour: str = palette.GREEN
    radius: float = 3.0


@dataclass(frozen=True, eq=False)
class Panel:
    """Lines in one pair of axes."""

    title: str  # the quantity drawn, and its unit
    lines: Sequence[Line]  # drawn in this order
    x_label: str = ""  # the quantity along x, and its unit
    bands: Sequence[Band] = ()  # below the lines
    dots: Sequence[Dot] = ()  # above the lines
    marks: Sequence[tuple[float, str]] = ()  # x of vertical lines and their texts
    equal: bool = False  # whether x and y have one scale; such a panel has no ticks
    rows: Sequence[str] = ()  # names of the rows y = 0, 1, ... from the top on; then y has no ticks

    def colour(self, index: int) -> str:
        return (
            self.lines[index].colour or palette.LIGHT_AND_DARK[index % len(palette.LIGHT_AND_DARK)]
        )


def over(
    x: Numbers,
    columns: Numbers,
    names: Sequence[str],
    *,
    title: str,
    x_label: str = "time in s",
    marks: Sequence[tuple[float, str]] = (),
    deviations: Numbers | None = None,
) -> Panel:
    """Columns over x."""
    lines = [Line(x, y, name) for y, name in zip(columns.T, short_names(names), strict=True)]
    bands = []
    if deviations is not None:
        pairs = zip(columns.T, 2.0 * deviations.T, strict=True)
        bands = [Band(x, y - far, y + far, i) for i, (y, far) in enumerate(pairs)]
    return Panel(title, lines, x_label, bands, marks=marks)


def paths(drawn: Sequence[Numbers], *, title: str) -> Panel:
    """Paths of points (n, 2) in the plane, or (n, 3) seen obliquely, from a ring to a disc."""
    flat = [on_paper(path) for path in drawn]
    colours = [palette.PATH] + [palette.DEMONSTRATION] * (len(drawn) - 1)
    widths = [1.8] + [0.8] * (len(drawn) - 1)
    lines = [
        Line(path[:, 0], path[:, 1], colour=colour, width=width)
        for path, colour, width in zip(flat, colours, widths, strict=True)
    ][::-1]
    (first_x, first_y), (last_x, last_y) = flat[0][[0, -1]].tolist()
    ends = [Dot(first_x, first_y, "start", palette.GREY), Dot(last_x, last_y, "goal")]
    if drawn[0].shape[1] == 2:
        return Panel(title, lines, dots=ends, equal=True)
    paper = np.vstack(flat)
    extent = float(np.ptp(paper, axis=0).max()) or 1.0
    corner = paper.min(axis=0) - [1.5 * _TRIAD * extent, 0.0]
    axes, names = triad(corner, _TRIAD * extent)
    return Panel(title, [*axes, *lines], dots=[*names, *ends], equal=True)


def triad(corner: Numbers, length: float) -> tuple[list[Line], list[Dot]]:
    """The axes x, y, z from a corner (2,) on the paper, with their names at their ends."""
    lines, names = [], []
    for name, axis in zip("xyz", length * on_paper(np.eye(3)), strict=True):
        x, y = np.stack([corner, corner + axis]).T
        lines.append(Line(x, y, colour=palette.GREY, width=1.0))
        names.append(Dot(float(x[1]), float(y[1]), name, palette.GREY, radius=0.0))
    return lines, names


def on_paper(points: Numbers) -> Numbers:
    """Drawn coordinates (n, 2) of points (n, 2) or (n, 3)."""
    return points if points.shape[1] == 2 else np.asarray(points @ _ASPECT.T)


def short_names(names: Sequence[str]) -> list[str]:
    """Names without the beginning and the end that all have in common."""
    if len(names) < 2:
        return list(names)
    start = _common(names)
    # Digits stay together: joint_1 to joint_10 become 1 to 10.
    while start and names[0][start - 1].isdigit():
        start -= 1
    end = _common([name[start:][::-1] for name in names])
    short = [name[start : len(name) - end] for name in names]
    return short if all(short) else list(names)


def spans_over_time(
    rows: Sequence[tuple[str, Sequence[tuple[float, float]]]], *, title: str
) -> Panel:
    """Spans of time, s, one row for each name; a span without length is a dot."""
    lines, dots = [], []
    for i, (_, spans) in enumerate(rows):
        for start, end in spans:
            if end > start:
                height = np.full(2, float(i))
                lines.append(Line(np.array([start, end]), height, colour=palette.BLUE, width=8.0))
            else:
                dots.append(Dot(start, float(i), colour=palette.VERMILION))
    return Panel(title, lines, "time in s", dots=dots, rows=[name for name, _ in rows])


def _common(names: Sequence[str]) -> int:
    """How many letters all the names begin with."""
    pairs = zip(min(names), max(names), strict=False)
    return next((i for i, (a, b) in enumerate(pairs) if a != b), min(map(len, names)))


def bars(
    rows: Sequence[tuple[str, float, float]],
    *,
    title: str,
    x_label: str,
    limit: float | None = None,
) -> Panel:
    """A horizontal bar for each name, from one number to another."""
    lines = []
    for i, (_, low, high) in enumerate(rows):
        beyond = limit is not None and high > limit
        colour = palette.VERMILION if beyond else palette.BLUE
        ends, height = np.array([low, high]), np.full(2, float(i))
        lines.append(Line(ends, height, colour=colour, width=8.0))
    if limit is not None:
        ends = np.array([-0.5, len(rows) - 0.5])
        lines.append(Line(np.full(2, limit), ends, colour=palette.GREY, width=1.2, dashed=True))
    return Panel(title, lines, x_label, rows=[name for name, *_ in rows])


def of_points(
    times: Numbers,
    positions: Numbers,
    marks: Marks,
    *,
    deviations: Numbers | None = None,
    unit: str = "",
) -> list[Panel]:
    """Points (n, d): their path where it lies in a plane or in space, and each over time."""
    size = positions.shape[1]
    names = "xyz"[:size] if size <= 3 else [str(i + 1) for i in range(size)]
    title = f"position in {unit}" if unit else "position"
    along = over(times, positions, names, title=title, marks=marks, deviations=deviations)
    return [paths([positions], title="path"), along] if size in (2, 3) else [along]


def of_poses(
    times: Numbers,
    positions: Numbers,
    orientations: Numbers,
    marks: Marks,
    *,
    deviations: Numbers | None = None,
) -> list[Panel]:
    """Poses: the path, and position and quaternion over time."""
    rotation = over(times, orientations, "wxyz", title="orientation, a quaternion")
    return [*of_points(times, positions, marks, unit="m", deviations=deviations), rotation]


def of_joints(
    times: Numbers,
    positions: Numbers,
    velocities: Numbers | None,
    names: Sequence[str],
    marks: Marks,
    *,
    deviations: Numbers | None = None,
) -> list[Panel]:
    """Joints: positions and velocities, which are differences where the motion has none."""
    called = names or [f"joint {i + 1}" for i in range(positions.shape[1])]
    if velocities is None:
        several = len(times) > 1
        velocities = np.gradient(positions, times, axis=0) if several else 0.0 * positions
    at = over(
        times, positions, called, title="joint positions in rad (m)", marks=marks,
        deviations=deviations,
    )  # fmt: skip
    return [at, over(times, velocities, called, title="joint velocities in rad/s (m/s)")]

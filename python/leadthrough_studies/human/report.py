"""Table and figures of the study of human demonstrations, with the paper's claims."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from leadthrough.drawing import palette
from leadthrough_studies.human import demonstrations, measures, repeated
from leadthrough_studies.study import Report, Row, mean, selected

# Yang, Liu and Pears, section IV B, on the learned velocity. The paper prints no numbers.
CLAIMS = {
    ("human", "joint 1"): "reduced",
    ("human", "joint 3"): "flattened",
    ("human", "joint 5"): "overshoots, oscillates",
    ("DLS-IK", "joint 1"): "a smooth bell",
    ("DLS-IK", "joint 3"): "a smooth bell",
    ("DLS-IK", "joint 5"): "a smooth bell",
}
EXPLAINED = (
    "Reduced and flattened peaks have three causes, whose parts stand in parts.csv: the peaks seem "
    "higher in the demonstrations because differences of a recording add its noise, and averaging "
    "demonstrations of different timing and of different shape lowers them. Few basis functions do "
    "the same to a single demonstration. Aligning the demonstrations in time restores the "
    "peaks that they have in common, as the symbol traced on a real arm shows, but not those of "
    "single demonstrations. "
    "Peaks higher than demonstrated, with an oscillation, are not caused by the person: basis "
    "functions narrower than about half their spacing make the velocity ripple between their "
    "centres, for both sources (see the sweep over widths). "
    "The bell of damped least squares comes neither from damped least squares nor from the ProMP, "
    "but from the time law of the tool along its line. Joints interpolated linearly, as the paper "
    "words it, move at constant speed, also after learning. They get a bell-like velocity only if "
    "rests were recorded before and after, and few, wide basis functions round off the edges (see "
    "the time laws). The secondary task of equation 6 acts from the first step on: the joint "
    "velocities do not start at zero, unlike a bell."
)
MEASURES = (
    "peak_ratio",
    "position_rmse",
    "velocity_rmse",
    "sign_changes_shown",
    "sign_changes_learned",
    "reversals_shown",
    "reversals_learned",
    "bell_distance_learned",
)
_SHOWN: dict[str, Any] = {"color": "0.55", "linewidth": 0.8}
_COLOURS = {"one": palette.BLUE, "all": palette.VERMILION, "all, aligned": palette.GREEN}
_LINES = {"human": "-", "DLS-IK": "--"}


def report(config: Any, rows: list[Row]) -> Report:
    """A table of the sources beside the paper's claims; figures of sweep, time laws, recordings."""
    learned, swept = selected(rows, study="learning"), selected(rows, study="sweep")
    laws, recorded = selected(rows, study="time laws"), selected(rows, study="recordings")
    figures = {}
    if learned:
        for joint in config.joints:
            figures[f"joint_{joint}"] = _joint_figure(selected(learned, column=f"joint {joint}"))
    if swept:
        figures["sweep"] = _sweep_figure(config, swept)
    if laws:
        figures["time_laws"] = _laws_figure(laws)
    symbols = [row for row in recorded if "course" in row]
    if symbols:
        figures["recordings"] = _symbol_figure(symbols)
    table = [_line(row, CLAIMS[row["source"], row["column"]]) for row in learned]
    return Report(
        table=[*table, *_recorded(recorded)],
        figures=figures,
        summary={
            "demonstrations": demonstrations.__doc__,
            "measures": measures.__doc__,
            "explained": EXPLAINED,
            "sweep": swept,
            "time_laws": [_without_course(row) for row in laws],
        },
        tables={
            "seeds": repeated.table(selected(rows, study="seeds")),
            "parts": repeated.parts(selected(rows, study="losses")),
            "laws": [_of_law(row) for row in laws],
        },
    )


def _without_course(row: Row) -> Row:
    return {name: value for name, value in row.items() if name != "course"}


def _of_law(row: Row) -> Row:
    names = ("law", "weights", "column", "bell_distance_shown", "bell_distance_learned")
    return {name: row[name] for name in names}


def _line(row: Row, claim: str | None) -> Row:
    labels = {name: row[name] for name in ("source", "learned_from", "column")}
    return {**labels, "paper": claim, **{name: row[name] for name in MEASURES}}


def _recorded(rows: list[Row]) -> list[Row]:
    """Means over the motions of a recording."""
    names = ("source", "learned_from", "column")
    keys = dict.fromkeys(tuple(row[name] for name in names) for row in rows)
    table = []
    for key in keys:
        labels = dict(zip(names, key, strict=True))
        own = selected(rows, **labels)
        table.append(_line({**labels, **{name: mean(own, name) for name in MEASURES}}, None))
    return table


def _joint_figure(rows: list[Row]) -> Figure:
    """Position and velocity of a joint as demonstrated and as learned, like figures 6 to 8."""
    sources = list(dict.fromkeys(row["source"] for row in rows))
    figure = Figure(figsize=(9.0, 2.8 * len(sources)), layout="constrained")
    panels = figure.subplots(len(sources), 2, squeeze=False)
    for (left, right), source in zip(panels, sources, strict=True):
        for row in selected(rows, source=source):
            label = f"learned from {row['learned_from']}"
            style = {"color": _COLOURS[row["learned_from"]], "linewidth": 1.4, "label": label}
            _draw(left, row, "position", style, shown=row["learned_from"] == "one")
            _draw(right, row, "velocity", style, shown=row["learned_from"] == "one")
        left.set_ylabel(f"{source}: {rows[0]['column']}, rad")
        right.set_ylabel("rad/s")
        for axes in (left, right):
            axes.set_xlabel("fraction of the time")
    panels[0, 0].set_title("position")
    panels[0, 1].set_title("velocity")
    panels[0, 0].legend(fontsize=7)
    return figure


def _draw(axes: Axes, row: Row, quantity: str, style: dict[str, Any], *, shown: bool) -> None:
    """Draw over the fraction of the time; a velocity is that in its demonstration's duration."""
    course = row["course"]
    fraction = np.array(course["time"]) / course["time"][-1]
    if shown:
        axes.plot(fraction, course[f"{quantity}_shown"], **_SHOWN, label="first, as demonstrated")
    axes.plot(fraction, course[f"{quantity}_learned"], **style)


def _sweep_figure(config: Any, rows: list[Row]) -> Figure:
    """Ratio of peaks and reversals over the number of basis functions, for each width."""
    figure = Figure(figsize=(3.2 * len(config.joints) + 1.6, 5.0), layout="constrained")
    panels = figure.subplots(2, len(config.joints), squeeze=False, sharex=True, sharey="row")
    for column, joint in zip(panels.T, config.joints, strict=True):
        for source, line in _LINES.items():
            for i, width in enumerate(config.swept_widths):
                own = selected(rows, column=f"joint {joint}", source=source, width=width)
                own.sort(key=lambda row: row["weights"])
                style = {"color": f"C{i}", "linestyle": line, "marker": "o", "markersize": 3}
                count = [row["weights"] for row in own]
                label = f"{source}, width {width:g}"
                column[0].plot(count, [row["peak_ratio"] for row in own], **style, label=label)
                column[1].plot(count, [row["reversals_learned"] for row in own], **style)
        column[0].axhline(1.0, color="0.5", linewidth=0.8)
        column[0].set_title(f"joint {joint}")
        column[1].set_yscale("log")
        column[1].set_xlabel("basis functions")
    panels[0, 0].set_ylabel("peak speed, learned over shown")
    panels[1, 0].set_ylabel("reversals of the acceleration")
    lines, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(lines, labels, loc="outside right center", fontsize=7)
    return figure


def _laws_figure(rows: list[Row]) -> Figure:
    """Each joint's velocity by each time law, demonstrated and learned; distance from a bell."""
    laws = list(dict.fromkeys(row["law"] for row in rows))
    joints = list(dict.fromkeys(row["column"] for row in rows))
    figure = Figure(figsize=(2.9 * len(laws), 2.3 * len(joints)), layout="constrained")
    panels = figure.subplots(len(joints), len(laws), squeeze=False, sharex=True)
    for line, joint in zip(panels, joints, strict=True):
        for axes, law in zip(line, laws, strict=True):
            own = selected(rows, law=law, column=joint)
            for i, row in enumerate(own):
                label = f"learned, {row['weights']} basis functions"
                style = {"color": f"C{i}", "linewidth": 1.3, "label": label}
                _draw(axes, row, "velocity", style, shown=i == 0)
            low, high = axes.get_ylim()
            axes.set_ylim(min(0.0, low), 1.2 * high)
            far = ", ".join(f"{row['bell_distance_learned']:.2f}" for row in own)
            axes.set_title(f"{law}\n{far} from a bell", fontsize=8)
        line[0].set_ylabel(f"{joint}, rad/s")
    for axes in panels[-1]:
        axes.set_xlabel("fraction of the time")
    panels[0, -1].legend(fontsize=6)
    return figure


def _symbol_figure(rows: list[Row]) -> Figure:
    """The velocity of a symbol traced by hand, as recorded and as learned."""
    columns = list(dict.fromkeys(row["column"] for row in rows))
    ways = list(dict.fromkeys(row["learned_from"] for row in rows))
    figure = Figure(figsize=(3.6 * len(ways), 2.5 * len(columns)), layout="constrained")
    panels = figure.subplots(len(columns), len(ways), squeeze=False, sharey="row")
    for line, column in zip(panels, columns, strict=True):
        for axes, way in zip(line, ways, strict=True):
            for row in selected(rows, column=column, learned_from=way):
                style = {"color": _COLOURS[way], "linewidth": 1.4}
                _draw(axes, row, "velocity", style, shown=True)
            axes.set_title(f"learned from {way}", fontsize=9)
            axes.set_xlabel("fraction of the time")
        line[0].set_ylabel(f"{column}, m/s")
    return figure

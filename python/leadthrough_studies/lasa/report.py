"""Table and figures of the LASA handwriting study."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from leadthrough.io import lasa
from leadthrough.motion import Trajectory
from leadthrough.show import plot
from leadthrough_studies.lasa.methods import HEADLINE, PIXELS_PER_MM
from leadthrough_studies.study import Report, Row, mean, selected

ERRORS = ("SEA_mm2", "V_rmse_mm_s", "DTWD_per_N_mm", "Frechet_mm", "end_error_mm")
DRAWN = "FML"

# Prados et al. 2023, Table 2: SEA and V_rmse as printed there.
TABLE_2 = {
    "SEDS": (8.18e5, 142.9),
    "CLF-DM": (5.72e5, 71.8),
    "FSM-DM": (8.37e5, 172.6),
    "UMIC": (8.79e5, 143.2),
    "Modified DS": (4.07e5, 56.9),
    "FML": (1.23e5, 12.48),
    "FML with auto-learning": (None, 9.17),
}
REMARK = (
    "SEA_sum_px2 is the sum over the 7 demonstrations of a motion, in px^2 at 8.3 px/mm. The paper "
    "states neither the sum nor the scale, so that no agreement with its own row (protocol IN) is "
    "claimed. Its rows for other methods cannot be reproduced from the recordings in mm: a motion "
    "that stands still has a V_rmse of 22 mm/s, but the paper prints 57 to 173. These rows are "
    "quoted, not compared with."
)


def report(config: Any, rows: list[Row]) -> Report:
    """Means over all reproductions beside the paper's table, the ranking of shapes, the sweeps."""
    compared = selected(rows, study="compare")
    figures = {}
    if compared:
        figures["methods"] = _methods_figure(config, compared)
    if selected(compared, protocol=HEADLINE):
        figures["ranking"] = _ranking_figure(config, compared)
        figures["shapes"] = _shapes_figure(config, compared)
    if selected(rows, study="sweep"):
        figures["saturation"] = _saturation_figure(config, rows)
    return Report(
        table=[
            *_comparison(config, compared),
            *_systems(config, rows),
            *_auto_learning(config, rows),
            *_quoted(),
        ],
        figures=figures,
        summary={
            "remark": REMARK,
            "ranking": {name: ranking(config, compared, name) for name in config.methods},
            "saturation": _sweep(config, rows),
        },
        tables={
            "saturation": _sweep(config, rows),
            "auto_learning": _learning(config, rows),
            "characteristics": [
                {name: value for name, value in row.items() if name != "study"}
                for row in selected(rows, study="characteristics")
            ],
        },
    )


def ranking(config: Any, rows: Sequence[Row], method: str) -> list[Row]:
    """The motions by their mean swept error area when left out, worst first."""
    own = selected(rows, protocol=HEADLINE, method=method)
    errors = {name: mean(selected(own, motion=name), "SEA_mm2") for name in config.motions}
    found = [(error, name) for name, error in errors.items() if error is not None]
    return [{"motion": name, "SEA_mm2": error} for error, name in sorted(found, reverse=True)]


def _line(protocol: str, method: str, rows: Sequence[Row]) -> Row:
    means = {name: mean(rows, name) for name in ERRORS}
    area = means["SEA_mm2"]
    pixels = None if area is None else area * 7 * PIXELS_PER_MM**2
    return {
        "protocol": protocol,
        "method": method,
        "n": len(rows),
        **means,
        "SEA_sum_px2": pixels,
    }


def _comparison(config: Any, rows: Sequence[Row]) -> list[Row]:
    return [
        _line(protocol, method, selected(rows, protocol=protocol, method=method))
        for protocol in config.protocols
        for method in config.methods
    ]


def _systems(config: Any, rows: Sequence[Row]) -> list[Row]:
    found = selected(rows, study="systems")
    return [
        _line("IN", name, own) for name in config.systems if (own := selected(found, method=name))
    ]


def _auto_learning(config: Any, rows: Sequence[Row]) -> list[Row]:
    learned = selected(rows, study="auto-learning")
    return [
        _line("IN, auto-learning", setting, selected(learned, method=setting))
        for setting in config.settings
        if learned
    ]


def _quoted() -> list[Row]:
    return [
        {
            **_line("Table 2, quoted", method, []),
            "V_rmse_mm_s": velocity,
            "SEA_sum_px2": area,
        }
        for method, (area, velocity) in TABLE_2.items()
    ]


def _sweep(config: Any, rows: Sequence[Row]) -> list[Row]:
    swept = selected(rows, study="sweep")
    return [
        {"method": setting, "saturation": saturation, **{name: mean(own, name) for name in ERRORS}}
        for setting in config.settings
        for saturation in config.saturations
        if (own := selected(swept, method=setting, saturation=saturation))
    ]


def _learning(config: Any, rows: Sequence[Row]) -> list[Row]:
    learned = selected(rows, study="auto-learning")
    lines = []
    for setting in config.settings:
        own = selected(learned, method=setting)
        new = selected(own, auto_learned=1)
        lines.append(
            {
                "method": setting,
                "paths": len(own),
                "auto_learned": len(new),
                "kappa": mean(own, "kappa"),
                "length_to_shown": _ratio(own, "length_mm", "length_shown_mm"),
                "length_to_before": _ratio(new, "length_mm", "length_before_mm"),
                "travel_time_to_before": _ratio(new, "travel_time", "travel_time_before"),
            }
        )
    return lines


def _ratio(rows: Sequence[Row], column: str, before: str) -> float | None:
    return mean([{"ratio": row[column] / row[before]} for row in rows], "ratio")


def _methods_figure(config: Any, rows: Sequence[Row]) -> Figure:
    figure = Figure(figsize=(11.0, 4.6), layout="constrained")
    left, right = figure.subplots(1, 2)
    width = 0.8 / len(config.methods)
    for axes, column in ((left, "SEA_mm2"), (right, "V_rmse_mm_s")):
        for i, method in enumerate(config.methods):
            own = selected(rows, method=method)
            heights = [mean(selected(own, protocol=name), column) for name in config.protocols]
            places = [j + (i + 0.5) * width - 0.4 for j in range(len(heights))]
            axes.bar(places, [height or 0.0 for height in heights], width, label=method)
        axes.set_xticks(range(len(config.protocols)), config.protocols)
        axes.set_title("SEA, mm²" if axes is left else "V_rmse, mm/s")
    handles, labels = right.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4, fontsize=8)
    return figure


def _ranking_figure(config: Any, rows: Sequence[Row]) -> Figure:
    figure = Figure(figsize=(8.0, 0.24 * len(config.motions) + 1.4), layout="constrained")
    axes = figure.subplots()
    order = [row["motion"] for row in ranking(config, rows, _drawn(config))]
    for method in config.methods:
        errors = {row["motion"]: row["SEA_mm2"] for row in ranking(config, rows, method)}
        places = [i for i, name in enumerate(order) if name in errors]
        axes.plot([errors[order[i]] for i in places], places, "o", markersize=4, label=method)
    axes.set_yticks(range(len(order)), order, fontsize=8)
    axes.invert_yaxis()
    axes.set_xscale("log")
    axes.set_xlabel("SEA when left out, mm²")
    axes.grid(axis="y", linewidth=0.3)
    axes.legend(fontsize=7)
    return figure


def _shapes_figure(config: Any, rows: Sequence[Row]) -> Figure:
    columns = min(len(config.motions), 6)
    lines = -(-len(config.motions) // columns)
    figure = Figure(figsize=(2.0 * columns, 2.0 * lines), layout="constrained")
    panels = figure.subplots(lines, columns, squeeze=False).ravel()
    own = selected(rows, protocol=HEADLINE, method=_drawn(config))
    for axes in panels:
        axes.set_axis_off()
    for axes, name in zip(panels, config.motions, strict=False):
        motions = [demonstration.motion for demonstration in lasa.load(name)]
        shown = [motion.positions for motion in motions if isinstance(motion, Trajectory)]
        made = [_points(row) for row in selected(own, motion=name)]
        plot.draw_paths(axes, shown, plot.DEMONSTRATION, label="demonstrations")
        plot.draw_paths(axes, made, {**plot.PATH, "linewidth": 0.8}, label=_drawn(config))
        axes.set_title(name, fontsize=8)
        axes.set_aspect("equal")
    figure.suptitle(f"{_drawn(config)}: each demonstration left out and reproduced")
    return figure


def _points(row: Row) -> Any:
    return np.array(row["path"])


def _saturation_figure(config: Any, rows: Sequence[Row]) -> Figure:
    figure = Figure(figsize=(9.0, 3.6), layout="constrained")
    lines = _sweep(config, rows)
    for axes, column in zip(figure.subplots(1, 2), ("SEA_mm2", "V_rmse_mm_s"), strict=True):
        for setting in config.settings:
            own = selected(lines, method=setting)
            axes.plot(
                [row["saturation"] for row in own],
                [row[column] for row in own],
                "o-",
                label=setting,
            )
        axes.set_xlabel("saturation")
        axes.set_title(f"{column}, left out")
        axes.legend(fontsize=7)
    return figure


def _drawn(config: Any) -> str:
    return DRAWN if DRAWN in config.methods else str(config.methods[0])

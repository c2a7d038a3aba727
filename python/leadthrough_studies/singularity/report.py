"""Table and figures of the singularity study, with the paper's numbers beside ours."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from leadthrough.drawing import palette
from leadthrough_studies import intervals
from leadthrough_studies.singularity import draws, joint_limits, paths, penalty
from leadthrough_studies.singularity.paths import APPROACHES
from leadthrough_studies.study import Report, Row, selected

REMARK = (
    "The paper takes more samples below 8 for more stable control. By its own Table I the share "
    "below 10 falls from 100 to 83 % with damping: that is no improvement. The condition number "
    "is that of the postures passed, and damping changes postures little: what moves the shares "
    "is the secondary task, and where the paths lie, which the paper does not state. In SI units a "
    "Panda in the middle of its workspace has a condition number of about 9, so thresholds of 8 "
    "and 10 tell postures apart that are all far from singular."
)
_QUANTITIES = {"position": "rad", "velocity": "rad/s", "torque": "N m"}
_PEAKS_OF_OTHER_JOINTS = tuple(f"peak_velocity_{joint}" for joint in (1, 2, 3, 5))
_NOT_IN_THE_TABLE = ("study", "course", *_PEAKS_OF_OTHER_JOINTS)
# The paper's figures show two methods; the others are drawn thinner.
_STYLES: dict[str, dict[str, Any]] = {
    "plain": {"color": palette.VERMILION, "linewidth": 1.4},
    "damped alone": {"color": palette.AMBER, "linewidth": 0.9},
    "damped": {"color": palette.BLUE, "linewidth": 1.4},
    "damped, by ranges": {"color": palette.SKY, "linewidth": 0.9},
    "follow, slowing": {"color": palette.GREEN, "linewidth": 0.9},
    "follow, deviating": {"color": palette.PINK, "linewidth": 0.9},
}


def report(config: Any, rows: list[Row]) -> Report:
    """The approaches beside the paper's numbers, and the sweep in a figure."""
    approaches, swept = selected(rows, study="approach"), selected(rows, study="sweep")
    figures = {}
    for number in config.approaches:
        own = selected(approaches, approach=number)
        if own:
            figures[f"approach_{number}"] = _course_figure(number, own)
    if approaches:
        figures["condition"] = _condition_figure(config, approaches)
    if swept:
        figures["sweep"] = _sweep_figure(config, swept)
    return Report(
        table=[_table_row(row) for row in approaches],
        figures=figures,
        summary={
            "approaches": paths.__doc__,
            "tables_1_and_2": _tables(approaches),
            "remark": REMARK,
            "sweep": swept,
        },
        tables=_of_draws(rows, swept),
    )


def _of_draws(rows: list[Row], swept: list[Row]) -> dict[str, list[Row]]:
    """Tables of the random paths and poses."""
    limits, related = selected(rows, study="joint limits"), selected(rows, study="relation")
    return {
        "draws": draws.table(rows),
        "joint_limits": joint_limits.table(limits),
        "alpha": penalty.table(selected(rows, study="alpha")),
        "relation": [*_related("sweep", swept), *_related("random paths", related)],
    }


def _related(where: str, rows: list[Row]) -> list[Row]:
    """Spearman's correlation of condition numbers with loads, with 95 % intervals."""
    return [
        {"where": where, "condition": condition, "load": load, "motions": len(rows)}
        | intervals.correlation([row[condition] for row in rows], [row[load] for row in rows])
        for condition in ("condition", "condition_weighted")
        for load in ("peak_velocity", "peak_share_of_effort_limit", "torque_roughness")
        if len(rows) > 2
    ]


def _tables(rows: list[Row]) -> list[Row]:
    """The paper's Tables I and II line by line, with our shares in both weightings beside them."""
    return [
        {
            "table": "I" if row["approach"] == 1 else "II",
            "method": row["method"],
            "below": bound,
            "paper_percent": APPROACHES[row["approach"]].paper[row["method"]][f"below_{bound}"],
            "percent": row[f"below_{bound}_percent"],
            "weighted_percent": row[f"below_{bound}_weighted_percent"],
        }
        for row in rows
        if row["method"] in APPROACHES[row["approach"]].paper
        for bound in (8, 10)
    ]


def _table_row(row: Row) -> Row:
    printed = APPROACHES[row["approach"]].paper.get(row["method"], {})
    beside = {
        "paper_below_8_percent": printed.get("below_8"),
        "paper_below_10_percent": printed.get("below_10"),
        "paper_peak_velocity_6": printed.get("joint_6"),
        "paper_peak_velocity_7": printed.get("joint_7"),
    }
    own = {name: value for name, value in row.items() if name not in _NOT_IN_THE_TABLE}
    return {**own, **beside}


def _course_figure(number: int, rows: list[Row]) -> Figure:
    """Position, velocity and torque of the affected joints, as in the paper's figures."""
    joints = APPROACHES[number].joints
    figure = Figure(figsize=(4.0 * len(_QUANTITIES), 2.4 * len(joints) + 0.4), layout="constrained")
    panels = figure.subplots(len(joints), len(_QUANTITIES), squeeze=False, sharex=True)
    for line, joint in zip(panels, joints, strict=True):
        for axes, (quantity, unit) in zip(line, _QUANTITIES.items(), strict=True):
            for row in rows:
                values = np.array(row["course"][quantity])[:, joint - 1]
                style = _STYLES[row["method"]]
                axes.plot(row["course"]["time"], values, **style, label=row["method"])
            axes.set_ylabel(f"joint {joint}, {unit}")
    for axes, quantity in zip(panels[0], _QUANTITIES, strict=True):
        axes.set_title(quantity)
    for axes in panels[-1]:
        axes.set_xlabel("time in s")
    panels[0, 0].legend(fontsize=7)
    return figure


def _condition_figure(config: Any, rows: list[Row]) -> Figure:
    figure = Figure(figsize=(4.5 * len(config.approaches), 3.2), layout="constrained")
    panels = figure.subplots(1, len(config.approaches), squeeze=False).ravel()
    for axes, number in zip(panels, config.approaches, strict=True):
        for row in selected(rows, approach=number):
            style = _STYLES[row["method"]]
            axes.semilogy(
                row["course"]["time"], row["course"]["condition"], **style, label=row["method"]
            )
        for threshold in (8.0, 10.0):
            axes.axhline(threshold, color="0.5", linewidth=0.8, linestyle="--")
        axes.set_title(f"approach {number}: {APPROACHES[number].title}")
        axes.set_xlabel("time in s")
    panels[0].set_ylabel("condition number, SI units")
    panels[0].legend(fontsize=7)
    return figure


def _sweep_figure(config: Any, rows: list[Row]) -> Figure:
    """Peak speed and error over lambda, or over the square root of a constant alpha."""
    figure = Figure(figsize=(4.5 * len(config.approaches), 5.6), layout="constrained")
    panels = figure.subplots(2, len(config.approaches), squeeze=False, sharex=True)
    for column, number in zip(panels.T, config.approaches, strict=True):
        own = selected(rows, approach=number)
        for gain, marker in ((0.0, "o"), (0.5, "s")):
            with_gain = selected(own, nullspace_gain=gain)
            task = "with" if gain else "without"
            for name, line in (("lambda", _led(with_gain)), ("sqrt(alpha)", _constant(with_gain))):
                label = f"{name}, {task} secondary task"
                dampings = [damping for damping, _ in line]
                speeds = [row["peak_share_of_velocity_limit"] for _, row in line]
                errors = [1e3 * row["largest_error_m"] for _, row in line]
                column[0].loglog(dampings, speeds, marker + "-", markersize=3, label=label)
                column[1].loglog(dampings, errors, marker + "-", markersize=3)
        column[0].axhline(1.0, color="0.5", linewidth=0.8, linestyle="--")
        column[0].set_title(f"approach {number}: {APPROACHES[number].title}")
        column[1].set_xlabel("damping, m per rad")
    panels[0, 0].set_ylabel("peak speed / limit")
    panels[1, 0].set_ylabel("largest error in mm")
    panels[0, 0].legend(fontsize=7)
    return figure


def _led(rows: list[Row]) -> list[tuple[float, Row]]:
    """Rows with a damping that depends on the condition number, without alpha."""
    return [(row["damping"], row) for row in rows if row["alpha"] == 0.0 and row["damping"] > 0.0]


def _constant(rows: list[Row]) -> list[tuple[float, Row]]:
    return [(float(np.sqrt(row["alpha"])), row) for row in rows if row["alpha"] > 0.0]

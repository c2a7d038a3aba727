"""Table and figures of the simulation study."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from scipy.stats import mannwhitneyu, spearmanr

from leadthrough.drawing import palette
from leadthrough.show import simulation_parts
from leadthrough.simulation import PositionServo, simulate
from leadthrough_studies.simulation.motions import given
from leadthrough_studies.simulation.stability import MEASURES
from leadthrough_studies.study import Report, Row, selected

_COLOURS = (palette.BLUE, palette.VERMILION, palette.GREEN, palette.PINK, palette.AMBER)
_FEWEST = 4
_MIN_ERROR = 1e-3  # mrad; below, the theory expects none


def report(config: Any, rows: list[Row]) -> Report:
    """Settings and faults in a table, the rest in the summary, the figures and a page."""
    sound, faults = selected(rows, study="sound"), selected(rows, study="fault")
    conditioned = selected(rows, study="conditioning")
    natural = selected(rows, study="naturalness")
    table = [_setting(sound, name) for name in dict.fromkeys(row["setting"] for row in sound)]
    table += [_fault(faults, name) for name in dict.fromkeys(row["fault"] for row in faults)]
    figures = {"errors": _errors_figure(sound)} if sound else {}
    if conditioned:
        figures["conditioning"] = _conditioning_figure(conditioned)
    if natural:
        figures["naturalness"] = _naturalness_figure(natural)
    pace = [row["part_of_real_time"] for row in sound if "part_of_real_time" in row]
    summary = {
        "refused": selected(rows, study="refused"),
        "not_fit": [row for row in sound if not row["fit_to_run"]],
        "missed": [row for row in faults if row.get("found") == 0],
        "largest_part_of_real_time": max(pace, default=None),
        "conditioning": _correlations(conditioned),
        "naturalness": _compared(natural),
    }
    return Report(table=table, figures=figures, summary=summary, pages=_pages(config))


def _pages(config: Any) -> dict[str, list[str]]:
    """The first motion of the first source with a position servo: simulated beside planned."""
    made = given(next(iter(config.motions)), 0, config.seed)
    if isinstance(made, str):
        return {}
    shown = simulate(made.arm, made.joints, controller=PositionServo())
    return {"simulated": simulation_parts(shown)}


def _setting(rows: list[Row], name: str) -> Row:
    own = selected(rows, setting=name)
    told = [row for row in own if row["expected_mrad"] > _MIN_ERROR]
    ratios = [row["joint_error_mrad"] / row["expected_mrad"] for row in told]
    return {
        "what": name,
        "motions": len(own),
        "as_it_should_be": sum(row["fit_to_run"] for row in own),
        "most_torque_percent": max(row["torque_percent"] for row in own),
        "median_error_mrad": float(np.median([row["joint_error_mrad"] for row in own])),
        "most_of_allowed": max(row["of_allowed"] for row in own),
        "least_over_theory": min(ratios, default=None),
        "most_over_theory": max(ratios, default=None),
        "median_tip_error_mm": float(np.median([row["tip_error_mm"] for row in own])),
    }


def _fault(rows: list[Row], name: str) -> Row:
    own = selected(rows, fault=name, is_one=1)
    empty = ("most_torque_percent", "median_error_mrad", "most_of_allowed", "least_over_theory")
    return {
        "what": name,
        "motions": len(own),
        "as_it_should_be": sum(row["found"] for row in own),
        **dict.fromkeys((*empty, "most_over_theory", "median_tip_error_mm")),
    }


def _correlations(rows: list[Row]) -> list[Row]:
    """Spearman's rank correlation of the largest condition number with each measure.

    Settings that lead to the same motion count once; of fewer than four there is no correlation.
    """
    found = []
    for number in dict.fromkeys(row["approach"] for row in rows):
        own = selected(rows, approach=number)
        for measure in MEASURES:
            pairs = {(round(row["largest_condition"], 2), round(row[measure], 2)) for row in own}
            labels = {"approach": number, "measure": measure, "motions": len(pairs)}
            correlation: Row = {"rank_correlation": None, "p": None}
            if len(pairs) >= _FEWEST:
                rank = spearmanr(*zip(*sorted(pairs), strict=True))
                correlation = {"rank_correlation": float(rank.statistic), "p": float(rank.pvalue)}
            found.append({**labels, **correlation})
    return found


def _compared(rows: list[Row]) -> list[Row]:
    """Medians of people and of damped least squares, and the Mann-Whitney test between them."""
    found = []
    for learned in (0, 1) if rows else ():
        for measure in MEASURES:
            pair = [
                [row[measure] for row in selected(rows, source=source, learned=learned)]
                for source in ("human", "DLS-IK")
            ]
            medians = {"human": float(np.median(pair[0])), "dls_ik": float(np.median(pair[1]))}
            p = _number(mannwhitneyu(*pair).pvalue)
            found.append({"learned": learned, "measure": measure, **medians, "p": p})
    return found


def _number(value: float) -> float | None:
    """None where there were too few motions for a number."""
    return float(value) if np.isfinite(value) else None


def _errors_figure(rows: list[Row]) -> Figure:
    """The simulated error over the one that the theory expects."""
    figure = Figure(figsize=(6.0, 5.0), layout="constrained")
    axes = figure.subplots()
    settings = dict.fromkeys(row["setting"] for row in rows)
    for setting, colour in zip(settings, _COLOURS, strict=False):
        own = [row for row in selected(rows, setting=setting) if row["expected_mrad"] > _MIN_ERROR]
        if own:
            expected = [row["expected_mrad"] for row in own]
            errors = [row["joint_error_mrad"] for row in own]
            axes.loglog(expected, errors, ".", color=colour, label=setting)
    ends = np.array(axes.get_xlim())
    axes.plot(ends, ends, color=palette.GREY, linewidth=0.8)
    axes.set(xlabel="largest error by theory in mrad", ylabel="simulated, in mrad")
    axes.legend(fontsize=8)
    return figure


def _conditioning_figure(rows: list[Row]) -> Figure:
    figure = Figure(figsize=(9.0, 3.4), layout="constrained")
    panels = figure.subplots(1, 3)
    for axes, measure in zip(panels, MEASURES, strict=False):
        for number, colour in zip((1, 2), _COLOURS, strict=False):
            own = selected(rows, approach=number)
            x, y = ([row[name] for row in own] for name in ("largest_condition", measure))
            axes.loglog(x, y, ".", color=colour, label=f"approach {number}")
        axes.set(xlabel="largest condition number", title=measure.replace("_", " "))
    panels[0].legend(fontsize=8)
    return figure


def _naturalness_figure(rows: list[Row]) -> Figure:
    figure = Figure(figsize=(9.0, 3.4), layout="constrained")
    for axes, measure in zip(figure.subplots(1, len(MEASURES)), MEASURES, strict=True):
        groups = [("human", 0), ("human", 1), ("DLS-IK", 0), ("DLS-IK", 1)]
        values = [
            [row[measure] for row in selected(rows, source=source, learned=learned)]
            for source, learned in groups
        ]
        axes.boxplot(values)
        names = [f"{source}\n{'learned' if learned else 'shown'}" for source, learned in groups]
        axes.set_xticks(range(1, 5), names, fontsize=6)
        axes.set_title(measure.replace("_", " "), fontsize=8)
    return figure

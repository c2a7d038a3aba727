"""Figures of the agriculture study, after those of Lauretti et al. 2023."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from leadthrough import rotations
from leadthrough.check import Float64Array
from leadthrough.experiments.agriculture_measures import from_goal
from leadthrough.experiments.study import Row, selected
from leadthrough.motion import PoseTrajectory
from leadthrough.show import plot

_COLORS = {"euler": "tab:orange", "log": "tab:red", "lifted": "tab:green", "anchored": "tab:blue"}
_TITLES = {
    "euler": "Euler angles ZYZ",
    "log": "plain logarithm",
    "lifted": "dynamic parameterisation",
    "anchored": "anchored",
}
_TURN_SAMPLES = 801


def figures(config: Any, rows: list[Row]) -> dict[str, Figure]:
    """By file stem: the parameterisation (2 and 3), the measures (7), subtask 4-4 (8 to 10)."""
    drawn = {"parameterisation": _parameterisation()}
    if rows:
        drawn["measures"] = _measures(config, rows)
    courses = [row for row in rows if "course" in row]
    if courses:
        drawn["subtask_4_4"] = _courses(config, courses)
    return drawn


def _parameterisation() -> Figure:
    """Two turns about the diagonal: the logarithm in the branches k = 0, 1, 2, and lifted."""
    angles = np.linspace(0.0, 4.0 * np.pi, _TURN_SAMPLES)
    turned = rotations.exp(np.outer(angles, np.ones(3) / np.sqrt(3.0)))
    branches = _branches(rotations.log(turned), 2)
    lifted = rotations.lift(turned)
    figure = Figure(figsize=(9.0, 3.4), layout="constrained")
    panels = figure.subplots(1, 2)
    for axes, draw, label in (
        (panels[0], _first, r"$\phi_1$, rad"),
        (panels[1], _norm, r"$\|\phi\|$, rad"),
    ):
        for k, branch in enumerate(branches):
            axes.plot(angles / np.pi, draw(branch), ".", markersize=2, label=f"k = {k}")
        axes.plot(angles / np.pi, draw(lifted), color="black", linewidth=1, label="lifted")
        axes.set_xlabel(r"angle turned, $\pi$ rad")
        axes.set_ylabel(label)
    panels[0].legend(fontsize=8)
    return figure


def _first(phi: Float64Array) -> Float64Array:
    return phi[:, 0]


def _norm(phi: Float64Array) -> Float64Array:
    return np.asarray(np.linalg.norm(phi, axis=1))


def _branches(phi: Float64Array, last: int) -> list[Float64Array]:
    """The logarithm (n, 3) and its parameterisations up to k: eq. 9 with v_0 = 1."""
    branches = [phi]
    for k in range(1, last + 1):
        norms = np.linalg.norm(branches[-1], axis=1, keepdims=True)
        # At no rotation there is no axis to turn back about: the sample is left out.
        norms[norms < 1e-9] = np.nan
        branches.append(branches[-1] * (1.0 - 2.0 * k * np.pi / norms))
    return branches


def _measures(config: Any, rows: list[Row]) -> Figure:
    """NPE and NOE, mean and spread, and SR-MOD, by task and planner."""
    figure = Figure(figsize=(11.0, 3.4), layout="constrained")
    width = 0.8 / len(config.planners)
    for axes, column, title in zip(
        figure.subplots(1, 3),
        ("npe", "noe", "succeeded"),
        ("NPE", "NOE", "SR-MOD, %"),
        strict=True,
    ):
        for i, planner in enumerate(config.planners):
            values = [_column(rows, task, planner, column) for task in config.tasks]
            places = np.arange(len(config.tasks)) + (i + 0.5) * width - 0.4
            means = [np.mean(each) if each else np.nan for each in values]
            spread = [np.std(each) if each else np.nan for each in values]
            bars = None if column == "succeeded" else spread
            style = {"color": _COLORS[planner], "label": planner, "capsize": 2}
            axes.bar(places, means, width, yerr=bars, **style)
        axes.set_xticks(range(len(config.tasks)), config.tasks, fontsize=8)
        axes.set_title(title, fontsize=10)
        axes.set_ylim(bottom=0.0)
    figure.axes[0].legend(fontsize=8)
    return figure


def _column(rows: list[Row], task: str, planner: str, column: str) -> list[float]:
    scale = 100.0 if column == "succeeded" else 1.0
    own = selected(rows, task=task, planner=planner)
    return [scale * row[column] for row in own if row.get(column) is not None]


def _courses(config: Any, rows: list[Row]) -> Figure:
    """Subtask 4-4 for one target, recorded and made, in each planner's own coordinates."""
    repetition = _most_telling(rows)
    figure = Figure(figsize=(10.0, 2.2 * len(config.planners)), layout="constrained")
    lines = figure.subplots(len(config.planners), 3, squeeze=False, sharex=True)
    for line, planner in zip(lines, config.planners, strict=True):
        for row in selected(rows, planner=planner, repetition=repetition):
            recorded, made = (
                _coordinates(np.array(row["course"][name]), planner)
                for name in ("recorded", "made")
            )
            share = np.linspace(0.0, 1.0, len(recorded))
            for i, axes in enumerate(line):
                axes.plot(share, recorded[:, i], **plot.DEMONSTRATION, label="recorded")
                axes.plot(share, made[:, i], color=_COLORS[planner], linewidth=1.2, label="made")
        line[0].set_ylabel(f"{_TITLES[planner]}\nrad", fontsize=8)
        line[0].legend(fontsize=7)
    for axes in lines[-1]:
        axes.set_xlabel("share of the duration")
    return figure


def _most_telling(rows: list[Row]) -> int:
    """The target where a planner went farthest from the recording, of those that all drew."""
    return int(max(rows, key=lambda row: row["largest_deg"])["repetition"])


def _coordinates(orientations: Float64Array, planner: str) -> Float64Array:
    if planner == "euler":
        return rotations.to_euler(orientations, convention="ZYZ")
    times = np.arange(len(orientations), dtype=np.float64)
    away = from_goal(PoseTrajectory(times, np.zeros((len(times), 3)), orientations))
    return rotations.log(away) if planner == "log" else rotations.lift(away, anchor="goal")

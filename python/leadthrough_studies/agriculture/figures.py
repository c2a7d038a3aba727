"""Figures of the agriculture study, after those of Lauretti et al. 2023."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from leadthrough import rotations
from leadthrough.check import Float64Array
from leadthrough.motion import PoseTrajectory
from leadthrough.show.plot import Style
from leadthrough_studies.agriculture import targets_figure
from leadthrough_studies.agriculture.measures import from_goal
from leadthrough_studies.agriculture.measures_figure import COLORS, measures
from leadthrough_studies.study import Row, selected

_TITLES = {
    "euler": "Euler angles ZYZ",
    "log": "plain logarithm",
    "lifted": "dynamic parameterisation",
    "lauretti": "Lauretti et al.",
    "anchored": "anchored",
}
_ANGLES = (r"$\alpha$", r"$\beta$", r"$\gamma$")
_COORDINATES = (r"$\phi_1$", r"$\phi_2$", r"$\phi_3$")
_TURN_SAMPLES = 801
_RECORDED: Style = {"color": "0.75", "linewidth": 4.0}


def draw(
    config: Any, subtasks: list[Row], wholes: list[Row], tests: list[Row]
) -> dict[str, Figure]:
    """The figures by file stem: those of the paper, and whole tasks on the arm.

    Args:
        config: the configuration of the study.
        subtasks: rows of the subtasks.
        wholes: rows of the whole tasks.
        tests: rows of the tests on pairs of planners.

    Returns:
        "parameterisation" (figures 2 and 3), "targets" (4), "measures" (7), "subtask_4_4" (8 to
        10) and "whole_tasks"; those without rows are left out.
    """
    drawn = {"parameterisation": _parameterisation(), "targets": targets_figure.draw(config.tasks)}
    if subtasks:
        drawn["measures"] = measures(config, subtasks, tests)
    courses = [row for row in subtasks if "course" in row]
    if courses:
        drawn["subtask_4_4"] = _courses(config, courses)
    default = selected(wholes, planner=config.planners[-1])
    on_the_arm = [row for row in default if "joints" in row]
    if on_the_arm:
        drawn["whole_tasks"] = _whole_tasks(on_the_arm)
    return drawn


def _parameterisation() -> Figure:
    """Two turns about the diagonal: branches k = 0, 1, 2 of the logarithm, and the lifted one."""
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
    panels[0].legend(fontsize=8, loc="lower right", markerscale=4)
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
        # The identity has no rotation axis: the sample is left out.
        norms[norms < 1e-9] = np.nan
        branches.append(branches[-1] * (1.0 - 2.0 * k * np.pi / norms))
    return branches


def _courses(config: Any, rows: list[Row]) -> Figure:
    """Subtask 4-4 for one target, recorded and generated, in each planner's coordinates."""
    repetition = _most_telling(rows)
    figure = Figure(figsize=(10.0, 2.2 * len(config.planners)), layout="constrained")
    lines = figure.subplots(len(config.planners), 3, squeeze=False, sharex=True)
    for line, planner in zip(lines, config.planners, strict=True):
        names = _ANGLES if planner == "euler" else _COORDINATES
        for row in selected(rows, planner=planner, repetition=repetition):
            recorded, made = (
                _coordinates(np.array(row["course"][name]), planner)
                for name in ("recorded", "made")
            )
            fraction = np.linspace(0.0, 1.0, len(recorded))
            for i, axes in enumerate(line):
                axes.plot(fraction, recorded[:, i], **_RECORDED, label="recorded")
                axes.plot(fraction, made[:, i], color=COLORS[planner], linewidth=1.2, label="made")
                axes.set_title(names[i], fontsize=9, loc="left")
        line[0].set_ylabel(f"{_TITLES[planner]}\nrad", fontsize=8)
        line[0].legend(fontsize=7)
    for axes in lines[-1]:
        axes.set_xlabel("fraction of the duration")
    return figure


def _whole_tasks(rows: list[Row]) -> Figure:
    """The joints of the arm in whole tasks, slowed down to its limits, with the gripper's events.

    Each joint is drawn as a fraction of its range.
    """
    figure = Figure(figsize=(10.0, 2.0 * len(rows)), layout="constrained")
    panels = figure.subplots(len(rows), 1, squeeze=False)[:, 0]
    for axes, row in zip(panels, rows, strict=True):
        joints = row["joints"]
        lower, upper = np.array(joints["lower"]), np.array(joints["upper"])
        fractions = (np.array(joints["positions"]) - lower) / (upper - lower)
        for i, column in enumerate(fractions.T):
            axes.plot(joints["times"], column, linewidth=1.2, label=f"joint {i + 1}")
        for event in row["gripper"]:
            axes.axvline(event["time_s"], color="black", linewidth=1.0, linestyle=":")
            place = {"xy": (event["time_s"], 1.02), "xycoords": ("data", "axes fraction")}
            axes.annotate(event["does"], **place, ha="center", fontsize=8)
        axes.set_title(f"{row['task']}, {row['where']}", fontsize=9, loc="left")
        axes.set_ylim(0.0, 1.0)
        axes.set_ylabel("fraction of the range", fontsize=8)
        axes.set_xlim(joints["times"][0], joints["times"][-1])
    handles, names = panels[0].get_legend_handles_labels()
    figure.legend(handles, names, fontsize=8, ncols=len(names), loc="outside lower center")
    panels[-1].set_xlabel("time, s")
    return figure


def _most_telling(rows: list[Row]) -> int:
    """The number of the target with the largest orientation error of any planner."""
    return int(max(rows, key=lambda row: row["largest_deg"])["repetition"])


def _coordinates(orientations: Float64Array, planner: str) -> Float64Array:
    if planner == "euler":
        return rotations.to_euler(orientations, convention="ZYZ")
    times = np.arange(len(orientations), dtype=np.float64)
    away = from_goal(PoseTrajectory(times, np.zeros((len(times), 3)), orientations))
    return rotations.log(away) if planner == "log" else rotations.lift(away, anchor="goal")

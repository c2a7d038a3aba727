"""The places that the tasks lead to, after figure 4 of Lauretti et al. 2023."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from leadthrough.arm import Arm
from leadthrough.check import Float64Array
from leadthrough_studies.agriculture.tasks import (
    ARM_BASE,
    POSTURES,
    TASKS,
    Turned,
    load_arm,
    targets,
)

_FRAME = 0.15  # m, length of the drawn axes


def draw(tasks: Sequence[str]) -> Figure:
    """The nine targets of each task in red, the first in green, all other stops in black.

    Args:
        tasks: keys of TASKS.
    """
    arm = load_arm()
    figure = Figure(figsize=(3.6 * len(tasks), 3.6), layout="constrained")
    for i, task in enumerate(tasks, start=1):
        axes: Any = figure.add_subplot(1, len(tasks), i, projection="3d")
        places = targets(task)
        stops = _stops(arm, task)
        axes.plot(*places.T, "o", color="red", markersize=4, label="targets")
        axes.plot(*places[:1].T, "o", color="green", markersize=6, label="the first one")
        axes.plot(*np.array(list(stops.values())).T, "o", color="black", markersize=4)
        for name, place in stops.items():
            axes.text(*place, f" {name}", fontsize=6)
        _frame(axes)
        axes.set_title(f"({'abcd'[i - 1]}) {task}" if len(tasks) <= 4 else task, fontsize=9)
        axes.set_box_aspect(_extents(axes))
        axes.tick_params(labelsize=5)
        for name in "xyz":
            getattr(axes, f"set_{name}label")(f"{name}, m", fontsize=7)
        if i == 1:
            axes.legend(fontsize=6)
    return figure


def _stops(arm: Arm, task: str) -> dict[str, Float64Array]:
    """Positions of the tool at the stops that are the same in every repetition, by name."""
    stops = (stop for subtask in TASKS[task] for stop in subtask.stops)
    names = (stop.posture if isinstance(stop, Turned) else stop for stop in stops)
    known = dict.fromkeys(name for name in names if name in POSTURES)
    return {name: arm.forward_kinematics(np.array(POSTURES[name]))[0] for name in known}


def _frame(axes: Any) -> None:
    """The frame of the arm's base, from which the paper states its first targets."""
    for axis, color in zip(np.eye(3), ("tab:red", "tab:green", "tab:blue"), strict=True):
        axes.plot(*np.array([ARM_BASE, ARM_BASE + _FRAME * axis]).T, color=color, linewidth=1.5)


def _extents(axes: Any) -> list[float]:
    return [float(np.ptp(getattr(axes, f"get_{name}lim")())) for name in "xyz"]

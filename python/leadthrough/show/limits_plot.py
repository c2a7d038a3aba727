"""Figures of a motion beside its limits: shares of them over time, and the phase plane."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from leadthrough.arm.limits import JointLimits
from leadthrough.check import Float64Array
from leadthrough.motion import JointTrajectory
from leadthrough.show import palette, style

_LIMIT: dict[str, Any] = {"color": palette.VERMILION, "linewidth": 0.8, "linestyle": "--"}


@style.applied()
def limits_figure(trajectory: JointTrajectory, limits: JointLimits) -> Figure:
    """Position, velocity, acceleration and jerk of all joints over time, as shares of their limits.

    Derivatives are differences of the samples, so that what is drawn is what a controller sees.
    """
    figure = Figure(figsize=(9.0, 7.5), layout="constrained")
    panels = figure.subplots(4, 1, sharex=True)
    middle, half = 0.5 * (limits.lower + limits.upper), 0.5 * (limits.upper - limits.lower)
    rates = (limits.velocity, limits.acceleration, limits.jerk)
    _draw_shares(panels[0], trajectory.times, (trajectory.positions - middle) / half, "position")
    for order, (axes, limit) in enumerate(zip(panels[1:], rates, strict=True), 1):
        times, values = _differences(trajectory, order)
        name = ("velocity", "acceleration", "jerk")[order - 1]
        _draw_shares(axes, times, values / (np.inf if limit is None else limit), name)
    names = trajectory.joint_names or [f"joint {j + 1}" for j in range(len(middle))]
    panels[0].legend(panels[0].lines[: len(middle)], names, fontsize=7, ncols=4, loc="upper right")
    panels[-1].set_xlabel("time in s")
    return figure


def draw_phase_plane(axes: Axes, positions: Float64Array, velocities: Float64Array) -> None:
    """Velocity over position of motions (n, k) that are to come to rest at zero."""
    axes.plot(positions, velocities, linewidth=1.0)
    axes.plot(0.0, 0.0, "ko", markersize=4)
    axes.set_xlabel("position")
    axes.set_ylabel("velocity")


def _draw_shares(axes: Axes, times: Float64Array, shares: Float64Array, name: str) -> None:
    axes.plot(times, shares, linewidth=1.0)
    for limit in (-1.0, 1.0):
        axes.axhline(limit, **_LIMIT)
    axes.set_ylabel(f"{name}\nof its limit")
    axes.set_ylim(-1.15, 1.15)


def _differences(trajectory: JointTrajectory, order: int) -> tuple[Float64Array, Float64Array]:
    times, values = trajectory.times, trajectory.positions
    for _ in range(order):
        values = np.diff(values, axis=0) / np.diff(times)[:, None]
        times = 0.5 * (times[1:] + times[:-1])
    return times, values

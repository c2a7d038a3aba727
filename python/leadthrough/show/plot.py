"""Figures with matplotlib, without a display: each function draws into axes or a figure given."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from leadthrough.arm.limits import JointLimits
from leadthrough.check import Float64Array
from leadthrough.models.marching.model import FastMarchingSkill
from leadthrough.motion import JointTrajectory, Trajectory
from leadthrough.shapes import Box
from leadthrough.show import palette, style

Style = dict[str, Any]

DEMONSTRATION: Style = {"color": palette.DEMONSTRATION, "linewidth": 0.8}
HELD_OUT: Style = {"color": palette.BLACK, "linewidth": 1.0, "linestyle": (0, (4, 2))}
PATH: Style = {"color": palette.PATH, "linewidth": 1.6}
DETOUR: Style = {"color": palette.DETOUR, "linewidth": 1.6}
LIMIT: Style = {"color": palette.VERMILION, "linewidth": 0.8, "linestyle": "--"}
OBSTACLE: Style = {"facecolor": palette.OBSTACLE, "edgecolor": "none"}


def draw_velocity_map(axes: Axes, skill: FastMarchingSkill) -> None:
    """The velocity map of a skill of two dimensions, bright where it is fast."""
    lower = skill.grid.origin - 0.5 * skill.grid.spacing
    upper = lower + skill.grid.spacing * np.array(skill.grid.shape)
    axes.imshow(
        skill.velocity_map.T,
        origin="lower",
        extent=(lower[0], upper[0], lower[1], upper[1]),
        cmap="YlGnBu_r",
        vmin=-0.6,
        vmax=1.0,
        alpha=0.55,
    )
    axes.set_aspect("equal")


def draw_paths(axes: Axes, paths: Sequence[Float64Array], style: Style, *, label: str) -> None:
    """The first two coordinates of paths (n, d) in one style, with one entry in the legend."""
    for i, path in enumerate(paths):
        axes.plot(path[:, 0], path[:, 1], **style, label=label if i == 0 else None)


def draw_box(axes: Axes, box: Box) -> None:
    """The footprint of a box whose edges are parallel to the axes."""
    corner = box.position[:2] - 0.5 * box.size[:2]
    axes.add_patch(Rectangle((corner[0], corner[1]), box.size[0], box.size[1], **OBSTACLE))


def draw_speed(axes: Axes, motion: Trajectory, style: Style, *, label: str) -> None:
    """Speed along a motion over time."""
    speed = np.linalg.norm(np.gradient(motion.positions, motion.times, axis=0), axis=1)
    axes.plot(motion.times, speed, **style, label=label)
    axes.set_xlabel("time in s")


@style.applied()
def joint_figure(trajectory: JointTrajectory, limits: JointLimits) -> Figure:
    """Positions and velocities of all joints over time, with their limits dashed."""
    joints = trajectory.positions.shape[1]
    figure = Figure(figsize=(9.0, 1.3 * joints + 0.8), layout="constrained")
    grid = figure.subplots(joints, 2, sharex=True, squeeze=False)
    velocities = trajectory.velocities
    if velocities is None:
        velocities = np.gradient(trajectory.positions, trajectory.times, axis=0)
    for j, (left, right) in enumerate(grid):
        left.plot(trajectory.times, trajectory.positions[:, j], **PATH)
        right.plot(trajectory.times, velocities[:, j], **PATH)
        _draw_limits(left, limits.lower[j], limits.upper[j])
        _draw_limits(right, -limits.velocity[j], limits.velocity[j])
        left.set_ylabel(trajectory.joint_names[j] if trajectory.joint_names else f"joint {j + 1}")
        left.yaxis.label.set_fontsize(8)
    grid[0, 0].set_title("position in rad, limits dashed")
    grid[0, 1].set_title("velocity in rad/s, limits dashed")
    for axes in grid[-1]:
        axes.set_xlabel("time in s")
    return figure


def _draw_limits(axes: Axes, lower: float, upper: float) -> None:
    for limit in (lower, upper):
        if np.isfinite(limit):
            axes.axhline(limit, **LIMIT)

"""The panels of motions: where they go, and what they do over time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from leadthrough.drawing.panels import Numbers, Panel, over, paths
from leadthrough.events import Events


def of_points(
    times: Numbers,
    positions: Numbers,
    events: Events,
    *,
    deviations: Numbers | None = None,
    unit: str = "",
) -> list[Panel]:
    """Points (n, d): their path where it lies in a plane or in space, and each over time."""
    size = positions.shape[1]
    names = "xyz"[:size] if size <= 3 else [str(i + 1) for i in range(size)]
    title = f"position in {unit}" if unit else "position"
    along = over(times, positions, names, title=title, marks=marks(events), deviations=deviations)
    return [paths([positions], title="path"), along] if size in (2, 3) else [along]


def of_poses(
    times: Numbers,
    positions: Numbers,
    orientations: Numbers,
    events: Events,
    *,
    deviations: Numbers | None = None,
) -> list[Panel]:
    """Poses: the path, and position and quaternion over time."""
    turned = over(times, orientations, "wxyz", title="orientation, a quaternion")
    return [*of_points(times, positions, events, unit="m", deviations=deviations), turned]


def of_joints(
    times: Numbers,
    positions: Numbers,
    velocities: Numbers | None,
    names: Sequence[str],
    events: Events,
    *,
    deviations: Numbers | None = None,
) -> list[Panel]:
    """Joints: positions and velocities, which are differences where the motion has none."""
    called = names or [f"joint {i + 1}" for i in range(positions.shape[1])]
    if velocities is None:
        several = len(times) > 1
        velocities = np.gradient(positions, times, axis=0) if several else 0.0 * positions
    at = over(
        times, positions, called, title="joint positions in rad (m)", marks=marks(events),
        deviations=deviations,
    )  # fmt: skip
    return [at, over(times, velocities, called, title="joint velocities in rad/s (m/s)")]


def marks(events: Events) -> list[tuple[float, str]]:
    """Vertical lines at events."""
    return [(event.time, event.name) for event in events]

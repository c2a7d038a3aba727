"""Commanded positions as joint trajectories."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.events import Event
from leadthrough.motion import JointTrajectory, computed_joints


def trajectories(
    history: Float64Array,
    rows: Float64Array,
    kept: int,
    *,
    names: tuple[str, ...],
    start: float,
    period: float,
    events: tuple[Event, ...] = (),
) -> tuple[JointTrajectory, JointTrajectory]:
    """The kept rows, and those after them; the last row where there is none.

    Velocities are central differences, so that they and the accelerations are inside limits that
    the differences of the positions keep.

    Args:
        history: (k, joints), the commands before.
        rows: (n, joints), n > 0, to rest.
        kept: how many belong to the first trajectory, > 0.
        names: of the joints.
        start: time of the first row, s.
        period: between rows, s.
        events: of the first trajectory.
    """
    around = np.concatenate([history[-1:], rows, rows[-1:]])
    velocities = (around[2:] - around[:-2]) / (2.0 * period)
    accelerations = np.diff(around, 2, axis=0) / period**2
    times = start + period * np.arange(len(rows) + 1, dtype=np.float64)
    after = slice(kept, None) if kept < len(rows) else slice(len(rows) - 1, None)
    first = times[:kept]
    then = times[kept : kept + max(1, len(rows) - kept)]
    motion = computed_joints(
        first,
        rows[:kept],
        velocities[:kept],
        accelerations[:kept],
        joint_names=names,
        events=events,
    )
    brake = computed_joints(
        then, rows[after], velocities[after], accelerations[after], joint_names=names
    )
    return motion, brake


def from_state(
    before: Float64Array,
    rows: Float64Array,
    *,
    names: tuple[str, ...],
    period: float,
    events: tuple[Event, ...] = (),
) -> JointTrajectory:
    """The motion of commands, the first of which is the present one, at time 0."""
    motion, _ = trajectories(
        before[None], rows, len(rows), names=names, start=0.0, period=period, events=events
    )
    assert motion.velocities is not None
    velocities = motion.velocities.copy()
    velocities[0] = (rows[0] - before) / period  # as commanded, and zero for an arm at rest
    return replace(motion, velocities=velocities)


def moved_events(
    events: tuple[Event, ...], places: Float64Array, *, start: float, period: float
) -> tuple[Event, ...]:
    """Events at the first row that has come to their place on the chunk; without those cut off."""
    moved = []
    for event in events:
        reached = places >= (event.time - start) / period - 1e-9
        if reached.any():
            moved.append(Event(start + period * int(np.argmax(reached)), event.name))
    return tuple(moved)

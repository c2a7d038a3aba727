"""The methods that the study of RoboTasks compares; another joins with one line in `METHODS`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib.util import find_spec
from typing import Any, Protocol

import numpy as np

from leadthrough import rotations
from leadthrough.check import Float64Array
from leadthrough.models import DMP, GMR, FastMarching, ProMP, TaskGMR
from leadthrough.motion import Demonstration, PoseTrajectory
from leadthrough.preprocess.resample import arc_length

Pose = tuple[Float64Array, Float64Array]
Shown = Sequence[Demonstration[PoseTrajectory]]
Method = Callable[[Shown, Pose, Pose], PoseTrajectory]

# Kernels per dimension of the peer's primitive, as of our own.
_WEIGHTS = 50


class _Model(Protocol):
    def fit(self, demonstrations: Shown) -> Any: ...


def generated_by(model: _Model) -> Method:
    """The method that fits a model and generates a motion between the poses asked for."""

    def reproduce(demonstrations: Shown, start: Pose, goal: Pose) -> PoseTrajectory:
        motion: PoseTrajectory = model.fit(demonstrations).generate(start=start, goal=goal)
        return motion

    return reproduce


def nearest_shifted(demonstrations: Shown, start: Pose, goal: Pose) -> PoseTrajectory:
    """The demonstration whose ends are nearest, carried to start and goal.

    The offsets of both ends fade with the fraction of the path covered, those of the orientation
    as rotation vectors in the base frame.
    """
    motion = nearest(demonstrations, start, goal)
    covered = arc_length(motion.positions)
    rise = (covered / covered[-1])[:, None]
    positions = (
        motion.positions
        + (1.0 - rise) * (start[0] - motion.positions[0])
        + rise * (goal[0] - motion.positions[-1])
    )
    turns = [
        rotations.log(rotations.compose(wanted[None], rotations.inverse(shown[None])))
        for wanted, shown in (
            (start[1], motion.orientations[0]),
            (goal[1], motion.orientations[-1]),
        )
    ]
    offsets = rotations.exp((1.0 - rise) * turns[0] + rise * turns[1])
    turned = rotations.compose(offsets, motion.orientations)
    return PoseTrajectory(motion.times, positions, rotations.align_signs(turned))


def nearest(demonstrations: Shown, start: Pose, goal: Pose) -> PoseTrajectory:
    """The motion whose first and last positions are nearest to those of start and goal."""

    def gap(motion: PoseTrajectory) -> float:
        ends = motion.positions[[0, -1]] - np.stack([start[0], goal[0]])
        return float(np.linalg.norm(ends, axis=1).sum())

    return min((each.motion for each in demonstrations), key=gap)


def peer_primitive(demonstrations: Shown, start: Pose, goal: Pose) -> PoseTrajectory:
    """The nearest demonstration, learned by the Cartesian primitive of movement_primitives."""
    from movement_primitives.dmp import CartesianDMP  # noqa: PLC0415 - an optional peer

    motion = nearest(demonstrations, start, goal)
    times = np.linspace(0.0, motion.duration, len(motion.times))
    step = times[1]
    poses = np.hstack([motion.positions, motion.orientations])
    primitive = CartesianDMP(motion.duration, step, n_weights_per_dim=_WEIGHTS)
    primitive.imitate(times, poses)
    primitive.configure(start_y=np.concatenate(start), goal_y=np.concatenate(goal))
    made_times, made = primitive.open_loop()
    unit = made[:, 3:] / np.linalg.norm(made[:, 3:], axis=1, keepdims=True)
    return PoseTrajectory(made_times, made[:, :3], rotations.align_signs(unit))


METHODS: dict[str, Method] = {
    "DMP": generated_by(DMP()),
    "ProMP": generated_by(ProMP()),
    "GMR": generated_by(GMR(components=8)),
    "TaskGMR": generated_by(TaskGMR()),
    "FastMarching": generated_by(FastMarching()),
    "Lauretti et al.": generated_by(DMP.lauretti()),
    "nearest demonstration, shifted": nearest_shifted,
}
if find_spec("movement_primitives"):
    METHODS["movement_primitives, nearest demonstration"] = peer_primitive

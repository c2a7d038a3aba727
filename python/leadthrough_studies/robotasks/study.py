"""The RoboTasks study: real kinesthetic demonstrations of poses, each left out in turn.

A method learns from the other demonstrations of a task as they were recorded, with their own
timing, and gets the start and goal pose of the left-out one. Its motion is compared with the left-
out demonstration at evenly spaced times: mean distance, mean angle, and the distance under dynamic
time warping, which ignores differences in timing. If a method refuses, as the planner of
Lauretti et al. does if a channel of the mean ends where it began, the row says why. Recordings:
Auddy et al. 2023, "Continual learning from demonstration of robotics skills", data set RoboTasks:
positions in cm, quaternions w, x, y, z, 10 s each.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from leadthrough import rotations
from leadthrough.errors import FitError, InvalidInput, UnsupportedQuery
from leadthrough.motion import Demonstration, PoseTrajectory
from leadthrough.preprocess import dtw_distance
from leadthrough_studies.robotasks.methods import METHODS, Shown
from leadthrough_studies.robotasks.report import report
from leadthrough_studies.study import Row, Study, Task

_FOLDER = "robotasks"
_DURATION = 10.0  # s
_EVERY = 5  # of 1,000 samples, far more than the motion of a hand needs
_COMPARED = 200  # number of evenly spaced times
# Number of positions of a path kept for the figures.
_DRAWN = 60


@dataclass(frozen=True)
class RoboTasksConfig:
    """The configuration of the study.

    Attributes:
        files: one file per task, with an array (demonstrations, samples, 7).
        methods: keys of METHODS.
        left_out: number of demonstrations of each task that are left out in turn; None for all.
        seed: recorded as in every study, but unused: there are no random numbers.
    """

    files: tuple[str, ...]
    methods: tuple[str, ...] = tuple(METHODS)
    left_out: int | None = None
    seed: int = 0


def configure(quick: bool, seed: int) -> RoboTasksConfig:
    """The configuration with all demonstrations in the folder of recordings, or two of each task.

    Raises:
        InvalidInput: if LEADTHROUGH_DATA names no folder with recordings.
    """
    folder = Path(os.environ.get("LEADTHROUGH_DATA", "")) / _FOLDER
    files = tuple(str(file) for file in sorted(folder.glob("*.npy")))
    if not files:
        raise InvalidInput(
            f"LEADTHROUGH_DATA: expected a folder with {_FOLDER}/*.npy, found none in {folder}"
        )
    return RoboTasksConfig(files, left_out=2 if quick else None, seed=seed)


def tasks(config: RoboTasksConfig) -> list[Task]:
    """A task for every recording and method."""
    return [
        Task(
            compare,
            {"task": Path(file).stem, "method": method, "left_out": config.left_out},
            {"file": Path(file)},
        )
        for file in config.files
        for method in config.methods
    ]


def compare(*, task: str, file: Path, method: str, left_out: int | None) -> list[Row]:
    """A row for every demonstration left out.

    Args:
        task: its name.
        file: its recordings.
        method: a name in METHODS.
        left_out: how many are left out, one after another; all where None.
    """
    shown = read(str(file))
    rows = []
    for i, tested in enumerate(shown[:left_out]):
        others = [each for j, each in enumerate(shown) if j != i]
        row = {"task": task, "method": method, "tested": i}
        rows.append({**row, **_errors(method, others, tested.motion)})
    return rows


def read(file: str) -> list[Demonstration[PoseTrajectory]]:
    """The demonstrations of a task, in m."""
    recorded = np.load(file, allow_pickle=False)[:, ::_EVERY]
    times = np.linspace(0.0, _DURATION, recorded.shape[1])
    return [
        Demonstration(PoseTrajectory(times, 0.01 * poses[:, :3], _unit(poses[:, 3:])))
        for poses in recorded
    ]


def _unit(quaternions: np.ndarray) -> np.ndarray:
    lengths = np.linalg.norm(quaternions, axis=1, keepdims=True)
    return rotations.align_signs(quaternions / lengths)


def _errors(method: str, shown: Shown, tested: PoseTrajectory) -> Row:
    ends = [(tested.positions[i], tested.orientations[i]) for i in (0, -1)]
    wanted, turned = _sampled(tested)
    drawn = {"shown": wanted[:: _COMPARED // _DRAWN].round(4).tolist()}
    try:
        made = METHODS[method](shown, ends[0], ends[1])
    except (FitError, UnsupportedQuery) as error:
        return {"refused": str(error), **drawn}
    positions, orientations = _sampled(made)
    apart = np.linalg.norm(positions - wanted, axis=1)
    angles = np.degrees(rotations.distance(orientations, turned))
    return {
        "mean_mm": 1e3 * float(apart.mean()),
        "DTW_mm": 1e3 * dtw_distance(positions, wanted) / _COMPARED,
        "mean_deg": float(angles.mean()),
        "largest_deg": float(angles.max()),
        "end_mm": 1e3 * float(apart[-1]),
        "duration_s": made.duration,
        "path": positions[:: _COMPARED // _DRAWN].round(4).tolist(),
        **drawn,
    }


def _sampled(motion: PoseTrajectory) -> tuple[np.ndarray, np.ndarray]:
    """Positions and orientations at evenly spaced fractions of the duration."""
    at = np.linspace(motion.times[0], motion.times[-1], _COMPARED)
    columns = [np.interp(at, motion.times, column) for column in motion.positions.T]
    turned = rotations.interpolate(motion.times, motion.orientations, at)
    return np.column_stack(columns), turned


STUDY = Study(configure, tasks, report)

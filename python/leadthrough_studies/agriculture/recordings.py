"""Motions of a real arm, cut from long recordings, learned and replayed by each planner.

They take 0.5 to 22 s. With 50 kernels, the motions of 20 s, which are the most complex, have errors
of up to 1.3 mm; with 4 kernels per second, but at least 50, all errors stay below 0.9 mm.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from leadthrough.errors import FitError, InvalidInput
from leadthrough.io import read_demonstrations
from leadthrough.models import DMP
from leadthrough.motion import Motion, PoseTrajectory
from leadthrough.preprocess import segment
from leadthrough_studies.agriculture.measures import judged
from leadthrough_studies.agriculture.planners import planner_of
from leadthrough_studies.study import Row, Task

_FOLDER = "panda_execution"
_RATE = 20.0  # Hz, of the recordings
WEIGHTS = {"50": 50, "by duration": None}
_COLUMNS = {
    "positions": [f"current_pos_{axis}" for axis in "xyz"],
    "orientations": [f"current_orientation_{axis}" for axis in "wxyz"],
}


def tasks(folder: str, planners: Sequence[str]) -> list[Task]:
    """A task for every recording, planner and number of kernels; no tasks without recordings."""
    files = sorted((Path(folder) / _FOLDER).glob("*.csv")) if folder else []
    return [
        Task(replay, {"file": str(file), "planner": planner, "weights": weights})
        for file in files
        for planner in planners
        for weights in WEIGHTS
    ]


def replay(*, file: str, planner: str, weights: str = "by duration") -> list[Row]:
    """A row for every motion of a recording: errors of the replayed motion.

    Args:
        file: path of the recording.
        planner: name in PLANNERS.
        weights: key of WEIGHTS.
    """
    recording = read_demonstrations([file], columns=_COLUMNS, rate=_RATE, rest=math.inf)[0]
    labels = {"study": "recordings", "file": Path(file).name, "planner": planner}
    labels |= {"weights": weights}
    model = planner_of(planner, weights=WEIGHTS[weights])
    return [
        {**labels, "motion": number} | _replayed(motion.motion, model)
        for number, motion in enumerate(segment(recording), start=1)
    ]


def _replayed(recorded: Motion, model: DMP) -> Row:
    assert isinstance(recorded, PoseTrajectory)
    try:
        skill = model.fit([recorded])
        made = skill.generate(dt=1.0 / _RATE)
    except (FitError, InvalidInput) as error:
        return {"succeeded": 0, "refused": str(error)}
    counted = {"duration_s": recorded.duration, "kernels": skill.model.weights}
    return judged(made, recorded) | counted

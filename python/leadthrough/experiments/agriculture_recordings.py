"""Motions of a real arm, cut out of long recordings, learned and replayed by each planner."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from leadthrough.errors import FitError, InvalidInput
from leadthrough.experiments.agriculture_measures import judged
from leadthrough.experiments.study import Row, Task
from leadthrough.io import read_demonstrations
from leadthrough.models import PoseDMP
from leadthrough.motion import Demonstration, PoseTrajectory
from leadthrough.preprocess import segment

_FOLDER = "panda_execution"
_RATE = 20.0  # Hz, of the recordings
_COLUMNS = {
    "positions": [f"current_pos_{axis}" for axis in "xyz"],
    "orientations": [f"current_orientation_{axis}" for axis in "wxyz"],
}


def tasks(folder: str, planners: Sequence[str]) -> list[Task]:
    """A task for every recording by every planner; none where there are no recordings."""
    files = sorted((Path(folder) / _FOLDER).glob("*.csv")) if folder else []
    return [
        Task(replay, {"file": str(file), "planner": planner})
        for file in files
        for planner in planners
    ]


def replay(*, file: str, planner: str) -> list[Row]:
    """A row for every motion of a recording, as it was recorded against as it is replayed."""
    recording = read_demonstrations([file], columns=_COLUMNS, rate=_RATE)[0]
    labels = {"study": "recordings", "file": Path(file).name, "planner": planner}
    return [
        {**labels, "motion": number} | _replayed(motion, planner)
        for number, motion in enumerate(segment(recording), start=1)
    ]


def _replayed(motion: Demonstration, planner: str) -> Row:
    recorded = motion.motion
    assert isinstance(recorded, PoseTrajectory)
    try:  # 50 kernels are enough for all but the motions of 20 s
        skill = PoseDMP(None, planner).fit([motion])
        made = skill.generate(dt=1.0 / _RATE)
    except (FitError, InvalidInput) as error:
        return {"succeeded": 0, "refused": str(error)}
    counted = {"duration_s": recorded.duration, "weights": skill.model.weights}
    return judged(made, recorded) | counted

"""The measures of the study on real recordings of a Panda.

panda_execution/*.csv hold the joints of an arm at work at 20 Hz. They are cut into motions at the
pauses, and each motion is learned separately, as no two are of the same task. panda_symbol/*.mat
hold tool positions at 1 kHz: a person guides the arm to trace one symbol six times.
"""

from __future__ import annotations

import math
import warnings
from pathlib import Path

import numpy as np

from leadthrough.io import read_demonstrations
from leadthrough.models import MisalignmentWarning, ProMP
from leadthrough.motion import Demonstration, Trajectory
from leadthrough.preprocess import align_by_time_warping, segment
from leadthrough_studies.human.measures import course, fidelity
from leadthrough_studies.study import Row, Task

_EXECUTION_RATE = 20.0  # Hz
_SYMBOL_RATE = 1000.0
_JOINTS = {"joints": [f"joint_{number}" for number in range(1, 8)]}
# Joints that move less in a motion say nothing about its velocity.
_TURNED = 0.1  # rad
_MOVED = 0.01  # m
# Every tenth sample of a symbol is kept: 100 per second.
_KEPT = 10


def tasks(folder: str, joints: list[int], weights: int) -> list[Task]:
    """A task for every recording in a folder; no tasks if its name is empty."""
    if not folder:
        return []
    arms = sorted((Path(folder) / "panda_execution").glob("*.csv"))
    symbols = sorted((Path(folder) / "panda_symbol").glob("*.mat"))
    return [
        *(
            Task(
                execution,
                {"source": file.stem, "joints": joints, "weights": weights},
                {"file": file},
            )
            for file in arms
        ),
        *(
            Task(symbol, {"source": file.stem, "weights": weights}, {"file": file})
            for file in symbols
        ),
    ]


def execution(*, source: str, file: Path, joints: list[int], weights: int) -> list[Row]:
    """A row for every motion in a recording of an arm at work and for every joint that moves."""
    recording = read_demonstrations([file], columns=_JOINTS, rate=_EXECUTION_RATE, rest=math.inf)[0]
    rows = []
    for number, shown in enumerate(segment(recording), start=1):
        turned = np.ptp(shown.motion.positions, axis=0)
        moving = [joint for joint in joints if turned[joint - 1] >= _TURNED]
        if not moving:
            continue
        skill = ProMP(weights=weights).fit([shown])
        labels = {"study": "recordings", "source": source, "learned_from": "one"}
        rows += [
            {**labels, "motion": number, "column": f"joint {joint}", "weights": weights}
            | fidelity(skill, [shown.motion], joint - 1)
            for joint in moving
        ]
    return rows


def symbol(*, source: str, file: Path, weights: int) -> list[Row]:
    """A row for every way of learning a traced symbol and for every coordinate that moves."""
    shown = [
        _thinned(each) for each in read_demonstrations([file], rate=_SYMBOL_RATE, rest=math.inf)
    ]
    # Aligned demonstrations take the timing of the quickest, which they are compared with.
    chosen = int(np.argmin([each.motion.duration for each in shown]))
    aligned = align_by_time_warping(shown, reference=chosen)
    ways = {
        "one": (shown[:1], shown[:1]),
        "all": (shown, shown),
        "all, aligned": (aligned, [shown[chosen]]),
    }
    rows = []
    for way, (given, compared) in ways.items():
        with warnings.catch_warnings():
            # The study shows the loss by demonstrations out of step.
            warnings.simplefilter("ignore", MisalignmentWarning)
            skill = ProMP(weights=weights).fit(given)
        motions = [each.motion for each in compared]
        moved = np.ptp(motions[0].positions, axis=0) >= _MOVED
        rows += [
            {"study": "recordings", "source": source, "learned_from": way, "motion": 1}
            | {"column": "xyz"[i], "weights": weights, **fidelity(skill, motions, i)}
            | {"course": course(skill, motions[0], i)}
            for i in np.flatnonzero(moved).tolist()
        ]
    return rows


def _thinned(demonstration: Demonstration) -> Demonstration:
    motion = demonstration.motion
    thin = Trajectory(motion.times[::_KEPT], motion.positions[::_KEPT])
    return Demonstration(thin, demonstration.name)

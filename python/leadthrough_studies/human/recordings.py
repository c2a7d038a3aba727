"""The measures of the study of demonstrations on real recordings of a Panda.

panda_execution/*.csv: an arm at work, its joints at 20 Hz, cut into motions at the pauses; each is
learned by itself, as no two are of the same task. panda_symbol/*.mat: a person who traces one
symbol six times with the arm in the hand; only the tool's position was kept, at 1 kHz.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from leadthrough.io import read_demonstrations
from leadthrough.models import ProMP
from leadthrough.motion import Demonstration, Trajectory
from leadthrough.preprocess import segment
from leadthrough.preprocess.align import align_by_time_warping
from leadthrough_studies.human.measures import course, fidelity
from leadthrough_studies.study import Row, Task

_EXECUTION_RATE = 20.0  # Hz
_SYMBOL_RATE = 1000.0
_JOINTS = {"joints": [f"joint_{number}" for number in range(1, 8)]}
# Joints that turn less in a motion say nothing of its velocity.
_TURNED = 0.1  # rad
_MOVED = 0.01  # m
# Every so many samples of the symbol's are kept: 100 a second.
_KEPT = 10


def tasks(folder: str, joints: list[int], weights: int) -> list[Task]:
    """A task for every recording in a folder; none where its name is empty."""
    if not folder:
        return []
    arms = sorted((Path(folder) / "panda_execution").glob("*.csv"))
    symbols = sorted((Path(folder) / "panda_symbol").glob("*.mat"))
    return [
        *(Task(execution, {"file": str(f), "joints": joints, "weights": weights}) for f in arms),
        *(Task(symbol, {"file": str(f), "weights": weights}) for f in symbols),
    ]


def execution(*, file: str, joints: list[int], weights: int) -> list[Row]:
    """A row for every motion of an arm at work and joint that turns in it."""
    recording = read_demonstrations([file], columns=_JOINTS, rate=_EXECUTION_RATE)[0]
    rows = []
    for number, shown in enumerate(segment(recording), start=1):
        turned = np.ptp(shown.motion.positions, axis=0)
        moving = [joint for joint in joints if turned[joint - 1] >= _TURNED]
        if not moving:
            continue
        skill = ProMP(weights=weights).fit([shown])
        labels = {"study": "recordings", "source": Path(file).stem, "learned_from": "one"}
        rows += [
            {**labels, "motion": number, "column": f"joint {joint}", "weights": weights}
            | fidelity(skill, [shown.motion], joint - 1)
            for joint in moving
        ]
    return rows


def symbol(*, file: str, weights: int) -> list[Row]:
    """A row for every way of learning a traced symbol and coordinate that moves."""
    shown = [_thinned(each) for each in read_demonstrations([file], rate=_SYMBOL_RATE)]
    aligned = align_by_time_warping(shown)
    chosen = int(np.argmin([each.motion.duration for each in shown]))
    # Compared with what was shown; of the aligned ones the one that keeps its own timing.
    ways = {
        "one": (shown[:1], shown[:1]),
        "all": (shown, shown),
        "all, aligned": (aligned, [shown[chosen]]),
    }
    rows = []
    for way, (given, compared) in ways.items():
        skill = ProMP(weights=weights).fit(given)
        motions = [each.motion for each in compared]
        moved = np.ptp(motions[0].positions, axis=0) >= _MOVED
        rows += [
            {"study": "recordings", "source": Path(file).stem, "learned_from": way, "motion": 1}
            | {"column": "xyz"[i], "weights": weights, **fidelity(skill, motions, i)}
            | {"course": course(skill, motions[0], i)}
            for i in np.flatnonzero(moved).tolist()
        ]
    return rows


def _thinned(demonstration: Demonstration) -> Demonstration:
    motion = demonstration.motion
    thin = Trajectory(motion.times[::_KEPT], motion.positions[::_KEPT])
    return Demonstration(thin, demonstration.name)

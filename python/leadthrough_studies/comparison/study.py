"""The comparison: all models by one protocol, from accuracy to whether an arm can run the motion.

- Handwriting (LASA, 30 motions of 7 demonstrations): IN learns from all seven and reproduces each,
  LOO leaves each out in turn. Settings of the rivals are chosen by cross-validation among the
  demonstrations that they may learn from; the package's own models stand at their defaults.
- Real poses (RoboTasks, with LEADTHROUGH_DATA): each demonstration left out in turn, with its start
  and goal given.
- Responses: a push half-way, and a goal that has moved.
- Stability of the dynamical systems: ten thousand starts for each motion.
- Arms: the motions that were made from left-out starts, on a Panda and a UR3.

Tables 1 and 2 of Prados et al. 2023 come anew from these rows, with the printed ones beside them.
"""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from leadthrough.io import lasa
from leadthrough.motion import Demonstration, PoseTrajectory, Trajectory
from leadthrough.preprocess.resample import by_arc_length
from leadthrough_studies.comparison import measures
from leadthrough_studies.comparison.methods import POINTS, POSES, SYSTEMS, chosen
from leadthrough_studies.comparison.report import report
from leadthrough_studies.robotasks.study import read
from leadthrough_studies.study import Row, Study, Task

Drawings: TypeAlias = Sequence[Demonstration[Trajectory]]
Poses: TypeAlias = Sequence[Demonstration[PoseTrajectory]]

PROTOCOLS = ("IN", "LOO")
ARMS = ("panda", "ur3")
_QUICK = ("Angle", "GShape")
_DRAWN = 60  # points of a path that are kept for the pictures


@dataclass(frozen=True)
class ComparisonConfig:
    """The configuration of the study.

    Attributes:
        motions: names of motions of the LASA set.
        points: keys of POINTS.
        protocols: of PROTOCOLS.
        files: recordings of poses, an array (demonstrations, samples, 7) each.
        poses: keys of POSES.
        left_out: number of demonstrations that are tested of each motion or task; None for all.
        folds: number of demonstrations that inner cross-validation leaves out; 0 for none.
        starts: number of starts of each test of stability.
        seed: recorded as in every study, but unused: all methods draw with their own seeds.
    """

    motions: tuple[str, ...]
    points: tuple[str, ...] = tuple(POINTS)
    protocols: tuple[str, ...] = PROTOCOLS
    files: tuple[str, ...] = ()
    poses: tuple[str, ...] = tuple(POSES)
    left_out: int | None = None
    folds: int = 2
    starts: int = 10_000
    seed: int = 0


def configure(quick: bool, seed: int) -> ComparisonConfig:
    """All motions and, with LEADTHROUGH_DATA, all recordings; or two motions and few tests."""
    folder = Path(os.environ.get("LEADTHROUGH_DATA", "")) / "robotasks"
    files = tuple(str(file) for file in sorted(folder.glob("*.npy")))
    if quick:
        return ComparisonConfig(_QUICK, files=files[:1], left_out=1, folds=0, starts=500, seed=seed)
    return ComparisonConfig(tuple(lasa.motions()), files=files, seed=seed)


def tasks(config: ComparisonConfig) -> list[Task]:
    """A task for every motion and method with each protocol, and for every recording and method."""
    drawings = [
        Task(
            draw,
            {
                "motion": motion,
                "method": method,
                "protocol": protocol,
                "left_out": config.left_out,
                "folds": config.folds,
            },
        )
        for motion in config.motions
        for protocol in config.protocols
        for method in config.points
    ]
    examined = [
        Task(examine, {"motion": motion, "method": method, "starts": config.starts})
        for motion in config.motions
        for method in config.points
        if method in SYSTEMS
    ]
    moved = [
        Task(
            move,
            {
                "file": file,
                "method": method,
                "left_out": config.left_out,
                "folds": config.folds,
            },
        )
        for file in config.files
        for method in config.poses
    ]
    return [*drawings, *examined, *moved]


def draw(*, motion: str, method: str, protocol: str, left_out: int | None, folds: int) -> list[Row]:
    """A row for every tested drawing of a motion."""
    shown = lasa.load(motion)
    labels = {"study": "drawings", "motion": motion, "method": method, "protocol": protocol}
    rows = []
    for i, tested in enumerate(shown[:left_out]):
        known = shown if protocol == "IN" else [each for j, each in enumerate(shown) if j != i]
        found = measures.tried(
            lambda known=known, tested=tested: _drawn(method, known, tested, folds)
        )
        rows.append({**labels, "tested": i, **found})
    return rows


def _drawn(method: str, known: Drawings, tested: Demonstration[Trajectory], folds: int) -> Row:
    model = chosen(POINTS[method], known, _error_of_drawings, folds=folds)
    began = time.process_time()
    skill = model.fit(known)
    fitted = time.process_time()
    made = skill.generate(start=tested.motion.positions[0])
    generated = time.process_time()
    row = {
        **measures.drawing_errors(tested.motion, made),
        **measures.responses(skill, tested.motion),
        "setting": _named(model),
        "fit_cpu_s": fitted - began,
        "generate_cpu_s": generated - fitted,
        "path": by_arc_length(made.positions, _DRAWN).round(2).tolist(),
    }
    if method in SYSTEMS:
        row["direction_error"] = measures.direction_error(skill, tested.motion)
    for arm in ARMS:
        found = measures.on_arm(arm, measures.on_paper(arm, made))
        row |= {f"{arm}_{name}": value for name, value in found.items()}
    return row


def _error_of_drawings(skill: Any, left_out: Drawings) -> float:
    found = 0.0
    for each in left_out:
        row = measures.tried(lambda each=each: _only_errors(skill, each))
        found += row.get("SEA_mm2", np.inf)
    return found


def _only_errors(skill: Any, tested: Demonstration[Trajectory]) -> Row:
    made = skill.generate(start=tested.motion.positions[0])
    return measures.drawing_errors(tested.motion, made)


def examine(*, motion: str, method: str, starts: int) -> list[Row]:
    """A row with the stability of a system that has learned all demonstrations of a motion."""
    models = POINTS[method]
    skill = models[len(models) // 2].fit(lasa.load(motion))
    labels = {"study": "stability", "motion": motion, "method": method}
    return [{**labels, **measures.stability(skill, starts)}]


def move(*, file: str, method: str, left_out: int | None, folds: int) -> list[Row]:
    """A row for every demonstration of a task of poses that is left out."""
    shown = read(file)
    labels = {"study": "poses", "task": Path(file).stem, "method": method}
    rows = []
    for i, tested in enumerate(shown[:left_out]):
        known = [each for j, each in enumerate(shown) if j != i]
        found = measures.tried(
            lambda known=known, tested=tested: _moved(method, known, tested, folds)
        )
        rows.append({**labels, "tested": i, **found})
    return rows


def _moved(method: str, known: Poses, tested: Demonstration[PoseTrajectory], folds: int) -> Row:
    model = chosen(POSES[method], known, _error_of_poses, folds=folds)
    began = time.process_time()
    skill = model.fit(known)
    fitted = time.process_time()
    made = _between(skill, tested)
    generated = time.process_time()
    found = measures.on_arm("panda", made)
    return {
        **measures.pose_errors(tested.motion, made),
        "setting": _named(model),
        "fit_cpu_s": fitted - began,
        "generate_cpu_s": generated - fitted,
        **{f"panda_{name}": value for name, value in found.items()},
    }


def _between(skill: Any, tested: Demonstration[PoseTrajectory]) -> Any:
    motion = tested.motion
    start, goal = ((motion.positions[i], motion.orientations[i]) for i in (0, -1))
    return skill.generate(start=start, goal=goal)


def _error_of_poses(skill: Any, left_out: Poses) -> float:
    found = 0.0
    for each in left_out:
        row = measures.tried(
            lambda each=each: measures.pose_errors(each.motion, _between(skill, each))
        )
        found += row.get("DTW_mm", np.inf)
    return found


def _named(model: Any) -> str:
    """The settings of a model that were chosen among."""
    names = ("components", "units", "kernels", "weights")
    told = [f"{name} {getattr(model, name)}" for name in names if hasattr(type(model), name)]
    return ", ".join(told)


STUDY = Study(configure, tasks, report)

"""The tasks of the comparison: a method on one motion, each demonstration tested in turn."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from leadthrough.io import lasa
from leadthrough.models import MisalignmentWarning
from leadthrough.motion import Demonstration, PoseTrajectory, Trajectory
from leadthrough.preprocess.resample import by_arc_length
from leadthrough_studies.comparison import material, measures, recordings
from leadthrough_studies.comparison.methods import (
    COURSES,
    POINTS,
    POSES,
    RECORDED,
    RECORDED_POSES,
    SYSTEMS,
    Model,
    chosen,
)
from leadthrough_studies.comparison.on_arms import ARMS, before, on_all, on_paper
from leadthrough_studies.study import Row

# Of the velocity error at samples like those that systems are fitted to.
_SMOOTHING, _SLOWEST = 2.0, 0.1
_DRAWN = 60  # points of a path that are kept for the pictures


@dataclass(frozen=True, eq=False)
class Learned:
    """A skill, the settings that were chosen for it, and the processor time of its fit, s."""

    skill: Any
    setting: str
    fit_s: float


def draw(*, motion: str, method: str, protocol: str, left_out: int | None, folds: int) -> list[Row]:
    """A row for every tested drawing of a motion.

    Args:
        motion: name of a motion of the LASA set.
        method: key of POINTS.
        protocol: "IN" or "LOO".
        left_out: number of drawings that are tested; None for all.
        folds: number of drawings that inner cross-validation leaves out.
    """
    shown = lasa.load(motion)
    labels = {"study": "drawings", "motion": motion, "method": method, "protocol": protocol}

    def error(skill: Any, tested: Demonstration[Any]) -> float:
        made = skill.generate(start=tested.motion.positions[0])
        return float(measures.drawing_errors(tested.motion, made)["SEA_mm2"])

    def row(learned: Learned, tested: Demonstration[Any]) -> Row:
        return _drawn(method, learned, tested.motion)

    learn = learner(POINTS[method], error, folds)
    return [
        {**labels, **each}
        for each in tested_in_turn(shown, learn, row, left_out, inside=protocol == "IN")
    ]


def trace(
    *, name: str, method: str, left_out: int | None, folds: int, seed: int, file: Path | None = None
) -> list[Row]:
    """A row for every demonstration of a course that is left out, with its start and goal given.

    Args:
        name: name of the course.
        method: key of COURSES.
        left_out: number of demonstrations that are left out; None for all.
        folds: number of demonstrations that inner cross-validation leaves out.
        seed: seed of the random number generator, for simulated demonstrations.
        file: its recording, if it has one.
    """

    def row(learned: Learned, tested: Demonstration[Any]) -> Row:
        return _traced(learned, tested.motion)

    learn = learner(COURSES[method], _error_of_course, folds)
    shown = material.course(name, file, seed)
    labels = {"study": "courses", "task": name, "method": method}
    return [{**labels, **each} for each in tested_in_turn(shown, learn, row, left_out)]


def move(
    *, name: str, method: str, left_out: int | None, folds: int, seed: int, file: Path | None = None
) -> list[Row]:
    """A row for every demonstration of poses that is left out, with its start and goal given.

    Args:
        name: name of the motion.
        method: key of POSES.
        left_out: number of demonstrations that are left out; None for all.
        folds: number of demonstrations that inner cross-validation leaves out.
        seed: seed of the random number generator, for simulated demonstrations.
        file: its recording, if it has one.
    """

    def row(learned: Learned, tested: Demonstration[Any]) -> Row:
        return _moved(learned, tested.motion)

    learn = learner(POSES[method], _error_of_poses, folds)
    shown = material.poses(name, file, seed)
    labels = {"study": "poses", "task": name, "method": method}
    return [{**labels, **each} for each in tested_in_turn(shown, learn, row, left_out)]


def leave_out(*, name: str, method: str, left_out: int | None, folds: int, file: Path) -> list[Row]:
    """A row for every demonstration of a set that is left out, with its start and goal given.

    Args:
        name: name of the set.
        method: key of RECORDED.
        left_out: number of demonstrations that are left out; None for all.
        folds: number of demonstrations that inner cross-validation leaves out.
        file: its recordings.
    """
    shown = recordings.read(file)
    poses = isinstance(shown[0].motion, PoseTrajectory)
    reproduced = _between if poses else _course

    def row(learned: Learned, tested: Demonstration[Any]) -> Row:
        made = reproduced(learned.skill, tested.motion)
        return {**recordings.errors(tested.motion, made), "setting": learned.setting}

    def error(skill: Any, tested: Demonstration[Any]) -> float:
        made = reproduced(skill, tested.motion)
        return float(recordings.errors(tested.motion, made)["Frechet"])

    learn = learner((RECORDED_POSES if poses else RECORDED)[method], error, folds)
    labels = {"study": "recordings", "set": name, "method": method}
    return [{**labels, **each} for each in tested_in_turn(shown, learn, row, left_out)]


def examine(*, motion: str, method: str, starts: int) -> list[Row]:
    """A row with the stability of a system that has learned all demonstrations of a motion.

    Args:
        motion: name of a motion of the LASA set.
        method: key of SYSTEMS.
        starts: number of starts.
    """
    models = SYSTEMS[method]
    skill = models[len(models) // 2].fit(lasa.load(motion))
    labels = {"study": "stability", "motion": motion, "method": method}
    return [{**labels, **measures.stability(skill, starts)}]


def tested_in_turn(
    shown: Sequence[Demonstration[Any]],
    learn: Callable[[Sequence[Demonstration[Any]]], Learned],
    row: Callable[[Learned, Demonstration[Any]], Row],
    left_out: int | None,
    *,
    inside: bool = False,
) -> list[Row]:
    """A row for each tested demonstration, which is among those learned from if `inside`."""
    rows: list[Row] = []
    known: Row = {}
    for i, tested in enumerate(shown[:left_out]):
        if not known or not inside:
            others = [each for j, each in enumerate(shown) if inside or j != i]
            known = measures.tried(lambda others=others: {"learned": learn(others)})
        found = known
        if "learned" in known:
            found = measures.tried(lambda known=known, tested=tested: row(known["learned"], tested))
        rows.append({"tested": i, **found})
    return rows


def learner(
    models: Sequence[Model], error: Callable[[Any, Demonstration[Any]], float], folds: int
) -> Callable[[Sequence[Demonstration[Any]]], Learned]:
    """Chooses a model by the errors of left-out demonstrations, and fits it to all."""

    def total(skill: Any, left_out: Sequence[Demonstration[Any]]) -> float:
        found = [
            measures.tried(lambda each=each: {"error": error(skill, each)}) for each in left_out
        ]
        return float(sum(each.get("error", np.inf) for each in found))

    def learn(shown: Sequence[Demonstration[Any]]) -> Learned:
        with warnings.catch_warnings():
            # Models are judged with their losses by demonstrations out of step.
            warnings.simplefilter("ignore", MisalignmentWarning)
            model = chosen(models, shown, total, folds=folds)
            began = time.process_time()
            skill = model.fit(shown)
        return Learned(skill, _named(model), time.process_time() - began)

    return learn


def _drawn(method: str, learned: Learned, tested: Trajectory) -> Row:
    skill = learned.skill
    began = time.process_time()
    made = skill.generate(start=tested.positions[0])
    taken = time.process_time() - began

    def positions(start: Any, goal: Any) -> Any:
        return skill.generate(start=start, goal=goal).positions

    row = {
        **measures.drawing_errors(tested, made),
        **measures.response_to_goal(positions, tested.positions),
        **_costs(learned, taken),
        "path": by_arc_length(made.positions, _DRAWN).round(2).tolist(),
        **on_all({arm: on_paper(arm, made) for arm in ARMS}),
    }
    if method in SYSTEMS:
        row["direction_error"] = measures.direction_error(skill, tested)
        row["direction_error_smoothed"] = measures.direction_error(
            skill, tested, smoothing=_SMOOTHING, slowest=_SLOWEST
        )
    return row


def _traced(learned: Learned, tested: Trajectory) -> Row:
    skill = learned.skill
    began = time.process_time()
    made = _course(skill, tested)
    taken = time.process_time() - began

    def positions(start: Any, goal: Any) -> Any:
        return skill.generate(start=start, goal=goal).positions

    return {
        **measures.course_errors(tested, made),
        **measures.response_to_goal(positions, tested.positions, unit=1e3),
        **_costs(learned, taken),
        **on_all({arm: before(arm, made) for arm in ARMS}),
    }


def _moved(learned: Learned, tested: PoseTrajectory) -> Row:
    skill = learned.skill
    began = time.process_time()
    made = _between(skill, tested)
    taken = time.process_time() - began
    last = tested.orientations[-1]

    def positions(start: Any, goal: Any) -> Any:
        path = np.linalg.norm(tested.positions - start, axis=1)
        turned = tested.orientations[int(path.argmin())]
        return skill.generate(start=(start, turned), goal=(goal, last)).positions

    return {
        **measures.pose_errors(tested, made),
        **measures.response_to_goal(positions, tested.positions, unit=1e3),
        **_costs(learned, taken),
        **on_all({"panda": made, "ur3": before("ur3", made)}),
    }


def _costs(learned: Learned, taken: float) -> Mapping[str, Any]:
    return {"setting": learned.setting, "fit_cpu_s": learned.fit_s, "generate_cpu_s": taken}


def _course(skill: Any, tested: Trajectory) -> Trajectory:
    made: Trajectory = skill.generate(start=tested.positions[0], goal=tested.positions[-1])
    return made


def _error_of_course(skill: Any, tested: Demonstration[Any]) -> float:
    return float(measures.course_errors(tested.motion, _course(skill, tested.motion))["DTW_mm"])


def _between(skill: Any, tested: PoseTrajectory) -> PoseTrajectory:
    start, goal = ((tested.positions[i], tested.orientations[i]) for i in (0, -1))
    made: PoseTrajectory = skill.generate(start=start, goal=goal)
    return made


def _error_of_poses(skill: Any, tested: Demonstration[Any]) -> float:
    made = _between(skill, tested.motion)
    return float(measures.pose_errors(tested.motion, made)["DTW_mm"])


def _named(model: Model) -> str:
    """The settings of a model that were chosen among."""
    own = getattr(model, "columns", model)
    names = ("components", "units", "kernels", "weights", "variance", "shift", "nearest")
    told = [f"{name} {getattr(own, name)}" for name in names if hasattr(type(own), name)]
    return ", ".join(told)

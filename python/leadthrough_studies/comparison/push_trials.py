"""The tasks with pushes: a method on one motion, its tool or a simulated arm pushed aside.

Models take the setting in the middle of those among which cross-validation chooses.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from leadthrough.io import lasa
from leadthrough.motion import Demonstration, Motion, PoseTrajectory
from leadthrough_studies.comparison import material, measures, pushed_arm
from leadthrough_studies.comparison.methods import COURSES, JOINTS, POINTS, POSES
from leadthrough_studies.comparison.pushes import after_push
from leadthrough_studies.comparison.trials import Learned, learner, tested_in_turn
from leadthrough_studies.study import Row

_MODELS = {"drawings": POINTS, "courses": COURSES, "poses": POSES, "joints": JOINTS}


def push(
    *, part: str, name: str, method: str, left_out: int | None, seed: int, file: Path | None = None
) -> list[Row]:
    """A row with the responses to pushes for every demonstration that is left out.

    Args:
        part: "drawings", "courses", "poses" or "joints"; all but the first with start and goal.
        name: name of the motion.
        method: key of POINTS, COURSES, POSES or JOINTS.
        left_out: number of demonstrations that are left out; None for all.
        seed: seed of the random number generator, for simulated demonstrations.
        file: its recording, if it has one.
    """

    def row(learned: Learned, tested: Demonstration[Any]) -> Row:
        return _pushed(learned, tested.motion, ends=part != "drawings")

    learn = learner(_MODELS[part][method], lambda *_: 0.0, 0)
    labels = {"study": "pushes", "task": name, "part": part, "method": method}
    shown = _shown(part, name, file, seed)
    return [{**labels, **each} for each in tested_in_turn(shown, learn, row, left_out)]


def push_arm(
    *, part: str, name: str, method: str, left_out: int | None, seed: int, file: Path | None = None
) -> list[Row]:
    """A row with the responses of a simulated Panda for every demonstration that is left out.

    Args:
        part: "courses", "poses" or "joints".
        name: name of the motion.
        method: key of COURSES, POSES or JOINTS, of a model of the package.
        left_out: number of demonstrations that are left out; None for all.
        seed: seed of the random number generator, for simulated demonstrations.
        file: its recording, if it has one.
    """

    def row(learned: Learned, tested: Demonstration[Any]) -> Row:
        return pushed_arm.responses(learned.skill, tested.motion)

    learn = learner(_MODELS[part][method], lambda *_: 0.0, 0)
    labels = {"study": "pushed arm", "task": name, "part": part, "method": method}
    shown = _shown(part, name, file, seed)
    if part == "courses":
        shown = pushed_arm.before_the_arm(shown)
    return [{**labels, **each} for each in tested_in_turn(shown, learn, row, left_out)]


def _shown(part: str, name: str, file: Path | None, seed: int) -> Sequence[Demonstration[Any]]:
    if part == "drawings":
        return lasa.load(name)
    if part == "courses":
        return material.course(name, file, seed)
    return material.poses(name, file, seed) if part == "poses" else material.joints(seed)


def _pushed(learned: Learned, tested: Motion, *, ends: bool) -> Row:
    """The responses of a skill to pushes; `ends` for a motion in m or rad with its goal given."""
    start, goal = (tested.at(time) for time in tested.times[[0, -1]])

    def pushed(at: float, place: Any, held: float) -> Any:
        if isinstance(tested, PoseTrajectory):
            nearest = np.linalg.norm(tested.positions - place, axis=1).argmin()
            place = (place, tested.orientations[int(nearest)])
        return after_push(
            learned.skill, start=start, goal=goal if ends else None, at=at, place=place, held=held
        )

    return measures.response_to_pushes(
        pushed,
        tested.positions,
        clock=hasattr(learned.skill, "begin"),
        unit=1e3 if ends else 1.0,
    )

"""The family of models that predicts left-out demonstrations best, learned from all of them."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np

from leadthrough.blas_threads import one_blas_thread
from leadthrough.check import InvalidInput, LeadthroughError
from leadthrough.models.protocol import (
    Choice,
    Demonstrations,
    MisalignmentWarning,
    Model,
    Outliers,
    Skill,
    fit_all,
    motions_of,
)
from leadthrough.models.registry import model_entry
from leadthrough.models.reproduction import mean_distance
from leadthrough.motion import JointTrajectory, Motion, MotionT, PoseTrajectory, target_of

# The first is taken where nothing can be left out.
CANDIDATES = ("aligned-mean", "fast-marching", "promp", "dmp")
_MOST_LEFT_OUT = 8  # demonstrations, evenly chosen


@one_blas_thread
def learn(
    demonstrations: Demonstrations[MotionT],
    *,
    candidates: Sequence[str | Model] = CANDIDATES,
    outliers: Outliers = "refuse",
) -> Skill[MotionT]:
    """A skill of the family that predicts left-out demonstrations best.

    Each demonstration (of more than eight, eight of them) is left out, and reproduced by each
    family from the others, given its start and goal. `skill.choice` has the errors.

    Args:
        demonstrations: one or more demonstrations, or motions, of one type.
        candidates: names of models, as `models.model_names`, or models with settings. Families
            that do not learn this type of motion are left out.
        outliers: treatment of a demonstration that contradicts all others: one that runs
            backwards, of another task, rotated by more than 70 degrees, or four times as fast or
            slow. "refuse" raises an error, "drop" leaves it out, "keep" learns it all the same.
            Two that agree with each other are a second way, and stay.

    Raises:
        FitError: if no candidate can learn the demonstrations; with outliers="refuse" also for one
            that contradicts all others, with the place.
        InvalidInput: if no candidate is of this type of motion.
    """
    motions = motions_of(demonstrations, outliers=outliers)
    models = _models(candidates, motions[0])
    folds = _left_out(len(motions))
    errors = {name: _mean_error(model, motions, folds) for name, model in models.items()}
    chosen = min(errors, key=lambda name: errors[name])
    fitted: Any = fit_all(models[chosen], motions)
    skill: Skill[MotionT] = fitted.with_choice(Choice(chosen, errors, len(folds)))
    return skill


def _models(candidates: Sequence[str | Model], motion: Motion) -> dict[str, Model]:
    """The candidates for a type of motion, by name."""
    kind = "points"
    if isinstance(motion, PoseTrajectory | JointTrajectory):
        kind = "poses" if isinstance(motion, PoseTrajectory) else "joints"
    found: dict[str, Model] = {}
    for each in candidates:
        if not isinstance(each, str):
            found[repr(each)] = each
        elif kind in (entry := model_entry(each)).motions:
            found[each] = entry.load()()
    if not found:
        raise InvalidInput(f"candidates: expected a model that learns {kind}, got {candidates!r}")
    return found


def _left_out(count: int) -> list[int]:
    """The indices of the demonstrations to leave out."""
    if count < 2:
        return []
    return [int(i) for i in np.linspace(0, count - 1, min(count, _MOST_LEFT_OUT)).round()]


def _mean_error(model: Model, motions: Sequence[Motion], folds: list[int]) -> float:
    errors = []
    for i in folds:
        rest = [each for j, each in enumerate(motions) if j != i]
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", MisalignmentWarning)
                start, goal = (target_of(motions[i], row) for row in (0, -1))
                made = fit_all(model, rest).generate(start=start, goal=goal)
        except LeadthroughError:
            return float("inf")
        errors.append(mean_distance(motions[i], made))
    return float(np.mean(errors)) if errors else 0.0

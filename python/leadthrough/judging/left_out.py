"""How well demonstrations predict those that are left out."""

from __future__ import annotations

import math
import pickle
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.errors import LeadthroughError
from leadthrough.models.protocol import Model, Skill
from leadthrough.models.targets import Target, TargetRegion
from leadthrough.motion import Motion, PoseTrajectory
from leadthrough.preprocess.align import features
from leadthrough.tasks import Row

_SAMPLES = 200
_FAILED = 1.0  # the error, in the extent, where nothing can be learned or planned


@dataclass(frozen=True, eq=False)
class Shown:
    """What all tasks of a judgement have in common.

    Attributes:
        model: that learns.
        motions: of the demonstrations.
        goals: where the next demonstration may end, if asked for.
    """

    model: Model
    motions: tuple[Motion, ...]
    goals: TargetRegion | None


def errors(*, without: Sequence[int], tested: Sequence[int], shown: Path) -> list[Row]:
    """A row for each tested demonstration: the error of its prediction by the others.

    Args:
        without: indices of demonstrations that nothing is learned from.
        tested: indices of those that are left out in turn.
        shown: the file of a pickled `Shown`.
    """
    common = _read(shown)
    return [
        {"tested": i, "error": _error(common, {*without, i}, common.motions[i])} for i in tested
    ]


def uncertainties(
    *, without: Sequence[int], slope: float, count: int, seed: int, shown: Path
) -> list[Row]:
    """A row for each goal at random: how wrong a motion to it may be."""
    common = _read(shown)
    assert common.goals is not None  # asked for only then
    rng = np.random.default_rng(seed)
    kept = [i for i in range(len(common.motions)) if i not in set(without)]
    ends = goals_of([common.motions[i] for i in kept])
    skills = [_learned(common, {*without, i}) for i in kept]
    rows = []
    for _ in range(count):
        goal = np.asarray(common.goals.draw(rng), dtype=np.float64)
        apart = _spread([skill for skill in skills if skill is not None], goal)
        away = float(np.linalg.norm(ends - goal, axis=1).min())
        numbers = [float(number) for number in goal]
        rows.append({"goal": numbers, "uncertainty": math.hypot(apart, slope * away)})
    return rows


def goals_of(motions: Sequence[Motion]) -> Float64Array:
    """The positions (m, d) at which motions end."""
    return np.array([each.positions[-1] for each in motions])


def _read(shown: Path) -> Shown:
    with shown.open("rb") as file:
        found: Shown = pickle.load(file)
    return found


def _learned(common: Shown, without: set[int]) -> Skill[Motion] | None:
    others = [motion for i, motion in enumerate(common.motions) if i not in without]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of what the judgement says itself
        try:
            return common.model.fit(others)
        except LeadthroughError:
            return None


def _generated(skill: Skill[Motion], start: Target | None, goal: Target) -> Motion | None:
    asked = {"goal": goal} if start is None else {"start": start, "goal": goal}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            return skill.generate(**asked)  # type: ignore[arg-type]  # the two ends alone
        except LeadthroughError:
            return None


def _error(common: Shown, without: set[int], wanted: Motion) -> float:
    """The mean distance at evenly spaced times, in the extent of the wanted motion."""
    skill = _learned(common, without)
    made = None if skill is None else _generated(skill, _end(wanted, 0), _end(wanted, -1))
    if made is None:
        return _FAILED
    ours, theirs = features([made, wanted], _SAMPLES)
    return float(np.linalg.norm(ours - theirs, axis=1).mean())


def _spread(skills: Sequence[Skill[Motion]], goal: Target) -> float:
    """Root mean square distance of the skills' motions from their mean, in their unit."""
    motions = [_generated(skill, None, goal) for skill in skills]
    even = np.linspace(0.0, 1.0, _SAMPLES)
    paths = [_positions(each, even) for each in motions if each is not None]
    if len(paths) < 2:
        return 0.0
    return float(np.sqrt(np.var(paths, axis=0).sum(axis=1).mean()))


def _positions(motion: Motion, fractions: Float64Array) -> Float64Array:
    times = motion.times[0] + fractions * motion.duration
    return np.column_stack([np.interp(times, motion.times, c) for c in motion.positions.T])


def _end(motion: Motion, index: int) -> Target:
    position: Float64Array = motion.positions[index]
    return (
        (position, motion.orientations[index]) if isinstance(motion, PoseTrajectory) else position
    )

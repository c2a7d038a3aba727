"""Errors of predicting demonstrations that are left out, as tasks for many processes."""

from __future__ import annotations

import math
import pickle
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from leadthrough import tasks
from leadthrough.check import Float64Array, InvalidInput, LeadthroughError
from leadthrough.io.files import replacing
from leadthrough.models import Model, Skill, Target, TargetRegion
from leadthrough.models.frame import target_of
from leadthrough.motion import Motion, lerp
from leadthrough.preprocess.align import features
from leadthrough.tasks import Row, Store, Task

_SAMPLES = 200
_FAILED = 1.0  # error, in extents, where learning or planning fails


@dataclass(frozen=True, eq=False)
class Material:
    """Input that all tasks share."""

    model: Model
    motions: tuple[Motion, ...]
    goals: TargetRegion | None  # region of the next demonstration's goal


class LeftOut:
    """Tasks that learn without some demonstrations, run on many processes, and their results."""

    def __init__(
        self, material: Material, folder: Path, on: str | None, timeout: float | None
    ) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self._file = folder / "demonstrations.pickle"
        with replacing(self._file) as temporary:
            temporary.write_bytes(pickle.dumps(material, protocol=5))
        self._motions, self._on, self._timeout = material.motions, on, timeout
        self._store = Store(folder / "cache")

    def worth(self, count: int) -> Float64Array:
        """Growth (m,) of the others' left-out error without each, as a fraction."""
        every = list(range(count))
        todo = [self._errors([], every)]
        todo += [self._errors([i], [j for j in every if j != i]) for i in every]
        (base, *without) = self._done(todo)
        return np.array(
            [own.mean() / max(np.delete(base, i).mean(), 1e-12) - 1.0
             for i, own in enumerate(without)]
        )  # fmt: skip

    def removable(
        self, sound: list[int], order: NDArray[np.intp]
    ) -> tuple[list[int], float, float]:
        """Those that may be left out, with the error of the sound ones before and after."""
        removed: list[int] = []
        if not sound:
            return removed, 0.0, 0.0
        before = after = self._mean_error(removed, sound)
        for i in (int(i) for i in order if i not in sound):
            without = self._mean_error([*removed, i], sound)
            if without <= after:
                removed, after = [*removed, i], without
        return removed, before, after

    def least_certain(
        self, removed: Sequence[int], *, count: int, seed: int
    ) -> tuple[Float64Array, float]:
        """Of random goals the one with the most uncertain motion, and the uncertainty."""
        arguments = {
            "without": sorted(removed),
            "slope": self._slope(removed),
            "count": count,
            "seed": seed,
        }
        self._outcomes([task := Task(uncertainties, arguments, {"material": self._file})])
        rows = self._store.rows(task.key) or []
        best = max(rows, key=lambda row: row["uncertainty"])
        return np.array(best["goal"]), best["uncertainty"]

    def _slope(self, removed: Sequence[int]) -> float:
        """Left-out error per m of a goal's distance from the nearest demonstrated one, <= 1."""
        used = [i for i in range(len(self._motions)) if i not in removed]
        motions = [self._motions[i] for i in used]
        goals = goals_of(motions)
        apart = np.linalg.norm(goals[:, None] - goals, axis=2)
        np.fill_diagonal(apart, np.inf)
        extent = np.mean([np.linalg.norm(np.ptp(each.positions, axis=0)) for each in motions])
        error = self._mean_error(removed, used) * float(extent)
        return min(1.0, error / max(float(apart.min(axis=1).mean()), 1e-12))

    def _mean_error(self, without: Sequence[int], tested: Sequence[int]) -> float:
        (each,) = self._done([self._errors(without, tested)])
        return float(each.mean())

    def _errors(self, without: Sequence[int], tested: Sequence[int]) -> Task:
        arguments = {"without": sorted(without), "tested": list(tested)}
        return Task(errors, arguments, {"material": self._file})

    def _done(self, todo: Sequence[Task]) -> list[Float64Array]:
        """The errors of each task."""
        self._outcomes(todo)
        return [
            np.array([row["error"] for row in self._store.rows(task.key) or ()]) for task in todo
        ]

    def _outcomes(self, todo: Sequence[Task]) -> None:
        for each in tasks.run(todo, self._store, on=self._on, timeout=self._timeout):
            if each.failure is not None:
                raise InvalidInput(
                    f"demonstrations: cannot be judged: {each.failure['error']}: "
                    f"{each.failure['message']}"
                )


def errors(*, without: Sequence[int], tested: Sequence[int], material: Path) -> list[Row]:
    """A row for each tested demonstration: the error of its prediction by the others."""
    common = _read(material)
    return [
        {"tested": i, "error": _error(common, {*without, i}, common.motions[i])} for i in tested
    ]


def uncertainties(
    *, without: Sequence[int], slope: float, count: int, seed: int, material: Path
) -> list[Row]:
    """A row for each random goal: the uncertainty of a motion to it."""
    common = _read(material)
    assert common.goals is not None  # asked for only then
    rng = np.random.default_rng(seed)
    used = [i for i in range(len(common.motions)) if i not in set(without)]
    ends = goals_of([common.motions[i] for i in used])
    skills = [_learned(common, {*without, i}) for i in used]
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


def _read(material: Path) -> Material:
    with material.open("rb") as file:
        common: Material = pickle.load(file)
    return common


def _learned(common: Material, without: set[int]) -> Skill[Motion] | None:
    others = [motion for i, motion in enumerate(common.motions) if i not in without]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the judgement reports it
        try:
            return common.model.fit(others)
        except LeadthroughError:
            return None


def _generated(skill: Skill[Motion], start: Target | None, goal: Target) -> Motion | None:
    query = {"goal": goal} if start is None else {"start": start, "goal": goal}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            return skill.generate(**query)  # type: ignore[arg-type]  # the two ends alone
        except LeadthroughError:
            return None


def _error(common: Material, without: set[int], expected: Motion) -> float:
    """The mean distance at evenly spaced times, in extents of the expected motion."""
    skill = _learned(common, without)
    made = (
        None
        if skill is None
        else _generated(skill, target_of(expected, 0), target_of(expected, -1))
    )
    if made is None:
        return _FAILED
    ours, theirs = features([made, expected], _SAMPLES)
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
    return lerp(times, motion.times, motion.positions)

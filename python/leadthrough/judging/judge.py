"""Demonstrations against each other: by what sets them apart, and by what is learned without them.

Where a fault is found by how a demonstration differs from the others, in units of what these differ
by (their median absolute deviation, or what demonstrations usually differ by where that is more).
The worth of one is the change of the left-out error of the others without it (deletion diagnostics;
Cook 1977, "Detection of influential observation in linear regression", Technometrics 19(1)).
"""

from __future__ import annotations

import pickle
import tempfile
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from leadthrough import check, tasks
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.io.atomic import replacing
from leadthrough.judging.judgement import Fault, Judgement, Suggestion, Verdict
from leadthrough.judging.left_out import Shown, errors, goals_of, uncertainties
from leadthrough.judging.traits import TRAITS, Trait, peculiarities, shares_its_path
from leadthrough.models.demonstrations import Demonstrations, motions_of
from leadthrough.models.promp.model import ProMP
from leadthrough.models.protocol import Model
from leadthrough.models.targets import TargetRegion
from leadthrough.motion import Demonstration, Motion
from leadthrough.tasks import Store, Task

SUSPICIOUS = 3.0  # usual differences, from which on there is a fault
_LEAST = 4
_FAULTS: dict[Trait, Fault] = {
    "shape": "outlier",
    "step": "out of step",
    "jerk": "jerky",
    "stall": "stalled",
}
_GOALS = 100


def judge_demonstrations(
    demonstrations: Demonstrations[Motion],
    *,
    model: Model | None = None,
    goals: TargetRegion | None = None,
    seed: int = 0,
    on: str | None = None,
    out: Path | None = None,
    task_timeout: float | None = None,
) -> Judgement:
    """What each demonstration is worth, what is wrong with it, and what to show next.

    Args:
        demonstrations: at least four of the same, all of one type and size. Standing still at their
            ends is best left out before.
        model: that is learned with one demonstration left out after the other; `ProMP()` by
            default.
        goals: region in which the next demonstration may end; a suggestion is made only then.
        seed: of the random number generator, for the goals that are compared.
        on: where to compute, as `leadthrough.tasks.run` takes it; None for this process.
        out: folder that keeps what is finished, made if missing; None keeps nothing.
        task_timeout: the longest that one task may take, s; None for no bound.

    Raises:
        InvalidInput: if an argument is wrong, or there are fewer than four demonstrations.
        FitError: if a demonstration has a single sample or does not move.
        MissingDependency: for a Dask cluster, if the extra `dask` is not installed.
        SchedulerUnreachable: if its scheduler does not answer any more.
    """
    motions = motions_of(demonstrations)
    if len(motions) < _LEAST:
        raise InvalidInput(f"demonstrations: expected at least {_LEAST}, got {len(motions)}")
    learner: Model = ProMP() if model is None else model
    asked = None if goals is None else _goals(goals, motions)
    number = check.integer(seed, "seed", at_least=0)
    found = peculiarities(motions)
    suspicion = np.max([found[trait] for trait in TRAITS], axis=0)
    with ExitStack() as stack:
        folder = out or Path(stack.enter_context(tempfile.TemporaryDirectory()))
        run = _Run(Shown(learner, tuple(motions), asked), folder, on, task_timeout)
        sound = [i for i, each in enumerate(suspicion) if each < SUSPICIOUS]
        worth = run.worth(len(motions))
        remove, before, after = run.removable(sound, np.argsort(-suspicion, kind="stable"))
        suggestion = None if asked is None else run.suggestion(remove, number)
    verdicts = tuple(
        Verdict(
            _name(each, i),
            float(suspicion[i]),
            _faults(motions, found, i),
            float(worth[i]),
            i in remove,
        )
        for i, each in enumerate(demonstrations)
    )
    return Judgement(verdicts, before, after, suggestion)


def _goals(goals: TargetRegion, motions: Sequence[Motion]) -> TargetRegion:
    size = motions[0].positions.shape[1]
    if len(goals.lower) != size or goals.orientation is not None:
        raise InvalidInput(f"goals: expected {size} coordinates without an orientation")
    return goals


def _name(demonstration: Demonstration[Motion] | Motion, index: int) -> str:
    return getattr(demonstration, "name", "") or f"demonstration {index + 1}"


def _faults(
    motions: Sequence[Motion], found: dict[Trait, Float64Array], index: int
) -> tuple[Fault, ...]:
    """The faults of a demonstration, the worst first."""
    worst = sorted(TRAITS, key=lambda trait: -found[trait][index])
    faults = [_FAULTS[trait] for trait in worst if found[trait][index] >= SUSPICIOUS]
    if "outlier" in faults and shares_its_path(motions, index):
        faults[faults.index("outlier")] = "another mode"
    return tuple(faults)


class _Run:
    """The tasks of a judgement, and what follows from their rows."""

    def __init__(self, shown: Shown, folder: Path, on: str | None, timeout: float | None) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self._file = folder / "demonstrations.pickle"
        with replacing(self._file) as temporary:
            temporary.write_bytes(pickle.dumps(shown, protocol=5))
        self._motions, self._on, self._timeout = shown.motions, on, timeout
        self._store = Store(folder / "cache")

    def worth(self, count: int) -> Float64Array:
        """By which fraction the left-out errors of the others grow without each."""
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

    def suggestion(self, removed: Sequence[int], seed: int) -> Suggestion:
        """The goal at which what is learned is least certain."""
        arguments = {
            "without": sorted(removed),
            "slope": self._slope(removed),
            "count": _GOALS,
            "seed": seed,
        }
        self._outcomes([task := Task(uncertainties, arguments, {"shown": self._file})])
        rows = self._store.rows(task.key) or []
        best = max(rows, key=lambda row: row["uncertainty"])
        return Suggestion(np.array(best["goal"]), best["uncertainty"])

    def _slope(self, removed: Sequence[int]) -> float:
        """The left-out error for each m of a goal's distance from the nearest one shown, <= 1."""
        kept = [i for i in range(len(self._motions)) if i not in removed]
        motions = [self._motions[i] for i in kept]
        goals = goals_of(motions)
        apart = np.linalg.norm(goals[:, None] - goals, axis=2)
        np.fill_diagonal(apart, np.inf)
        extent = np.mean([np.linalg.norm(np.ptp(each.positions, axis=0)) for each in motions])
        error = self._mean_error(removed, kept) * float(extent)
        return min(1.0, error / max(float(apart.min(axis=1).mean()), 1e-12))

    def _mean_error(self, without: Sequence[int], tested: Sequence[int]) -> float:
        (found,) = self._done([self._errors(without, tested)])
        return float(found.mean())

    def _errors(self, without: Sequence[int], tested: Sequence[int]) -> Task:
        arguments = {"without": sorted(without), "tested": list(tested)}
        return Task(errors, arguments, {"shown": self._file})

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

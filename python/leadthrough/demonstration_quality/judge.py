"""Quality of demonstrations: their faults, their worth for learning, and the goal to show next.

A fault is a difference from the others, in units of these others' spread (median absolute
deviation, or the usual difference of demonstrations where that is more). The worth of one is the
change of the left-out error of the others without it (deletion diagnostics; Cook 1977, "Detection
of influential observation in linear regression", Technometrics 19(1)).
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.demonstration_quality.left_out import LeftOut, Material
from leadthrough.demonstration_quality.traits import TRAITS, Trait, peculiarities, shares_its_path
from leadthrough.models import Model, ProMP, TargetRegion
from leadthrough.models.demonstrations import Demonstrations, motions_of
from leadthrough.motion import Demonstration, Motion
from leadthrough.repr import ShortRepr

Fault = Literal["outlier", "another mode", "misaligned", "jerky", "stalled"]
"""Faults of a demonstration.

An outlier has a path of its own, one of another mode a path that some others share; a misaligned
one has the same path at other times; a jerky one trembles; a stalled one rests in between.
"""

SUSPICIOUS = 3.0  # usual differences; from here on it is a fault
_MIN_COUNT = 4
_FAULTS: dict[Trait, Fault] = {
    "shape": "outlier",
    "timing": "misaligned",
    "jerk": "jerky",
    "stall": "stalled",
}
_GOALS = 100  # at random, of which the least certain is suggested


@dataclass(frozen=True, eq=False)
class Verdict(ShortRepr):
    """The verdict on one demonstration.

    Attributes:
        name: of the demonstration.
        suspicion: its difference from the others, in usual differences, of its most different
            trait; from 3 on it has faults.
        faults: its faults, the worst first.
        worth: growth of the others' left-out error without it, as a fraction; negative if they are
            predicted better without it.
        remove: whether to leave it out: it has faults, and without it the left-out error of those
            without faults is no larger.
    """

    name: str
    suspicion: float
    faults: tuple[Fault, ...]
    worth: float
    remove: bool


@dataclass(frozen=True, eq=False)
class Suggestion(ShortRepr):
    """The goal whose demonstration would reduce the uncertainty most.

    Attributes:
        goal: (d,), in the demonstrations' unit.
        uncertainty: expected error of a motion to it, in the same unit: the spread of the motions
            learned with one demonstration left out each (root mean square over time), and the
            left-out error per m of the goal's distance from the nearest demonstrated one.
    """

    goal: Float64Array
    uncertainty: float


@dataclass(frozen=True, eq=False)
class Judgement(ShortRepr):
    """The verdicts on demonstrations.

    Attributes:
        verdicts: one for each demonstration, in their order.
        error: the mean left-out error of those without faults, learned from all, as a fraction of
            the motions' extent.
        error_without: the same, learned without those to remove; never larger.
        next: goal to demonstrate next; None without a region of goals.
    """

    verdicts: tuple[Verdict, ...]
    error: float
    error_without: float
    next: Suggestion | None

    @property
    def remove(self) -> tuple[int, ...]:
        """Indices of the demonstrations to leave out."""
        return tuple(i for i, each in enumerate(self.verdicts) if each.remove)


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
    """The faults and the worth of each demonstration, and the goal to demonstrate next.

    Args:
        demonstrations: at least four of one task, all of one type and size, preferably without
            rests at their ends.
        model: fitted with each demonstration left out in turn; `ProMP()` by default.
        goals: region of the next demonstration's goal; without it there is no suggestion.
        seed: of the random number generator, for the goals that are compared.
        on: computers to use, as `leadthrough.tasks.run` takes it; None for this process.
        out: folder of finished results, made if missing; None saves nothing.
        task_timeout: largest time of one task, s; None for no bound.

    Raises:
        InvalidInput: if an argument is wrong, or there are fewer than four demonstrations.
        FitError: if a demonstration has a single sample or does not move.
        MissingDependency: for a Dask cluster, if the extra `dask` is not installed.
        SchedulerUnreachable: if its scheduler does not answer any more.
    """
    motions = motions_of(demonstrations)
    if len(motions) < _MIN_COUNT:
        raise InvalidInput(f"demonstrations: expected at least {_MIN_COUNT}, got {len(motions)}")
    learner: Model = ProMP() if model is None else model
    region = None if goals is None else _goals(goals, motions)
    number = check.integer(seed, "seed", at_least=0)
    differences = peculiarities(motions)
    suspicion = np.max([differences[trait] for trait in TRAITS], axis=0)
    with ExitStack() as stack:
        folder = out or Path(stack.enter_context(tempfile.TemporaryDirectory()))
        run = LeftOut(Material(learner, tuple(motions), region), folder, on, task_timeout)
        sound = [i for i, each in enumerate(suspicion) if each < SUSPICIOUS]
        worth = run.worth(len(motions))
        remove, before, after = run.removable(sound, np.argsort(-suspicion, kind="stable"))
        suggestion = None
        if region is not None:
            suggestion = Suggestion(*run.least_certain(remove, count=_GOALS, seed=number))
    verdicts = tuple(
        Verdict(
            _name(each, i),
            float(suspicion[i]),
            _faults(motions, differences, i),
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
    motions: Sequence[Motion], differences: dict[Trait, Float64Array], index: int
) -> tuple[Fault, ...]:
    """The faults of a demonstration, the worst first."""
    worst = sorted(TRAITS, key=lambda trait: -differences[trait][index])
    faults = [_FAULTS[trait] for trait in worst if differences[trait][index] >= SUSPICIOUS]
    if "outlier" in faults and shares_its_path(motions, index):
        faults[faults.index("outlier")] = "another mode"
    return tuple(faults)

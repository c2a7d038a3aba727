"""Quality of demonstrations: their faults, their worth for learning, and the goal to show next.

A fault is a difference from the others, in units of these others' spread (median absolute
deviation, or the usual difference of demonstrations where that is more). The worth of one is the
change of the left-out error of the others without it (deletion diagnostics; Cook 1977, "Detection
of influential observation in linear regression", Technometrics 19(1)).
"""

from __future__ import annotations

import math
import pickle
import tempfile
import warnings
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from leadthrough import check, tasks
from leadthrough.check import Float64Array, InvalidInput, LeadthroughError, ShortRepr
from leadthrough.models import Model, ProMP, Skill, Target, TargetRegion
from leadthrough.models.learn import MAX_ROWS
from leadthrough.models.protocol import Demonstrations, fit_all, motions_of
from leadthrough.motion import Motion, lerp, target_of, thin
from leadthrough.preprocess import arc_length, by_arc_length
from leadthrough.preprocess.align import features
from leadthrough.tasks import Row, Store, Task

Trait = Literal["shape", "timing", "jerk", "stall"]
TRAITS: tuple[Trait, ...] = get_args(Trait)
Fault = Literal["outlier", "another mode", "misaligned", "jerky", "stalled"]
"""Faults of a demonstration.

An outlier has a path of its own, one of another mode a path that some others share; a misaligned
one has the same path at other times; a jerky one trembles; a stalled one rests in between.
"""

SUSPICIOUS = 3.0  # usual differences; from here on it is a fault
_MIN_COUNT = 2
_FAULTS: dict[Trait, Fault] = {
    "shape": "outlier",
    "timing": "misaligned",
    "jerk": "jerky",
    "stall": "stalled",
}
_GOALS = 100  # at random, of which the least certain is suggested
_SAMPLES = 200
_DT = 0.01  # of generated motions, s, unless they are so long that fewer steps are enough
_STEPS = 2000
_WINDOW = 11  # samples, of a twentieth of the duration: quicker movements are tremor
_ALONG = 100  # points of a path at which shapes are compared
_STILL = 0.1  # of the mean speed: slower is a rest
# Usual differences of demonstrations of one task: of shapes in extents, of timing in durations, of
# tremor in powers of ten, of rests in durations.
_USUAL: dict[Trait, float] = {"shape": 0.03, "timing": 0.05, "jerk": 0.12, "stall": 0.03}
_SHARED = 0.5  # of the distance from the middle path: nearer than this is the same path
_MIN_TREMOR = 1e-4  # of the extent


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
        demonstrations: at least two of one task, all of one type and size, preferably without
            rests at their ends.
        model: fitted with each demonstration left out in turn; `ProMP()` by default.
        goals: region of the next demonstration's goal; without it there is no suggestion.
        seed: of the random number generator, for the goals that are compared.
        on: computers to use, as `leadthrough.tasks.run` takes it; None for this process.
        out: folder of finished results, made if missing; None saves nothing.
        task_timeout: largest time of one task, s; None for no bound.

    Raises:
        InvalidInput: if an argument is wrong, or there are fewer than two demonstrations.
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
    suspicion, faults = suspicions(motions)
    with ExitStack() as stack:
        folder = out or Path(stack.enter_context(tempfile.TemporaryDirectory()))
        few = tuple(thin(motion, MAX_ROWS) for motion in motions)
        run = LeftOut(Material(learner, few, region), folder, on, task_timeout)
        sound = [i for i, each in enumerate(suspicion) if each < SUSPICIOUS]
        worth = run.worth(len(motions))
        remove, before, after = run.removable(sound, np.argsort(-suspicion, kind="stable"))
        suggestion = None
        if region is not None:
            suggestion = Suggestion(*run.least_certain(remove, count=_GOALS, seed=number))
    verdicts = tuple(
        Verdict(
            getattr(each, "name", "") or f"demonstration {i + 1}",
            float(suspicion[i]),
            faults[i],
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


def suspicions(motions: Sequence[Motion]) -> tuple[Float64Array, list[tuple[Fault, ...]]]:
    """Largest difference (m,) of each motion from the others, in usual differences, and faults."""
    differences = peculiarities(motions)
    suspicion = np.max([differences[trait] for trait in TRAITS], axis=0)
    return suspicion, [_faults(motions, differences, i) for i in range(len(motions))]


def _faults(
    motions: Sequence[Motion], differences: dict[Trait, Float64Array], index: int
) -> tuple[Fault, ...]:
    """The faults of a demonstration, the worst first."""
    worst = sorted(TRAITS, key=lambda trait: -differences[trait][index])
    faults = [_FAULTS[trait] for trait in worst if differences[trait][index] >= SUSPICIOUS]
    if "outlier" in faults and shares_its_path(motions, index):
        faults[faults.index("outlier")] = "another mode"
    return tuple(faults)


def peculiarities(motions: Sequence[Motion]) -> dict[Trait, Float64Array]:
    """Difference (m,) of each motion from the others by trait, in usual differences."""
    curves = features(motions, _SAMPLES)
    smooth = [_smoothed(curve) for curve in curves]
    values: dict[Trait, Float64Array] = {
        "shape": _unlike([_carried(by_arc_length(curve, _ALONG), smooth) for curve in smooth]),
        "timing": _unlike([_progress(curve)[:, None] for curve in smooth], largest=True),
        "jerk": np.array([_tremor(*pair) for pair in zip(curves, smooth, strict=True)]),
        "stall": np.array([_longest_stall(curve) for curve in curves]),
    }
    return {trait: _z_scores(each, _USUAL[trait]) for trait, each in values.items()}


def _smoothed(curve: Float64Array) -> Float64Array:
    """Means of neighbours; near the ends of fewer."""
    sums = np.cumsum(np.vstack([np.zeros_like(curve[:1]), curve]), axis=0)
    at = np.arange(len(curve))
    half = np.minimum(_WINDOW // 2, np.minimum(at, len(curve) - 1 - at))
    smooth: Float64Array = (sums[at + half + 1] - sums[at - half]) / (2 * half + 1)[:, None]
    return smooth


def _tremor(curve: Float64Array, smooth: Float64Array) -> float:
    rough = float(np.sqrt(((curve - smooth) ** 2).sum(axis=1).mean()))
    return float(np.log10(max(rough, _MIN_TREMOR)))


def _longest_stall(curve: Float64Array) -> float:
    """The longest rest between the ends, as a fraction of the duration."""
    speeds = np.linalg.norm(np.diff(curve, axis=0), axis=1)
    still = np.concatenate([[False], speeds < _STILL * speeds.mean(), [False]])
    edges = np.flatnonzero(np.diff(still.astype(int)))
    spans = [(a, b) for a, b in edges.reshape(-1, 2) if a > 0 and b < len(speeds)]
    return max((b - a for a, b in spans), default=0) / len(speeds)


def _progress(curve: Float64Array) -> Float64Array:
    lengths = arc_length(curve)
    return lengths / max(float(lengths[-1]), np.finfo(float).tiny)


def _carried(path: Float64Array, others: Sequence[Float64Array]) -> Float64Array:
    """A path whose ends are moved to the middle of all ends, the rest in proportion."""
    first = np.median([each[0] for each in others], axis=0)
    last = np.median([each[-1] for each in others], axis=0)
    rise = np.linspace(0.0, 1.0, len(path))[:, None]
    carried: Float64Array = path + (1.0 - rise) * (first - path[0]) + rise * (last - path[-1])
    return carried


def _unlike(curves: Sequence[Float64Array], *, largest: bool = False) -> Float64Array:
    """The mean, or largest, distance of each curve from the middle one of the others."""
    every = np.array(curves)
    return np.array(
        [
            (np.max if largest else np.mean)(
                np.linalg.norm(curve - np.median(np.delete(every, i, axis=0), axis=0), axis=1)
            )
            for i, curve in enumerate(every)
        ]
    )


def _z_scores(values: Float64Array, usual: float) -> Float64Array:
    """Robust z-scores: offset from the others' median over their scaled MAD."""
    apart = np.empty(len(values))
    for i, value in enumerate(values):
        others = np.delete(values, i)
        middle = np.median(others)
        spread = 1.4826 * np.median(np.abs(others - middle))
        apart[i] = (value - middle) / max(float(spread), usual)
    return apart


def shares_its_path(motions: Sequence[Motion], index: int) -> bool:
    """Whether a motion's path is that of another, much rather than the middle one of all others."""
    smooth = [_smoothed(curve) for curve in features(motions, _SAMPLES)]
    paths = np.array([_carried(by_arc_length(curve, _ALONG), smooth) for curve in smooth])
    others = np.delete(paths, index, axis=0)
    apart = np.linalg.norm(others - paths[index], axis=2).mean(axis=1)
    middle = np.linalg.norm(np.median(others, axis=0) - paths[index], axis=1).mean()
    return bool(apart.min() < _SHARED * middle)


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
        self._file = tasks.pickled(material, folder / "demonstrations.pickle")
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
    common: Material = pickle.loads(material.read_bytes())
    return [
        {"tested": i, "error": _error(common, {*without, i}, common.motions[i])} for i in tested
    ]


def uncertainties(
    *, without: Sequence[int], slope: float, count: int, seed: int, material: Path
) -> list[Row]:
    """A row for each random goal: the uncertainty of a motion to it."""
    common: Material = pickle.loads(material.read_bytes())
    assert common.goals is not None  # asked for only then
    rng = np.random.default_rng(seed)
    used = [i for i in range(len(common.motions)) if i not in set(without)]
    ends = goals_of([common.motions[i] for i in used])
    skills = [_learned(common, {*without, i}) for i in used]
    duration = max(motion.duration for motion in common.motions)
    rows = []
    for _ in range(count):
        goal = np.asarray(common.goals.draw(rng), dtype=np.float64)
        apart = _spread([skill for skill in skills if skill is not None], goal, duration)
        away = float(np.linalg.norm(ends - goal, axis=1).min())
        numbers = [float(number) for number in goal]
        rows.append({"goal": numbers, "uncertainty": math.hypot(apart, slope * away)})
    return rows


def goals_of(motions: Sequence[Motion]) -> Float64Array:
    return np.array([each.positions[-1] for each in motions])


def _learned(common: Material, without: set[int]) -> Skill[Motion] | None:
    others = [motion for i, motion in enumerate(common.motions) if i not in without]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the judgement reports it
        try:
            return fit_all(common.model, others)
        except LeadthroughError:
            return None


def _generated(
    skill: Skill[Motion], start: Target | None, goal: Target, duration: float
) -> Motion | None:
    query = {"goal": goal} if start is None else {"start": start, "goal": goal}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            dt = max(_DT, duration / _STEPS)
            return skill.generate(**query, dt=dt)  # type: ignore[arg-type]  # the two ends alone
        except LeadthroughError:
            return None


def _error(common: Material, without: set[int], expected: Motion) -> float:
    """The mean distance at evenly spaced times, in extents of the expected motion."""
    skill = _learned(common, without)
    made = (
        None
        if skill is None
        else _generated(skill, target_of(expected, 0), target_of(expected, -1), expected.duration)
    )
    if made is None:
        return _FAILED
    ours, theirs = features([made, expected], _SAMPLES)
    return float(np.linalg.norm(ours - theirs, axis=1).mean())


def _spread(skills: Sequence[Skill[Motion]], goal: Target, duration: float) -> float:
    """Root mean square distance of the skills' motions from their mean, in their unit."""
    motions = [_generated(skill, None, goal, duration) for skill in skills]
    even = np.linspace(0.0, 1.0, _SAMPLES)
    paths = [
        lerp(each.times[0] + even * each.duration, each.times, each.positions)
        for each in motions
        if each is not None
    ]
    if len(paths) < 2:
        return 0.0
    return float(np.sqrt(np.var(paths, axis=0).sum(axis=1).mean()))

"""Results of a validation: certificate, causes of failures, and bounds of the success rate.

Source: Clopper and Pearson 1934, "The use of confidence or fiducial limits illustrated in the case
of the binomial", Biometrika 26(4). Robbins 1970, "Statistical methods related to the law of the
iterated logarithm", Ann. Math. Stat. 41(5): a likelihood ratio against a mixture of alternatives
exceeds 1 / alpha at any time with a probability of at most alpha (Ville's inequality).
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import betaincinv, betaln, xlog1py, xlogy

from leadthrough import check
from leadthrough.check import Float64Array, ShortRepr
from leadthrough.models import Certificate, TargetRegion
from leadthrough.tasks import Row


@dataclass(frozen=True, eq=False)
class Failing(ShortRepr):
    """A query whose motion the arm cannot run.

    Attributes:
        number: of the query; with the seed it draws the query again.
        start: (d,), or of a pose (7,): position and w, x, y, z.
        goal: as the start.
        cause: in a word.
        detail: in a sentence.
        distance: from the middle of the goals, m (rad).
    """

    number: int
    start: Float64Array
    goal: Float64Array
    cause: str
    detail: str
    distance: float


@dataclass(frozen=True, eq=False)
class Validation(ShortRepr):
    """Success of a skill's motions on an arm.

    Attributes:
        certificate: the fractions and regions; `skill.certified(...)` keeps it with the skill.
        starts: (runs, d) of the queries, of poses (runs, 7).
        goals: (runs, d) of the queries, as the starts.
        causes: (runs,) why each failed, in a word; empty where it succeeded.
        nearest: the failing query nearest to the middle of the goals; None if none failed.
        errors: number of queries that were not answered, because a task failed; they count as
            failures, with the cause "error".
    """

    certificate: Certificate
    starts: Float64Array
    goals: Float64Array
    causes: NDArray[np.str_]
    nearest: Failing | None
    errors: int

    @property
    def succeeded(self) -> NDArray[np.bool_]:
        """(runs,) whether the arm can run the motion."""
        return np.asarray(self.causes == "")

    def __str__(self) -> str:
        return str(self.certificate)


# The cause of queries whose task failed.
ERROR = "error"
# Parts of the region of goals that are looked at: about its middle, by the length of their sides.
_PARTS = np.linspace(1.0, 0.1, 10)


class Findings:
    """Results up to now."""

    def __init__(self, goals: TargetRegion, confidence: float) -> None:
        """Nothing found yet."""
        self._goals = goals
        self._confidence = confidence
        self._starts: list[Float64Array] = []
        self._places: list[Float64Array] = []
        self._causes: list[str] = []
        self._nearest: Failing | None = None
        self.batches = 0
        self.causes: Counter[str] = Counter()

    def add(self, rows: Sequence[Row]) -> None:
        """Takes the answers of a task."""
        self.batches += 1
        self._starts += [_numbers(row["start"]) for row in rows]
        self._places += [_numbers(row["goal"]) for row in rows]
        self._causes += [row["cause"] for row in rows]
        for row in rows:
            if row["cause"]:
                self.causes[row["cause"]] += 1
                self._look_at(row)

    @property
    def runs(self) -> int:
        """Number of queries."""
        return len(self._causes)

    @property
    def successes(self) -> int:
        """Number of queries that succeeded."""
        return self.runs - self.causes.total()

    @property
    def interval(self) -> tuple[float, float]:
        """Bounds of the fraction that succeeds, where the number of runs was fixed before."""
        return clopper_pearson(self.successes, self.runs, confidence=self._confidence)

    @property
    def sequence(self) -> tuple[float, float]:
        """Bounds of the fraction that succeeds, where one stops as they are narrow enough."""
        return confidence_sequence(self.successes, self.runs, confidence=self._confidence)

    def largest_part(self, required: float) -> TargetRegion | None:
        """The largest part of the goals, about their middle, in which enough queries succeed."""
        # For the lower of the two bounds alone, in all parts at once.
        each = 1.0 - 2.0 * (1.0 - self._confidence) / len(_PARTS)
        positions = _stacked(self._places)[:, : len(self._goals.lower)]
        if not positions.size:
            return None  # no query was answered
        succeeded = np.array([not cause for cause in self._causes])
        for factor in _PARTS:
            part = self._goals.shrunk(float(factor))
            inside = ((positions >= part.lower) & (positions <= part.upper)).all(axis=1)
            good, runs = int(succeeded[inside].sum()), int(inside.sum())
            if runs and clopper_pearson(good, runs, confidence=each)[0] >= required:
                return part
        return None

    def validation(self, certificate: Certificate) -> Validation:
        """All that was found."""
        places, causes = _stacked(self._places), np.array(self._causes)
        starts = _stacked(self._starts)
        return Validation(certificate, starts, places, causes, self._nearest, self.causes[ERROR])

    def _look_at(self, row: Row) -> None:
        """Keeps a failure that is nearer to the middle of the goals than those before."""
        if row["goal"] is None:
            return
        goal = _numbers(row["goal"])
        away = float(np.linalg.norm(goal[: len(self._goals.lower)] - self._goals.middle))
        if self._nearest is None or away < self._nearest.distance:
            start, told = _numbers(row["start"]), (row["cause"], row["detail"])
            self._nearest = Failing(row["number"], start, goal, *told, away)


def _numbers(place: Sequence[float] | None) -> Float64Array:
    """A place as an array; an empty one where there was no answer."""
    return np.array(place or (), dtype=np.float64)


def _stacked(places: Sequence[Float64Array]) -> NDArray[np.float64]:
    """Places (runs, d), NaN of those that were not answered."""
    found = np.full((len(places), max(map(len, places), default=0)), np.nan)
    for row, place in zip(found, places, strict=True):
        row[: len(place)] = place
    return found


# The mixture is Jeffreys' prior of a fraction: Beta(1/2, 1/2).
_PRIOR = 0.5
_SMALLEST = 1e-15  # fraction: the bounds lie between this and 1 less this


def clopper_pearson(successes: int, runs: int, *, confidence: float = 0.95) -> tuple[float, float]:
    """Clopper-Pearson bounds of the success rate, for a number of runs fixed in advance.

    Args:
        successes: number of runs that succeeded.
        runs: number of all runs, >= 1.
        confidence: probability, in (0, 1), with which the bounds hold at least.
    """
    count, total = _counted(successes, runs)
    rest = 0.5 * (1.0 - check.number(confidence, "confidence", above=0.0, below=1.0))
    low = 0.0 if count == 0 else float(betaincinv(count, total - count + 1, rest))
    high = 1.0 if count == total else float(betaincinv(count + 1, total - count, 1.0 - rest))
    return low, high


def confidence_sequence(
    successes: int, runs: int, *, confidence: float = 0.95
) -> tuple[float, float]:
    """Lower and upper bound of the fraction that succeeds, valid whenever one stops to look.

    With the stated probability the bounds hold after every number of runs at once, so one may stop
    as soon as they are narrow enough.

    Args:
        successes: number of runs that succeeded until now.
        runs: number of all runs until now, >= 1.
        confidence: probability, in (0, 1), with which all bounds hold at least.
    """
    count, total = _counted(successes, runs)
    alpha = 1.0 - check.number(confidence, "confidence", above=0.0, below=1.0)
    failures = total - count
    mixed = betaln(_PRIOR + count, _PRIOR + failures) - betaln(_PRIOR, _PRIOR)

    def excess(fraction: float) -> float:
        """Of the logarithm of the likelihood ratio over that of 1 / alpha."""
        single = xlogy(count, fraction) + xlog1py(failures, -fraction)
        return float(mixed - single + math.log(alpha))

    best = count / total
    low = high = best
    if count > 0:
        low = float(brentq(excess, _SMALLEST, best)) if excess(_SMALLEST) > 0.0 else 0.0
    if failures > 0:
        top = 1.0 - _SMALLEST
        high = float(brentq(excess, best, top)) if excess(top) > 0.0 else 1.0
    return low, high


def _counted(successes: int, runs: int) -> tuple[int, int]:
    total = check.integer(runs, "runs", at_least=1)
    return check.integer(successes, "successes", at_least=0, at_most=total), total

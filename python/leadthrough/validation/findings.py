"""The answers to queries as they come, in little memory, and what follows from them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array
from leadthrough.models.certificate import Certificate
from leadthrough.models.places import Places
from leadthrough.tasks import Row
from leadthrough.validation.statistics import clopper_pearson, confidence_sequence, lower_bound
from leadthrough.validation.validation import Failing, Validation

# The cause of queries whose task failed.
ERROR = "error"
# Parts of the region of goals that are looked at: about its middle, by the length of their sides.
_PARTS = np.linspace(1.0, 0.1, 10)


class Findings:
    """What was found until now."""

    def __init__(self, goals: Places, confidence: float) -> None:
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

    def largest_part(self, required: float) -> Places | None:
        """The largest part of the goals, about their middle, in which enough queries succeed."""
        each = 1.0 - (1.0 - self._confidence) / len(_PARTS)
        positions = _stacked(self._places)[:, : len(self._goals.lower)]
        succeeded = np.array([not cause for cause in self._causes])
        for factor in _PARTS:
            part = self._goals.shrunk(float(factor))
            inside = ((positions >= part.lower) & (positions <= part.upper)).all(axis=1)
            good, runs = int(succeeded[inside].sum()), int(inside.sum())
            if runs and lower_bound(good, runs, confidence=each) >= required:
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

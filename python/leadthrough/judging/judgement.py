"""What was found of demonstrations."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from leadthrough.check import Float64Array
from leadthrough.repr import ShortRepr

Fault = Literal["outlier", "another mode", "out of step", "jerky", "stalled"]
"""What may be wrong with a demonstration.

An outlier has a path of its own, one of another mode a path that others share, but not most; one
out of step shows the same at other times; a jerky one trembles; a stalled one stands still in
between.
"""


@dataclass(frozen=True, eq=False)
class Verdict(ShortRepr):
    """What was found of one demonstration.

    Attributes:
        name: of the demonstration.
        suspicion: how many usual differences it is from the others, in what it differs most; from
            3 on it has faults.
        faults: what is wrong with it, the worst first.
        worth: by which fraction the left-out error of the others grows without it; negative where
            they are predicted better without it.
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
    """The goal whose demonstration would tell most.

    Attributes:
        goal: (d,), in the demonstrations' unit.
        uncertainty: how wrong a motion to it may be, in the same unit: how far the motions lie
            apart that are learned with one demonstration left out each (root mean square over
            time), and the left-out error for each m that a goal is away from the nearest one shown.
    """

    goal: Float64Array
    uncertainty: float


@dataclass(frozen=True, eq=False)
class Judgement(ShortRepr):
    """What was found of demonstrations.

    Attributes:
        verdicts: one for each demonstration, in their order.
        error: the mean left-out error of those without faults, learned from all, as a fraction of
            the motions' extent.
        error_without: the same, learned without those to remove; never larger.
        next: what to show next; None if no region was asked for.
    """

    verdicts: tuple[Verdict, ...]
    error: float
    error_without: float
    next: Suggestion | None

    @property
    def remove(self) -> tuple[int, ...]:
        """Indices of the demonstrations to leave out."""
        return tuple(i for i, each in enumerate(self.verdicts) if each.remove)

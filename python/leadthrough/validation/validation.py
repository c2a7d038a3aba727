"""What a validation found: the certificate, and each query with why it failed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array
from leadthrough.models.certificate import Certificate
from leadthrough.repr import ShortRepr


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
    """How often a skill's motions succeed on an arm.

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

"""Why a skill is of its family."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Choice:
    """The families that were compared, and what left-out demonstrations told.

    Attributes:
        chosen: name of the family that was chosen.
        errors: for each family its mean distance from left-out demonstrations along the motion, as
            a fraction of the extent; infinite for one that cannot learn or reproduce them.
        left_out: number of demonstrations that were left out, one at a time.
    """

    chosen: str
    errors: dict[str, float]
    left_out: int

    def __str__(self) -> str:
        if not self.left_out:
            return f"{self.chosen}: the default, as a single demonstration cannot be left out"
        ranked = sorted(self.errors.items(), key=lambda each: each[1])
        shown = ", ".join(f"{name} {error:.2%}" for name, error in ranked)
        return f"{self.chosen}: nearest to {self.left_out} left-out demonstrations ({shown})"

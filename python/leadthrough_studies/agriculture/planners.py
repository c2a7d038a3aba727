"""The planners that the agriculture study compares; the last one is the package's default."""

from __future__ import annotations

from dataclasses import replace

from leadthrough.models import DMP

PLANNERS = {
    "euler": DMP(50, orientation="euler"),
    "log": DMP(50, orientation="log"),
    "lifted": DMP(50, orientation="lifted"),
    "lauretti": DMP.lauretti(),
    "anchored": DMP(50),
}


def planner_of(name: str, *, weights: int | None = 50) -> DMP:
    """The planner of a name in PLANNERS, with a number of kernels per channel."""
    return replace(PLANNERS[name], weights=weights)

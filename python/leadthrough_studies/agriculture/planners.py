"""The planners that the agriculture study compares; the last one is the package's default."""

from __future__ import annotations

from dataclasses import replace

from leadthrough.models import PoseDMP

PLANNERS = {
    "euler": PoseDMP(orientation="euler"),
    "log": PoseDMP(orientation="log"),
    "lifted": PoseDMP(orientation="lifted"),
    "lauretti": PoseDMP.lauretti(),
    "anchored": PoseDMP(),
}


def planner_of(name: str, *, weights: int | None = 50) -> PoseDMP:
    """The planner of a name in PLANNERS, with a number of kernels per channel."""
    return replace(PLANNERS[name], weights=weights)

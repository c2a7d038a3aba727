"""Table 1 of Prados et al. 2023: stability, one demonstration and higher dimensions.

In the paper "single-step learning" says whether one demonstration is enough (section 1: "they do
not work with a single demonstration"). Motions in space are reaches of the workspace study.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from leadthrough.errors import LeadthroughError
from leadthrough.io import lasa
from leadthrough_studies.demonstrator import Teaching
from leadthrough_studies.lasa.methods import system
from leadthrough_studies.study import Row
from leadthrough_studies.ur3.setups import demonstrations

STARTS = 500
_MOTIONS = ("Angle", "GShape", "Line", "Sshape")  # the first one's stability is tested
_FARTHEST = 0.25  # from the demonstration, as a fraction of its extent


def of_system(*, method: str, seed: int) -> list[Row]:
    """A row with what a system can do.

    Args:
        method: key of SYSTEMS.
        seed: seed of the person who demonstrates in space.
    """
    drawn, in_space = [lasa.load(name) for name in _MOTIONS], demonstrations(1, Teaching(), seed)
    report = system(method).fit(drawn[0]).stability(STARTS)
    row = {"starts": report.starts, "arrived": report.arrived, "violations": report.violations}
    row["drawings"] = len(drawn)
    row["from_one"] = sum(_reproduces(method, shown[:1]) for shown in drawn)
    row["in_space"] = _reproduces(method, in_space)
    return [{"study": "characteristics", "method": method, **row}]


def _reproduces(method: str, shown: list[Any]) -> int:
    """Whether the system learns demonstrations and stays near the first one."""
    wanted = shown[0].motion.positions
    try:
        made = system(method).fit(shown).generate(start=wanted[0])
    except LeadthroughError:
        return 0
    gaps = np.linalg.norm(made.positions[:, None] - wanted, axis=2).min(axis=1)
    extent = float(np.ptp(wanted, axis=0).max())
    ends = float(np.linalg.norm(made.positions[-1] - np.mean([_end(each) for each in shown], 0)))
    return int(gaps.max() < _FARTHEST * extent and ends < 0.01 * extent)


def _end(demonstration: Any) -> Any:
    return demonstration.motion.positions[-1]

"""Success of the planners over many persons, as our postures stand and with others.

The measures need no arm: `of_seed` demonstrates every subtask and lets every planner replay it.
Whether a coordinate jumps depends on how the tool is held, which the paper does not state. So each
person also demonstrates with postures of their own (`tasks.drawn`). Of these, demonstrations in
which the arm would touch itself or the floor are left out, as are targets out of reach.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.stats import wilcoxon

from leadthrough.arm import Arm
from leadthrough.check import Float64Array
from leadthrough.errors import FitError, InvalidInput
from leadthrough.motion import Demonstration, PoseTrajectory
from leadthrough_studies import intervals
from leadthrough_studies.agriculture.measures import FASTEST, judged
from leadthrough_studies.agriculture.planners import planner_of
from leadthrough_studies.agriculture.skills import DURATION, PLANNED_STEP, STEP, Shown, show
from leadthrough_studies.agriculture.tasks import (
    CHOSEN,
    TASKS,
    Holding,
    Subtask,
    drawn,
    floor,
    load_arm,
)
from leadthrough_studies.study import Row, cpu_time, mean, selected

POSTURES = ("chosen", "drawn")
OWN = "lauretti"
_ALIKE = "lifted"  # the paper's representation, with the fit of the others
_COMPARISONS = 3  # of the paper's three planners, Bonferroni's correction
_ALL, _DRAWN_SUBTASK = "all", "4-4"  # the subtask of the paper's figures 8 to 10
_TOLERANCE = 1e-3  # m, of the check between samples
_MEASURES = (
    "sr_mod_percent",
    "without_jump_percent",
    "below_own",
    "npe",
    "npe_sd",
    "noe",
    "noe_sd",
    "npe_gap",
    "noe_p",
    "plan_cpu_s",
    "shown_min",
)


def of_seed(
    *, postures: str, tasks: list[str], planners: list[str], repetitions: list[int], seed: int
) -> list[Row]:
    """A row for each task, all of them and subtask 4-4, and each planner: success of a person."""
    arm = load_arm()
    holding = CHOSEN if postures == "chosen" else drawn(np.random.default_rng(seed))
    person: Any = {"holding": holding, "seed": seed}
    trials = [
        {"task": task, "subtask": subtask.number, "planner": name, "shown_s": shown.poses.duration}
        | _replayed(name, shown.poses)
        for task in tasks
        for subtask in TASKS[task]
        for i in repetitions
        if (shown := _demonstrated(arm, task, subtask, i, **person)) is not None
        for name in planners
    ]
    parts = {task: selected(trials, task=task) for task in tasks}
    parts |= {_ALL: trials, _DRAWN_SUBTASK: selected(trials, subtask=_DRAWN_SUBTASK)}
    labels = {"study": "persons", "seed": seed, "postures": postures}
    return [
        {**labels, "part": part, "planner": name, **_summary(own, name)}
        for part, own in parts.items()
        for name in planners
        if selected(own, planner=name)
    ]


def _demonstrated(
    arm: Arm, task: str, subtask: Subtask, i: int, *, holding: Holding, seed: int
) -> Shown | None:
    """The demonstration, or None if the arm cannot make it."""
    try:
        shown = show(arm, task, subtask, i, seed=seed, holding=holding)
    except RuntimeError:  # the target is out of reach
        return None
    if holding is not CHOSEN and not arm.check(shown.joints, [floor()], tolerance=_TOLERANCE).ok:
        return None
    return shown


def _replayed(planner: str, shown: PoseTrajectory) -> Row:
    try:
        skill = planner_of(planner).fit([Demonstration(shown)])
        made = skill.generate(duration=DURATION, dt=STEP)
    except (FitError, InvalidInput):
        return {"succeeded": 0, "jumped": 1}
    row = judged(made, shown)
    plan_s = cpu_time(lambda: skill.generate(duration=DURATION, dt=PLANNED_STEP))
    return row | {"jumped": int(row["fastest_deg_s"] > FASTEST), "plan_cpu_s": plan_s}


def _summary(trials: list[Row], planner: str) -> Row:
    rows, own, alike = (selected(trials, planner=name) for name in (planner, OWN, _ALIKE))
    percent = 100.0 * (mean(rows, "succeeded") or 0.0)
    npe, noe = _known(rows, "npe"), _known(rows, "noe")
    return {
        "trials": len(rows),
        "sr_mod_percent": percent,
        "without_jump_percent": 100.0 - 100.0 * (mean(rows, "jumped") or 0.0),
        "below_own": 100.0 * (mean(own, "succeeded") or 0.0) - percent if own else None,
        "npe": float(np.mean(npe)),
        "npe_sd": float(np.std(npe)),
        "noe": float(np.mean(noe)),
        "noe_sd": float(np.std(noe)),
        "npe_gap": float(np.abs(_gaps(rows, alike, "npe")).max(initial=0.0)),
        "noe_p": _p_value(_gaps(rows, alike, "noe")),
        "plan_cpu_s": mean(rows, "plan_cpu_s"),
        "shown_min": sum(row["shown_s"] for row in rows) / 60.0,
    }


def _known(rows: list[Row], column: str) -> list[float]:
    return [row[column] for row in rows if row.get(column) is not None]


def _gaps(rows: list[Row], others: list[Row], column: str) -> Float64Array:
    """Differences of the same trials of two planners, which are in the same order."""
    pairs = zip(rows, others, strict=False)
    both = [(row.get(column), other.get(column)) for row, other in pairs]
    return np.array([a - b for a, b in both if a is not None and b is not None])


def _p_value(gaps: Float64Array) -> float:
    """Of Wilcoxon's signed-rank test, as corrected for the paper's comparisons."""
    return min(1.0, _COMPARISONS * float(wilcoxon(gaps).pvalue)) if gaps.any() else 1.0


def table(rows: list[Row]) -> list[Row]:
    """Medians over persons with their intervals, by postures, part and planner."""
    keys = dict.fromkeys((row["postures"], row["part"], row["planner"]) for row in rows)
    lines = []
    for postures, part, planner in keys:
        own = selected(rows, postures=postures, part=part, planner=planner)
        line: Row = {"postures": postures, "part": part, "planner": planner, "persons": len(own)}
        line["trials"] = sum(row["trials"] for row in own)
        for name in _MEASURES:
            values = [row[name] for row in own if row[name] is not None]
            found = intervals.median(values) if values else {}
            line |= {f"{name}_{each}": found.get(each) for each in ("median", "low", "high")}
        lines.append(line)
    return lines

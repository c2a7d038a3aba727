"""Table, statistics and figures of the agriculture study, the paper's numbers beside ours.

The paper prints means over the tasks. For its own planner these are NPE .05 +- .01, NOE .07 +- .11
and a success of 100 %, which it calls an improvement of 55.75 over Euler angles and of 24.25 over
the plain logarithm (we read these as percentage points). By task it only says that Euler angles
stay below 40 % in harvesting and seeding, and the plain logarithm in irrigation.

Differences and their causes: Euler angles fail where an angle wraps at half a turn, which depends
on the orientation of the base frame, and near gimbal lock. The plain logarithm fails where the tool
is half a turn away from its final orientation. The affected subtasks depend on how the hand
was held, which is not public. Our person turns the tool by 150 to 500 degrees in most subtasks,
more than half a turn away from the goal in all but four. So the plain logarithm fails more often
than in the paper, not only in irrigation, and about as often as Euler angles. A failed motion
spins: it makes up to a full turn in a quarter of a second, faster than any wrist. Its mean error
remains small, because the spin is short, and it reaches its end; so NOE reveals less of a failure
than SR-MOD. NPE is smaller than the paper's by an order of magnitude: it compares the primitive
with the recording, without the control of a robot, and 50 kernels are fitted to replay it.

"lauretti", the paper's planner by its own equations, has an NPE of .006, an NOE of .007 and no
failure in the 144 trials of any of ten persons, as the paper claims; with postures of their own,
two or more of them have a failure. Its errors are three and seven times those of "lifted": locally
weighted regression fits each kernel by itself. With kernels evenly spaced in the phase, as in the
paper's appendix, the NPE is .02.

persons: whether a coordinate jumps depends on the postures, not on who moves: with ours, the
success of a planner is the same for ten persons; with postures of their own, Euler angles have 21
to 36 % and the plain logarithm 24 to 62 %. The paper's 44 and 76 % are above both.

arm_did: the joints followed the tool's motion, kept all limits after slowing down, and nothing
collided. The arm has one redundant joint and three wrist joints with small ranges. If it is pulled
to the middle of its ranges, large tool rotations drive a wrist joint to its limit, and only a jump
leads to another posture; two of the 13 whole digging tasks then succeed. The demonstrations
contain suitable postures: the joints are learned, looked up and generated like the tool's motion,
and `follow` keeps the arm near them. Whole tasks between the targets count with interpolated
skills.

lookups: motions for positions between four targets, compared with demonstrations there after
alignment in time. The paper uses the parameters of the nearest target. Its motion, moved to the
target, keeps the orientation for a position 7 cm away, and the arm cannot follow where digging has
the elbow at its limit. A motion interpolated between the neighbours is several times closer to the
demonstration, and every whole task succeeds. (Aligning the demonstrations by time warping first did
not improve the means.)
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import Any

import numpy as np
from scipy.stats import wilcoxon

from leadthrough_studies import physics
from leadthrough_studies.agriculture import (
    figures,
    measures,
    persons,
    printed,
    recordings,
    skills,
    tasks,
)
from leadthrough_studies.agriculture.paper import BELOW_40, PRINTED, SIGNIFICANT
from leadthrough_studies.study import Report, Row, selected

_ALL = "all"
_DRAWN = "4-4"  # the subtask of the paper's figures 8 to 10
_POWER = (
    "A signed-rank test on n pairs cannot give a p below 2 / 2^n, and Bonferroni's correction "
    "multiplies it by the {count} comparisons: at least {needed} pairs are needed for p < {level}, "
    "even if one planner wins all of them. The least number of pairs here is {least}; where "
    "can_show is 0, no outcome could have been significant, so that a missing star says nothing "
    "there. A significant p says that one planner's errors are usually smaller, not by how much, "
    "and repetitions by one simulated person with one seed are not independent persons."
)


def report(config: Any, rows: list[Row]) -> Report:
    """A row for every task and planner; tests, look-ups and recordings in the summary."""
    subtasks, wholes, replayed = (
        selected(rows, study=name) for name in ("subtasks", "whole", "recordings")
    )
    tests = [
        _compared(subtasks, task, pair, len(config.planners))
        for task in (*config.tasks, _ALL)
        for pair in combinations(config.planners, 2)
    ]
    lines = [(task, planner) for task in (*config.tasks, _ALL) for planner in config.planners]
    told = Report(
        table=[_line(_of(subtasks, *line), _of(wholes, *line), *line) for line in lines],
        figures=figures.draw(config, subtasks, wholes, tests),
        summary={
            "paper": __doc__,
            "assumptions": tasks.__doc__,
            "measures": measures.__doc__,
            "details": [_details(_of(subtasks, *line), *line) for line in lines],
            "wilcoxon": tests,
            "wilcoxon_can_show": _power(tests) if tests else "",
            "lookups": _lookups(rows, config.planners),
            "recordings": [
                _recorded(replayed, planner, weights)
                for planner in config.planners
                for weights in recordings.WEIGHTS
            ]
            if replayed
            else "no recordings were given",
        },
        tables=_tables(rows, tests, config.planners),
    )
    return _with_physics(told, wholes)


def _tables(rows: list[Row], tests: list[Row], planners: Sequence[str]) -> dict[str, list[Row]]:
    maps = [
        {name: row[name] for name in ("formula", "angle_deg", "error")}
        for row in selected(rows, study="maps")
    ]
    tables = {
        "persons": persons.table(selected(rows, study="persons")),
        "kernels": printed.kernels_table(selected(rows, study="kernels")),
        "maps": maps,
        "wilcoxon": tests,
        "lookups": _lookups(rows, planners),
        "subtasks": _of_subtask(selected(rows, study="subtasks", subtask=_DRAWN), planners),
    }
    return {name: lines for name, lines in tables.items() if lines}


def _lookups(rows: list[Row], planners: Sequence[str]) -> list[Row]:
    """Between the targets, by planner and look-up; nothing where none was run."""
    lines = [
        _looked_up(selected(rows, lookup=lookup), planner, lookup)
        for planner in planners
        for lookup in skills.LOOKUPS
    ]
    return [line for line in lines if line["whole_tasks"]]


def _of_subtask(rows: list[Row], planners: Sequence[str]) -> list[Row]:
    """Subtask 4-4, of the paper's figures 8 to 10, by planner."""
    names = ("fastest_deg_s", "largest_deg", "farthest_from_goal_deg")
    return [
        {"planner": planner, "trials": len(own), "sr_mod_percent": _percent(own, "succeeded")}
        | {name: float(np.median(_values(own, name))) for name in names if _values(own, name)}
        for planner in planners
        if (own := selected(rows, planner=planner))
    ]


def _with_physics(told: Report, wholes: list[Row]) -> Report:
    """The first whole task that the arm can do, on the simulated arm."""
    for row in wholes:
        if row.get("arm_clear") and "joints" in row:
            arm = tasks.load_arm()
            joints = physics.joints_of(row["joints"], arm)
            return physics.with_physics(told, arm, joints, obstacles=[tasks.floor()])
    return told


def _of(rows: list[Row], task: str, planner: str) -> list[Row]:
    own = selected(rows, planner=planner)
    return own if task == _ALL else selected(own, task=task)


def _line(rows: list[Row], wholes: list[Row], task: str, planner: str) -> Row:
    printed = PRINTED.get(planner, {}) if task == _ALL else {}
    paper_sr_mod = "< 40" if (task, planner) in BELOW_40 else printed.get("sr_mod")
    return {
        "task": task,
        "planner": planner,
        "trials": len(rows),
        "sr_mod_percent": _percent(rows, "succeeded"),
        "paper_sr_mod_percent": paper_sr_mod,
        "npe": _mean(rows, "npe"),
        "paper_npe": printed.get("npe"),
        "noe": _mean(rows, "noe"),
        "paper_noe": printed.get("noe"),
        "npe_of_path": _mean(rows, "npe_of_path"),
        "noe_of_angle": _mean(rows, "noe_of_angle"),
        "arm_did_percent": _percent(rows, "arm_clear"),
        "arm_did_whole_percent": _percent(_best_looked_up(wholes), "arm_clear"),
        "plan_cpu_s": _mean(rows, "plan_cpu_s"),
        "paper_plan_s": printed.get("plan_s"),
    }


def _best_looked_up(wholes: list[Row]) -> list[Row]:
    """Whole tasks for the targets, where both look-ups agree, and interpolated ones between."""
    return [row for row in wholes if row["lookup"] == "interpolated" or "target" in row["where"]]


def _looked_up(rows: list[Row], planner: str, lookup: str) -> Row:
    """Between the targets: whole tasks, and subtasks compared with demonstrations there."""
    own = selected(rows, planner=planner)
    wholes = [row for row in selected(own, study="whole") if "amid" in row["where"]]
    looked_up = selected(own, study="lookup")
    return {
        "planner": planner,
        "lookup": lookup,
        "whole_tasks": len(wholes),
        "arm_did_whole_percent": _percent(wholes, "arm_clear"),
        "subtasks": len(looked_up),
        "refused": sum("refused" in row for row in looked_up),
        **{name: _mean(looked_up, name) for name in ("mean_m", "mean_deg", "end_m", "end_deg")},
    }


def _details(rows: list[Row], task: str, planner: str) -> Row:
    """Further numbers. "limits_kept" holds after slowing down by the factor "slowing"."""
    return {
        "task": task,
        "planner": planner,
        "npe_sd": _spread(rows, "npe"),
        "noe_sd": _spread(rows, "noe"),
        "refused": sum("refused" in row for row in rows),
        "followed_percent": _percent(rows, "followed"),
        "limits_kept_percent": _percent(rows, "limits_kept"),
        "slowing": _mean(rows, "slowing"),
        "fit_cpu_s": _mean(rows, "fit_cpu_s"),
        "plan_cpu_s_sd": _spread(rows, "plan_cpu_s"),
    }


def _values(rows: list[Row], column: str) -> list[float]:
    return [row[column] for row in rows if row.get(column) is not None]


def _mean(rows: list[Row], column: str) -> float | None:
    values = _values(rows, column)
    return float(np.mean(values)) if values else None


def _spread(rows: list[Row], column: str) -> float | None:
    values = _values(rows, column)
    return float(np.std(values)) if values else None


def _percent(rows: list[Row], column: str) -> float | None:
    """The percentage of all rows, including those without the column."""
    return 100.0 * sum(bool(row.get(column)) for row in rows) / len(rows) if rows else None


def _compared(rows: list[Row], task: str, pair: tuple[str, str], planners: int) -> Row:
    """Wilcoxon's signed-rank test on the trials of two planners, with Bonferroni correction."""
    count = planners * (planners - 1) // 2
    found: Row = {"task": task, "planners": " and ".join(pair), "comparisons": count}
    first, second = ({_trial(row): row for row in _of(rows, task, each)} for each in pair)
    for column in ("npe", "noe"):
        both = [
            (first[trial][column], second[trial][column])
            for trial in first
            if first[trial].get(column) is not None
            and second.get(trial, {}).get(column) is not None
        ]
        gaps = np.array([a - b for a, b in both])
        p = float(wilcoxon(gaps).pvalue) if gaps.any() else 1.0
        least = min(1.0, count * 2.0 ** (1 - len(both)))
        found |= {
            f"{column}_pairs": len(both),
            f"{column}_p": min(1.0, count * p),
            f"{column}_least_p": least,
            f"{column}_can_show": int(least < SIGNIFICANT),
        }
    return found


def _power(tests: list[Row]) -> str:
    """Differences that tests on this many pairs can show."""
    pairs = sorted({test["noe_pairs"] for test in tests})
    count = tests[0]["comparisons"]
    needed = next(n for n in range(1, 100) if count * 2.0 ** (1 - n) < SIGNIFICANT)
    return _POWER.format(count=count, needed=needed, level=SIGNIFICANT, least=pairs[0])


def _trial(row: Row) -> tuple[str, str, int]:
    return row["task"], row["subtask"], row["repetition"]


def _recorded(rows: list[Row], planner: str, weights: str) -> Row:
    own = selected(rows, planner=planner, weights=weights)
    worst = {
        f"worst_{name}": max(_values(own, name), default=None)
        for name in ("rmse_m", "mean_deg", "largest_deg")
    }
    return {
        "planner": planner,
        "weights": weights,
        "motions": len(own),
        "succeeded_percent": _percent(own, "succeeded"),
        "refused": sum("refused" in row for row in own),
        "mean_deg": _mean(own, "mean_deg"),
        **worst,
    }

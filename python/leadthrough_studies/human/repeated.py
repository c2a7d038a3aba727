"""Human and damped-least-squares demonstrations over many seeds, and what the loss consists of.

The loss of a joint's peak speed is 1 - `peak_ratio` of a ProMP learned from all demonstrations. The
simulated person differs from a straight motion of the joints at minimum jerk by three factors:
timing (durations, pace, pauses), shape (postures on the way and at the end) and noise (tremor,
encoders). Each factor's part is its Shapley value: the change of the loss by adding the factor,
averaged over all orders in which the three can be added. The parts add up to the loss with all
factors less that with none.
"""

from __future__ import annotations

from itertools import combinations
from math import factorial

import numpy as np

from leadthrough.arm import Arm
from leadthrough.models import ProMP, ProMPSkill
from leadthrough.motion import Demonstration
from leadthrough.preprocess import align_by_time_warping
from leadthrough_studies import intervals
from leadthrough_studies.human.demonstrations import FACTORS, ROBOT, damped, human
from leadthrough_studies.human.measures import fidelity
from leadthrough_studies.human.polynomial import PolynomialMean, polynomial_mean
from leadthrough_studies.study import Row, selected

_MEASURES = ("peak_ratio", "velocity_rmse_percent", "reversals_learned", "bell_distance_learned")
# A peak changed by less is neither lost nor overshot.
_SAME = 0.02


def of_seed(*, seed: int, count: int, joints: list[int], weights: int) -> list[Row]:
    """A row for each source, basis, way of learning and joint."""
    sources = {
        "human": human(count, np.random.default_rng(seed)),
        "DLS-IK": damped(Arm.load(ROBOT), count, np.random.default_rng(seed)),
    }
    rows = []
    for source, shown in sources.items():
        quickest = int(np.argmin([each.motion.duration for each in shown]))
        ways: dict[str, tuple[list[Demonstration], list[Demonstration]]] = {
            "one": (shown[:1], shown[:1]),
            "all": (shown, shown),
            "all, aligned": (align_by_time_warping(shown, reference=quickest), [shown[quickest]]),
        }
        for way, (given, compared) in ways.items():
            learned: dict[str, ProMPSkill | PolynomialMean] = {
                "Gaussian": ProMP(weights=weights).fit(given),
                "polynomial": polynomial_mean(given, weights=weights),
            }
            motions = [each.motion for each in compared]
            for basis, skill in learned.items():
                labels = {"source": source, "basis": basis, "learned_from": way}
                rows += [
                    {"study": "seeds", "seed": seed, **labels, "column": f"joint {joint}"}
                    | fidelity(skill, motions, joint - 1)
                    for joint in joints
                ]
    return rows


def losses(*, seed: int, count: int, joints: list[int], weights: int) -> list[Row]:
    """A row for each set of factors and joint: the loss of peak speed."""
    rows = []
    for size in range(len(FACTORS) + 1):
        for chosen in combinations(FACTORS, size):
            shown = human(count, np.random.default_rng(seed), factors=chosen)
            skill = ProMP(weights=weights).fit(shown)
            motions = [each.motion for each in shown]
            rows += [
                {"study": "losses", "seed": seed, "factors": list(chosen)}
                | {"column": f"joint {joint}"}
                | {"loss": 1.0 - fidelity(skill, motions, joint - 1)["peak_ratio"]}
                for joint in joints
            ]
    return rows


def table(rows: list[Row]) -> list[Row]:
    """Medians over seeds with 95 % intervals, and numbers of seeds with lost and higher peaks."""
    names = ("source", "basis", "learned_from", "column")
    lines = []
    for key in dict.fromkeys(tuple(row[name] for name in names) for row in rows):
        labels = dict(zip(names, key, strict=True))
        own = selected(rows, **labels)
        line: Row = {**labels, "seeds": len(own)}
        for measure in _MEASURES:
            found = intervals.median([row[measure] for row in own])
            line |= {f"{measure}_{name}": value for name, value in found.items()}
        peaks = np.array([row["peak_ratio"] for row in own])
        line["seeds_with_lost_peaks"] = int((peaks < 1.0 - _SAME).sum())
        line["seeds_with_higher_peaks"] = int((peaks > 1.0 + _SAME).sum())
        lines.append(line)
    return lines


def parts(rows: list[Row]) -> list[Row]:
    """Median parts of the loss by factor, with 95 % intervals over seeds and joints' means."""
    by_seed = [_shapley(selected(rows, seed=seed)) for seed in dict.fromkeys(_seeds(rows))]
    lines = []
    for name in (*FACTORS, "all", "none"):
        values = [each[name] for each in by_seed]
        total = [each["all"] - each["none"] for each in by_seed]
        line = {"part": name, "seeds": len(values), "mean": float(np.mean(values))}
        share = 100.0 * float(np.sum(values) / np.sum(total))
        lines.append(line | intervals.median(values) | {"share_percent": share})
    return lines


def _seeds(rows: list[Row]) -> list[int]:
    return [row["seed"] for row in rows]


def _shapley(rows: list[Row]) -> dict[str, float]:
    """Parts of the mean loss of the joints, and the loss with all factors and with none."""
    loss: dict[frozenset[str], float] = {}
    for row in rows:
        chosen = frozenset(row["factors"])
        own = [r["loss"] for r in rows if frozenset(r["factors"]) == chosen]
        loss[chosen] = float(np.mean(own))
    found = {"all": loss[frozenset(FACTORS)], "none": loss[frozenset()]}
    for factor in FACTORS:
        others = [each for each in FACTORS if each != factor]
        found[factor] = sum(
            factorial(size)
            * factorial(len(others) - size)
            / factorial(len(FACTORS))
            * (loss[frozenset({*before, factor})] - loss[frozenset(before)])
            for size in range(len(others) + 1)
            for before in combinations(others, size)
        )
    return found

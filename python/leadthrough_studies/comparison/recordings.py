"""Sets of recorded demonstrations in a folder: each demonstration left out in turn, ends given.

A set is a .npz file with `times_i` (n,) and `positions_i` (n, d) of each demonstration i and, of
poses, `orientations_i` (n, 4) w, x, y, z. Errors are in the set's own unit; geometric means over
all sets are relative to a method, with intervals by drawing sets again.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np

import leadthrough as lt
from leadthrough import check
from leadthrough.check import InvalidInput
from leadthrough.motion import Demonstration, PoseTrajectory, Trajectory
from leadthrough.preprocess import dtw_distance, frechet_distance
from leadthrough.preprocess.resample import by_arc_length
from leadthrough_studies import metrics
from leadthrough_studies.study import Row, selected

ERRORS = ("Frechet", "DTW", "V_rmse")
_COMPARED = 200  # evenly spaced samples
_DRAWS, _INTERVAL = 2000, (2.5, 97.5)  # of sets, %


@dataclass(frozen=True)
class Chosen:
    """The family that `lt.learn` chooses."""

    def fit(self, demonstrations: list[Demonstration[Any]]) -> Any:
        """The skill of that family."""
        return lt.learn(demonstrations)


def sets_in(folder: Path) -> tuple[tuple[str, str], ...]:
    """Names and files of the sets in a folder.

    Raises:
        InvalidInput: if there is none.
    """
    files = sorted(folder.glob("*.npz"))
    if not files:
        raise InvalidInput(f"--recordings: expected a folder with sets, *.npz, got {folder}")
    return tuple((file.stem, str(file)) for file in files)


def read(file: Path) -> list[Demonstration[Any]]:
    """The demonstrations of a set."""
    found: list[Demonstration[Any]] = []
    with np.load(file, allow_pickle=False) as stored:
        for i in count():
            if f"times_{i}" not in stored:
                break
            times, positions = stored[f"times_{i}"], stored[f"positions_{i}"]
            motion: Trajectory | PoseTrajectory = Trajectory(times, positions)
            if f"orientations_{i}" in stored:
                motion = PoseTrajectory(times, positions, stored[f"orientations_{i}"])
            found.append(Demonstration(motion, f"{file.stem} {i}"))
    if not found:
        raise InvalidInput(f"{file}: expected times_0, positions_0 and so on, got none")
    return found


def errors(tested: Trajectory | PoseTrajectory, made: Any) -> Row:
    """Errors of a motion, in the recording's unit; shapes at even steps of arc length."""
    wanted, found = (by_arc_length(each.positions, _COMPARED) for each in (tested, made))
    courses = [Trajectory(each.times, each.positions) for each in (tested, made)]
    return {
        "Frechet": frechet_distance(wanted, found),
        "DTW": dtw_distance(wanted, found) / _COMPARED,
        "V_rmse": metrics.velocity_rmse(*courses),
    }


def relative(rows: list[Row], *, reference: str, seed: int) -> list[Row]:
    """For each method the geometric mean over sets of its errors over a reference's.

    Args:
        rows: of all sets and methods.
        reference: name of a method.
        seed: seed of the random number generator that draws sets.
    """
    check.integer(seed, "seed", at_least=0)
    names = list(dict.fromkeys(row["set"] for row in rows))
    means = {
        method: _means(rows, names, method) for method in dict.fromkeys(r["method"] for r in rows)
    }
    lines = []
    for method, found in means.items():
        ratios = np.log(found / means[reference])
        known = ratios[np.isfinite(ratios).all(axis=1)]
        line: Row = {"reference": reference, "method": method}
        line |= {"sets": len(known), "refused": len(names) - len(known)}
        if len(known):
            line |= _geometric_means(known, np.random.default_rng(seed))
        lines.append(line)
    return lines


def _geometric_means(logarithms: np.ndarray, rng: np.random.Generator) -> Row:
    """Geometric means of ratios over sets (sets, 3), with intervals, and the largest of a set."""
    drawn = rng.integers(0, len(logarithms), (_DRAWS, len(logarithms)))
    line: Row = {}
    for name, own in zip(ERRORS, logarithms.T, strict=True):
        low, high = np.percentile(own[drawn].mean(axis=1), _INTERVAL)
        line |= {
            name: float(np.exp(own.mean())),
            f"{name}_low": float(np.exp(low)),
            f"{name}_high": float(np.exp(high)),
            f"{name}_most": float(np.exp(own.max())),
        }
    return line


def _means(rows: list[Row], names: list[str], method: str) -> np.ndarray:
    """Mean errors (sets, 3) of a method; NaN where it refuses a demonstration of the set."""
    found = np.full((len(names), len(ERRORS)), np.nan)
    for i, name in enumerate(names):
        own = selected(rows, set=name, method=method)
        if own and not any("refused" in row for row in own):
            found[i] = np.mean([[row[error] for error in ERRORS] for row in own], axis=0)
    return found

"""Models chosen by left-out demonstrations, and how near skills come to demonstrations."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from leadthrough import check, rotations
from leadthrough.blas_threads import one_blas_thread
from leadthrough.check import Float64Array, InvalidInput, LeadthroughError, NoPath, ShortRepr
from leadthrough.models import protocol
from leadthrough.models.protocol import Demonstrations, Model, Outliers, Skill, motions_of
from leadthrough.models.registry import model_entry
from leadthrough.motion import (
    JointTrajectory,
    Motion,
    MotionT,
    PoseTrajectory,
    in_order,
    lerp,
    target_of,
    thin,
)
from leadthrough.preprocess import arc_length, by_arc_length, frechet_distance
from leadthrough.preprocess.align import MIN_TURN, TURNING

CANDIDATES = ("aligned-mean", "fast-marching", "promp", "dmp")
_MAX_LEFT_OUT = 8  # demonstrations, evenly chosen
# Which of several predicts a few left-out demonstrations slightly better than others is chance.
_BETTER = 0.5
_STEP = 1e-3  # of the extent, between compared points of a path
MAX_ROWS = 4000  # of a demonstration that families are compared by; a long log has 600,000
_MIN_POINTS, _FEW_POINTS, _MAX_POINTS, _POINTS_A_ROW = 200, 4000, 64_000, 10
_RESOLVED = 4.0  # steps between points: a smaller distance of paths may be that of their points
_DT = 0.01  # s, at least, between rows that are generated
_EVEN = 100  # rows, evenly spaced along each motion
_CHORD = 2.0 * np.sqrt(2.0)  # Frobenius distance of opposite rotation matrices


@one_blas_thread
def learn(
    demonstrations: Demonstrations[MotionT],
    *,
    candidates: Sequence[str | Model] = CANDIDATES,
    outliers: Outliers = "refuse",
) -> Skill[MotionT]:
    """A skill of the family that predicts left-out demonstrations best.

    Each demonstration (of more than eight, eight of them) is left out, and reproduced by each
    family from the others, given its start and goal. `skill.choice` has the mean errors. The first
    candidate is taken unless another errs less than half as much.

    Args:
        demonstrations: one or more demonstrations, or motions, of one type.
        candidates: names of models, as `models.model_names`, or models with settings. Families
            that do not learn this type of motion are left out.
        outliers: treatment of a demonstration that contradicts all others: one that runs
            backwards, of another task, rotated by more than 70 degrees, or four times as fast or
            slow. "refuse" raises an error, "drop" leaves it out, "keep" learns it all the same.
            Two that agree with each other are a second way, and stay.

    Raises:
        FitError: if no candidate can learn the demonstrations; with outliers="refuse" also for one
            that contradicts all others, with the place.
        InvalidInput: if no candidate is of this type of motion.
    """
    motions = motions_of(demonstrations, outliers=outliers)
    models = _models(candidates, motions[0])
    count = len(motions)
    some = np.linspace(0, count - 1, min(count, _MAX_LEFT_OUT)).round()
    folds = [int(i) for i in some] if count > 1 else []  # demonstrations to leave out
    few = [thin(each, MAX_ROWS) for each in motions]
    errors = {name: _mean_error(model, few, folds) for name, model in models.items()}
    chosen = _best(errors)
    fitted: Any = protocol.fit_all(models[chosen], motions)
    skill: Skill[MotionT] = fitted.with_choice(protocol.Choice(chosen, errors, len(folds)))
    return skill


def _best(errors: dict[str, float]) -> str:
    """The first name with an answer for each demonstration, unless another is clearly better."""
    first = next((name for name, error in errors.items() if error < np.inf), next(iter(errors)))
    return min(errors, key=lambda name: errors[name] * (_BETTER if name == first else 1.0))


def _models(candidates: Sequence[str | Model], motion: Motion) -> dict[str, Model]:
    kind = "points"
    if isinstance(motion, PoseTrajectory | JointTrajectory):
        kind = "poses" if isinstance(motion, PoseTrajectory) else "joints"
    found: dict[str, Model] = {}
    several: Sequence[Any] = candidates if isinstance(candidates, list | tuple) else [candidates]
    for each in several:
        if not (isinstance(each, str) or callable(getattr(each, "fit", None))):
            raise InvalidInput(f"candidates: expected models or their names, got {candidates!r}")
        if not isinstance(each, str):
            found[repr(each)] = each
        elif kind in (entry := model_entry(each)).motions:
            found[each] = entry.load()()
    if not found:
        raise InvalidInput(f"candidates: expected a model that learns {kind}, got {candidates!r}")
    return found


def _mean_error(model: Model, motions: Sequence[Motion], folds: list[int]) -> float:
    errors = []
    for i in folds:
        rest = [each for j, each in enumerate(motions) if j != i]
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", UserWarning)  # of all, they are given before
                start, goal = (target_of(motions[i], row) for row in (0, -1))
                dt = max(_DT, motions[i].duration / MAX_ROWS)
                made = protocol.fit_all(model, rest).generate(start=start, goal=goal, dt=dt)
        except LeadthroughError:
            return float("inf")
        errors.append(_mean_distance(motions[i], made))
    return float(np.mean(errors)) if errors else 0.0


@dataclass(frozen=True, eq=False)
class Reproduction(ShortRepr):
    """Distances of a skill's motions from its demonstrations, path from path.

    Attributes:
        positions: Frechet distance (k,) from each demonstration, in its unit (m; of joints rad, as
            the norm over all); infinite where the skill has no motion from its start to its goal.
        orientations: likewise of orientations (k,), rad; None without orientations.
        extents: diagonals (k,) of the boxes that hold the demonstrations' positions.
    """

    positions: Float64Array
    orientations: Float64Array | None
    extents: Float64Array

    @property
    def position(self) -> float:
        """The largest distance from a demonstration."""
        return float(self.positions.max())

    @property
    def orientation(self) -> float | None:
        """The largest distance from a demonstration's orientations, rad."""
        return None if self.orientations is None else float(self.orientations.max())

    @property
    def fraction(self) -> float:
        """The largest distance from a demonstration as a fraction of its extent."""
        return float((self.positions / np.where(self.extents > 0.0, self.extents, 1.0)).max())

    def as_dict(self) -> dict[str, float | None]:
        """The largest distances in plain values; None where there are none."""
        found = {
            "position": self.position,
            "orientation": self.orientation,
            "fraction": self.fraction,
        }
        return {name: x if x is not None and np.isfinite(x) else None for name, x in found.items()}


def reproduction(skill: Skill[Any], demonstrations: Demonstrations[Motion]) -> Reproduction:
    """The distances of a skill's motions from demonstrations.

    Each is generated from the demonstration's own start to its own goal, in its duration, as far
    as the skill supports that. Paths are compared, not their timing.

    Args:
        skill: the skill, learned from these or others.
        demonstrations: one or more, of the skill's type of motion.

    Raises:
        FitError: if there is no demonstration, or one does not move.
        InvalidInput: if they are of another type, size or arm than the skill's motions.

    Source: Eiter and Mannila 1994, the discrete Frechet distance, of up to 64,000 points evenly
        spaced along each path.
    """
    protocol.check_skill(skill)
    motions = _of_skill(skill, motions_of(demonstrations))
    pairs = np.array([_distances(skill, each) for each in motions])
    posed = isinstance(motions[0], PoseTrajectory)
    extents = [float(np.linalg.norm(np.ptp(each.positions, axis=0))) for each in motions]
    return Reproduction(pairs[:, 0], pairs[:, 1] if posed else None, np.array(extents))


def _of_skill(skill: Skill[Any], motions: list[Motion]) -> list[Motion]:
    """The motions, with their joints in the skill's order; of another type they are refused."""
    try:
        nominal = skill.generate()
    except NoPath:
        return motions
    one, other = (f"{type(m).__name__} of {m.positions.shape[1]}" for m in (nominal, motions[0]))
    if one != other:
        raise check.refused("demonstrations", f"motions as the skill's, {one} columns", other)
    if not isinstance(nominal, JointTrajectory):
        return motions
    names = nominal.joint_names
    return [in_order(each, names, f"demonstrations[{i}]") for i, each in enumerate(motions)]


def _distances(skill: Skill[Any], demonstrated: Motion) -> tuple[float, float]:
    """The distances of positions and of orientations (0 without), infinite without a motion."""
    asked: dict[str, Any] = {"duration": demonstrated.duration}
    if not hasattr(skill, "period"):  # a rhythm has neither start nor goal
        asked |= {"start": target_of(demonstrated, 0), "goal": target_of(demonstrated, -1)}
    asked = {name: value for name, value in asked.items() if name in skill.supports}
    try:
        count = _point_count(demonstrated.positions)
        count = _FEW_POINTS if count <= _FEW_POINTS else 3 * count  # parts of long ones are quick
        made = skill.generate(**asked, dt=demonstrated.duration / count)
    except LeadthroughError:
        return np.inf, np.inf
    apart = _apart(demonstrated.positions, made.positions)
    if not isinstance(demonstrated, PoseTrajectory):
        return apart, 0.0
    chord = _apart(
        *(rotations.to_matrix(each.orientations).reshape(-1, 9) for each in (demonstrated, made))
    )
    return apart, 2.0 * float(np.arcsin(min(chord / _CHORD, 1.0)))


def _apart(demonstrated: Float64Array, made: Float64Array) -> float:
    """The Frechet distance of paths (n, d) and (m, d)."""
    most = _point_count(demonstrated)
    for count in sorted({min(most, _FEW_POINTS), most}):
        apart = frechet_distance(by_arc_length(demonstrated, count), by_arc_length(made, count))
        if apart > _RESOLVED * arc_length(demonstrated)[-1] / count:
            break
    return apart


def _point_count(rows: Float64Array) -> int:
    """The number of points, evenly spaced along a path (n, d), that it is compared by."""
    size = float(np.linalg.norm(np.ptp(rows, axis=0)))
    steps = arc_length(rows)[-1] / (_STEP * size) if size > 0.0 else 0.0
    most = min(_MAX_POINTS, max(_MIN_POINTS, _POINTS_A_ROW * len(rows)))
    return int(np.clip(steps, _MIN_POINTS, most))


def _mean_distance(demonstrated: Motion, made: Motion) -> float:
    """Mean distance of evenly spaced rows, in units of the demonstrated motion's extent."""
    extent = float(np.linalg.norm(np.ptp(demonstrated.positions, axis=0))) or 1.0
    apart = (_even(demonstrated, demonstrated.positions) - _even(made, made.positions)) / extent
    if isinstance(demonstrated, PoseTrajectory) and isinstance(made, PoseTrajectory):
        turned = [_even(each, each.orientations) for each in (demonstrated, made)]
        turns = [each / np.linalg.norm(each, axis=1, keepdims=True) for each in turned]
        reach = float(rotations.distance(turns[0], turns[0][:1].repeat(_EVEN, 0)).max())
        angle = rotations.distance(*turns) * (TURNING / max(reach, MIN_TURN))
        apart = np.column_stack([apart, angle])
    return float(np.linalg.norm(apart, axis=1).mean())


def _even(motion: Motion, rows: Float64Array) -> Float64Array:
    """Rows (100, d) at even steps along a motion's positions, in time where they stand still."""
    covered = arc_length(motion.positions)
    along = covered / covered[-1] if covered[-1] > 0.0 else np.linspace(0.0, 1.0, len(covered))
    at = np.linspace(0.0, 1.0, _EVEN)
    return lerp(at, along, rows)

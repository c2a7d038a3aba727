"""Skills looked up by task, subtask and target, in one file.

Source: Lauretti et al. 2023, section 2.1: a database of parameters, of which the nearest target's
are taken.
"""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import FitError, Float64Array, InvalidInput, ShortRepr, UnsupportedQuery
from leadthrough.io.files import StrPath
from leadthrough.models import archive
from leadthrough.models.coordinates import demonstrated_posture, mean_orientations
from leadthrough.models.protocol import Relearned, Skill
from leadthrough.motion import (
    JointTrajectory,
    Motion,
    PoseTrajectory,
    Trajectory,
    agreed_events,
    alike,
    moved_events,
    normalised_times,
)

_KIND = "library"
# Targets this much off a line or plane, as a fraction of their spread, lie on it.
_FLAT = 1e-9
_SAMPLES = 401  # of the motions that are averaged


# Weight of the condition that weights sum to 1, against distances of at most 1.
_HEAVY = 1e4


class OutsideTargets(UserWarning):
    """A skill was looked up outside of the demonstrated targets, by a stated distance."""


@dataclass(frozen=True, eq=False)
class Entry(ShortRepr):
    task: str  # name of the task
    subtask: str  # name of the part of the task
    target: Float64Array  # (d,), demonstrated target of the subtask
    skill: Skill  # that does it


@dataclass(frozen=True, eq=False)
class SkillLibrary(ShortRepr):
    """Skills by task, subtask and target; adding one gives a new library."""

    entries: tuple[Entry, ...] = ()

    def _repr_parts(self) -> list[str]:
        counts = Counter(f"{each.task}/{each.subtask}" for each in self.entries)
        return [f"{len(self.entries)} skills", *(f"{name} {n}" for name, n in counts.items())]

    def with_skill(
        self, skill: Skill, *, task: str, subtask: str, target: ArrayLike
    ) -> SkillLibrary:
        """A library that also holds a skill; it replaces one for the same target.

        Args:
            skill: a fitted skill.
            task: name of the task.
            subtask: name of the part of the task.
            target: (d,), its demonstrated target, with as many coordinates as the others
                of the subtask.
        """
        if not hasattr(skill, "to_archive"):
            raise InvalidInput(f"skill: expected a fitted skill, got {type(skill).__name__}")
        point = check.frozen(target, "target", shape=("d",))
        known = self._of(task, subtask)
        if known and len(known[0].target) != len(point):
            raise InvalidInput(
                f"target: expected shape {known[0].target.shape} as the others, got {point.shape}"
            )
        replaced = [each for each in known if np.array_equal(each.target, point)]
        others = tuple(each for each in self.entries if each not in replaced)
        return replace(self, entries=(*others, Entry(task, subtask, point, skill)))

    def subtasks(self, task: str) -> tuple[str, ...]:
        """Subtasks of a task, in the order in which they were added.

        Args:
            task: name of the task.
        """
        _check_names(task, "")
        return tuple(dict.fromkeys(e.subtask for e in self.entries if e.task == task))

    def nearest(self, task: str, subtask: str, target: ArrayLike) -> Skill:
        """The skill whose target is nearest, the first of several.

        Args:
            task: name of the task.
            subtask: name of the part of the task, of which there is a skill.
            target: (d,).
        """
        known, point = self._asked(task, subtask, target)
        gaps = [float(np.linalg.norm(each.target - point)) for each in known]
        return known[int(np.argmin(gaps))].skill

    def distance(self, task: str, subtask: str, target: ArrayLike) -> float:
        """Distance of a target from the demonstrated ones: from their convex hull, in their unit.

        Arguments are those of `nearest`.
        """
        known, point = self._asked(task, subtask, target)
        return _distance_from_hull(np.array([each.target for each in known]), point)

    def interpolated(self, task: str, subtask: str, target: ArrayLike) -> Skill:
        """A skill between those of the targets around a new one.

        Their motions are averaged over normalised time with linear (barycentric) weights, and
        learned anew with the settings of the nearest. Springs are linear: for points and joints
        this interpolates the weights. Outside of all targets it is the nearest skill, and beside
        targets on a line or plane that of the foot there, with an `OutsideTargets` warning that
        states the distance. Arguments are those of `nearest`.

        Raises:
            UnsupportedQuery: for other skills than of `DMP`, and for orientations too
                far apart for a mean.
        """
        known, point = self._asked(task, subtask, target)
        outside = self.distance(task, subtask, target)
        if outside > 0.0:
            warnings.warn(_outside_text(subtask, point, outside), OutsideTargets, stacklevel=2)
        weights = _barycentric(np.array([each.target for each in known]), point)
        used = [each.skill for each, own in zip(known, weights, strict=True) if own > 0.0]
        nearest = self.nearest(task, subtask, target)
        if len(used) < 2:
            return nearest
        if not isinstance(nearest, Relearned):
            raise UnsupportedQuery(
                f"subtask: expected skills of DMP, got one of kind {nearest.kind!r}; "
                "ask for the nearest"
            )
        motions = [skill.replay(_SAMPLES) for skill in used if isinstance(skill, Relearned)]
        kinds = sorted({type(motion).__name__ for motion in motions})
        if len(motions) < len(used) or len(kinds) > 1:
            got = kinds if len(kinds) > 1 else sorted({each.kind for each in used})
            raise UnsupportedQuery(f"subtask: expected skills of one kind, got {got}")
        return nearest.relearned(_mean(motions, weights[weights > 0.0]))

    def save(self, path: StrPath) -> None:
        """Writes all skills to one .npz file.

        Args:
            path: the file; one that exists is replaced in one go.

        Raises:
            InvalidInput: if the file cannot be written.
        """
        heads: list[dict[str, Any]] = []
        arrays: dict[str, Any] = {}
        for i, each in enumerate(self.entries):
            settings, parts = archive.archived(each.skill)
            names = {"task": each.task, "subtask": each.subtask, "target": each.target.tolist()}
            heads.append({**names, "kind": each.skill.kind, "settings": settings})
            arrays |= {f"{i}.{name}": value for name, value in parts.items()}
        archive.write(path, _KIND, {"entries": heads}, arrays)

    @staticmethod
    def load(path: StrPath) -> SkillLibrary:
        """The library in a file that `save` wrote.

        Args:
            path: the file.

        Raises:
            InvalidInput: if it is no library, is damaged, or of a newer format version.
        """
        kind, settings, arrays, _ = archive.read(path)
        if kind != _KIND:
            raise InvalidInput(f"path: expected a library of skills, got a skill of kind {kind!r}")
        result = SkillLibrary()
        try:
            for i, head in enumerate(settings["entries"]):
                own = archive.prefixed(arrays, f"{i}.")
                skill = archive.restored(Path(path), head["kind"], head["settings"], own)
                names = {name: head[name] for name in ("task", "subtask", "target")}
                result = result.with_skill(skill, **names)
        except (KeyError, TypeError) as error:
            raise InvalidInput(f"path: {path} is damaged ({error})") from None
        return result

    def _of(self, task: str, subtask: str) -> list[Entry]:
        _check_names(task, subtask)
        return [each for each in self.entries if (each.task, each.subtask) == (task, subtask)]

    def _asked(
        self, task: str, subtask: str, target: ArrayLike
    ) -> tuple[list[Entry], Float64Array]:
        known = self._of(task, subtask)
        if not known:
            held = sorted({(each.task, each.subtask) for each in self.entries})
            raise check.refused("subtask", f"one of the tasks and subtasks {held}", (task, subtask))
        return known, check.array(target, "target", shape=known[0].target.shape)


def _check_names(task: Any, subtask: Any) -> None:
    for name, value in (("task", task), ("subtask", subtask)):
        if not isinstance(value, str):
            raise InvalidInput(f"{name}: expected a name as text, got {value!r}")


def _outside_text(subtask: str, point: Float64Array, outside: float) -> str:
    return (
        f"target: {np.round(point, 6).tolist()} lies {outside:.3g} outside of the demonstrated "
        f"targets of {subtask!r}, and the skill is that of the nearest target inside or of the "
        "nearest target; demonstrate this target, or check the motion before it runs"
    )


def _distance_from_hull(targets: Float64Array, point: Float64Array) -> float:
    """The distance of a point (d,) from the convex hull of targets (n, d), 0 inside."""
    from scipy.optimize import nnls

    apart = targets - point
    scale = float(np.abs(apart).max())
    if scale == 0.0:
        return 0.0
    # Weights >= 0 whose sum is held at 1 by a heavy row; then exactly 1 for those that count.
    rows = np.vstack([apart.T / scale, np.full(len(targets), _HEAVY)])
    weights, _ = nnls(rows, np.append(np.zeros(len(point)), _HEAVY))
    corners = apart[weights > 0.0]
    sides = (corners[1:] - corners[0]).T
    along = np.linalg.lstsq(sides, -corners[0], rcond=None)[0] if sides.size else np.zeros(0)
    gap = float(np.linalg.norm(corners[0] + sides @ along))
    return gap if gap > _FLAT * scale else 0.0


def _barycentric(targets: Float64Array, point: Float64Array) -> Float64Array:
    """Weights (n,) >= 0 of targets (n, d) whose mean is the projection of a point on their span."""
    weights = np.zeros(len(targets))
    middle = targets.mean(axis=0)
    _, spread, axes = np.linalg.svd(targets - middle, full_matrices=False)
    axes = axes[spread > _FLAT * max(float(spread[0]), np.finfo(float).tiny)]
    flat, foot = (targets - middle) @ axes.T, (point - middle) @ axes.T
    if len(axes) == 1:
        order = np.argsort(flat[:, 0])
        right = int(np.searchsorted(flat[order, 0], foot[0]))
        if 0 < right < len(order):
            left_at, right_at = flat[order[[right - 1, right]], 0]
            fraction = (foot[0] - left_at) / (right_at - left_at)
            weights[order[[right - 1, right]]] = 1.0 - fraction, fraction
        return weights
    if len(axes) > 1:
        weights = _in_simplex(flat, foot)
    return weights


def _in_simplex(targets: Float64Array, point: Float64Array) -> Float64Array:
    from scipy.spatial import Delaunay, QhullError

    weights = np.zeros(len(targets))
    try:
        mesh = Delaunay(targets)
    except QhullError:
        return weights
    simplex = int(mesh.find_simplex(point, tol=_FLAT))
    if simplex >= 0:
        transform = mesh.transform[simplex]
        inner = transform[:-1] @ (point - transform[-1])
        corners = np.clip(np.append(inner, 1.0 - inner.sum()), 0.0, 1.0)
        weights[mesh.simplices[simplex]] = corners / corners.sum()
    return weights


def _mean(motions: Sequence[Motion], weights: Float64Array) -> Motion:
    """The weighted mean of motions of one type over normalised time."""
    motions = alike(motions, "skills")
    first = motions[0]
    positions = np.average([motion.positions for motion in motions], axis=0, weights=weights)
    duration = float(np.average([motion.duration for motion in motions], weights=weights))
    times = np.linspace(0.0, duration, _SAMPLES)
    happened = [moved_events(each.events, each.times[[0, -1]], (0.0, 1.0)) for each in motions]
    happening = moved_events(agreed_events(happened, weights), (0.0, 1.0), times[[0, -1]])
    if isinstance(first, JointTrajectory):
        return JointTrajectory(times, positions, joint_names=first.joint_names, events=happening)
    posture = demonstrated_posture(
        motions, [normalised_times(each.times) for each in motions], weights
    )
    joints = None if posture is None else posture.along(times, normalised_times(times))
    if isinstance(first, PoseTrajectory):
        poses = [motion for motion in motions if isinstance(motion, PoseTrajectory)]
        layers = [motion.orientations for motion in poses]
        try:
            orientations = mean_orientations(layers, weights=weights)
        except FitError:
            raise UnsupportedQuery(
                "target: the orientations of the skills around it lie too far apart for a mean; "
                "use nearest, or teach a target between them"
            ) from None
        return PoseTrajectory(times, positions, orientations, happening, joints)
    return Trajectory(times, positions, happening, joints)

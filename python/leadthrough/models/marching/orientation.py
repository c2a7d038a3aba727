"""Orientation along a path, from demonstrations of poses, by the fraction of the path covered."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from leadthrough import rotations
from leadthrough.check import FitError, Float64Array
from leadthrough.models.coordinates import groups_of, mean_orientations
from leadthrough.models.marching.experience import Experience
from leadthrough.preprocess.resample import arc_length, by_arc_length
from leadthrough.trajectories import minimum_jerk_time_scaling

_NODES = 101  # of the mean orientation along the path
# Paths nearer to each other than this fraction of their length are followed together.
_SAME_BRANCH = 0.1


def refuse_opposed(known: Sequence[Experience]) -> None:
    """Checks that demonstrations of the same path have a mean orientation along it."""
    directed = [each.towards(known[0].path[0], known[0].path[-1]) for each in known]
    if any(each.orientations is None for each in directed):
        return
    phases = np.linspace(0.0, 1.0, _NODES)
    layers = [_at(each, phases) for each in directed]
    try:
        mean_orientations(layers)
    except FitError:
        near, far, *_ = groups_of(layers)
        lengths = [each.length for each in directed]
        for i, j in ((i, j) for i in near for j in far):
            if _gap(directed[i].path, directed[j].path) < _SAME_BRANCH * max(
                lengths[i], lengths[j]
            ):
                raise


def along(
    used: Sequence[Experience],
    weights: Float64Array,
    *,
    path: Float64Array,
    start: Float64Array | None = None,
    goal: Float64Array | None = None,
    fractions: Float64Array | None = None,
) -> Float64Array:
    """Orientations along a path that follows demonstrations, by default at its own points."""
    if fractions is None:
        covered = arc_length(path)
        fractions = covered / covered[-1]
    phases = np.linspace(0.0, 1.0, _NODES)
    chosen = [i for i, weight in enumerate(weights) if weight > 0.0]
    nodes = _agreed([used[i] for i in chosen], weights[chosen], path)
    mean = rotations.squad(phases, nodes, fractions)
    offsets = [
        np.zeros((1, 3))
        if wanted is None
        else rotations.log(rotations.compose(wanted[None], rotations.inverse(node[None])))
        for wanted, node in ((start, nodes[0]), (goal, nodes[-1]))
    ]
    blend = minimum_jerk_time_scaling(fractions)[:, None]
    turns = rotations.exp((1.0 - blend) * offsets[0] + blend * offsets[1])
    return rotations.align_signs(rotations.compose(turns, mean))


def _agreed(used: Sequence[Experience], weights: Float64Array, path: Float64Array) -> Float64Array:
    """Mean orientations (n, 4) of the demonstrations, or of the group nearest to a path."""
    phases = np.linspace(0.0, 1.0, _NODES)
    layers = [_at(each, phases) for each in used]
    try:
        return mean_orientations(layers, weights=weights)
    except FitError:
        groups = groups_of(layers)[:2]
        nearest = int(np.argmin([_gap(each.path, path) for each in used]))
        chosen = groups[0] if nearest in groups[0] else groups[1]
        return _agreed([used[i] for i in chosen], weights[chosen], path)


def _gap(one: Float64Array, other: Float64Array) -> float:
    """Root mean square distance of two paths at the same fractions of their lengths."""
    gaps = by_arc_length(one, _NODES) - by_arc_length(other, _NODES)
    return float(np.sqrt((gaps**2).sum(axis=1).mean()))


def _at(known: Experience, phases: Float64Array) -> Float64Array:
    """Orientations at fractions of the demonstration's own path; where it rests, the last one."""
    assert known.orientations is not None
    covered = arc_length(known.denoised)
    moving = np.concatenate([np.diff(covered) > 0.0, [True]])
    fraction = covered[moving] / covered[-1]
    fraction[0] = 0.0
    return rotations.interpolate(fraction, known.orientations[moving], phases)

"""Orientation along a path, from demonstrations of poses, by the fraction of the path covered."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from leadthrough import rotations
from leadthrough.check import Float64Array
from leadthrough.models.marching.experience import Experience
from leadthrough.preprocess.resample import arc_length
from leadthrough.trajectories import minimum_jerk_rise

_NODES = 101  # of the mean orientation along the path


def along(
    used: Sequence[Experience],
    weights: Float64Array,
    *,
    start: Float64Array | None,
    goal: Float64Array | None,
    fractions: Float64Array,
) -> Float64Array:
    """Orientations along a path that follows demonstrations of poses.

    The weighted mean of the demonstrations' orientations, turned to start and goal where given: the
    offsets at both ends fade into each other along the path with a minimum-jerk blend, so that the
    tool turns as it was known to and no turn is added.

    Args:
        used: the demonstrations.
        weights: (k,) of the demonstrations.
        start: orientation (4,) at the start of the path, or None.
        goal: orientation (4,) at its end, or None.
        fractions: (n,) of the path covered, in [0, 1].

    Returns:
        Orientations (n, 4), w, x, y, z.
    """
    phases = np.linspace(0.0, 1.0, _NODES)
    nodes = rotations.mean(np.stack([_at(each, phases) for each in used]), weights=weights)
    nodes = rotations.align_signs(nodes)
    mean = rotations.squad(phases, nodes, fractions)
    offsets = [
        np.zeros((1, 3))
        if wanted is None
        else rotations.log(rotations.compose(wanted[None], rotations.inverse(node[None])))
        for wanted, node in ((start, nodes[0]), (goal, nodes[-1]))
    ]
    blend = minimum_jerk_rise(fractions)[:, None]
    turns = rotations.exp((1.0 - blend) * offsets[0] + blend * offsets[1])
    return rotations.align_signs(rotations.compose(turns, mean))


def _at(known: Experience, phases: Float64Array) -> Float64Array:
    """Orientations at fractions of the demonstration's own path; where it rests, the last one."""
    assert known.orientations is not None
    covered = arc_length(known.path)
    moving = np.concatenate([np.diff(covered) > 0.0, [True]])
    fraction = covered[moving] / covered[-1]
    fraction[0] = 0.0
    return rotations.interpolate(fraction, known.orientations[moving], phases)

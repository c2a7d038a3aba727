"""Which way round demonstrations predict the way between a start and a goal.

Demonstrations are reversed where their ends fit a query better the other way round. A motion that
was shown in one direction, such as a stroke that ends beside its start, is reversed only where the
reversed one stays within the bound for moved ends: else a small move would turn the motion around.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.models.marching import mean_path
from leadthrough.models.marching.experience import Experience
from leadthrough.models.marching.query import Query

# Ends shown in one direction are nearer to their mean by this factor than reversed.
_ONE_WAY = 0.5


def faced(known: Sequence[Experience], query: Query) -> list[Experience]:
    """The demonstrations, facing the way from start to goal as a whole."""
    turned = [each.facing(query.start, query.goal) for each in known]
    if all(one is other for one, other in zip(turned, known, strict=True)):
        return turned
    starts, goals = (np.stack([each.path[index] for each in known]) for index in (0, -1))
    usual = starts.mean(axis=0), goals.mean(axis=0)
    if not _shown_one_way(starts, goals, *usual):
        return turned
    moved = max(
        float(np.linalg.norm(asked - shown)) for asked, shown in zip(query.ends, usual, strict=True)
    )
    change = _way(turned, query.start, query.goal) - _way(known, *usual)
    within = np.linalg.norm(change, axis=1).max() <= mean_path.MOST_DEVIATION * moved
    return turned if within else list(known)


def _shown_one_way(
    starts: Float64Array, goals: Float64Array, start: Float64Array, goal: Float64Array
) -> bool:
    """Whether no demonstration is as near to the mean ends when it is reversed."""
    ahead, back = (
        np.linalg.norm(first - start, axis=1) + np.linalg.norm(last - goal, axis=1)
        for first, last in ((starts, goals), (goals, starts))
    )
    return bool((ahead <= _ONE_WAY * back).all())


def _way(shown: Sequence[Experience], start: Float64Array, goal: Float64Array) -> Float64Array:
    return next(mean_path.ways(shown, start, goal)).path

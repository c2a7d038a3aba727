"""Paths of an arm between two configurations, without a path of the tip: RRT-Connect.

Every edge is certified all along, not looked at in places. A number of steps bounds the search, not
the time, and the random numbers have a seed, so the answer is the same each time.

Source: Kuffner and LaValle 2000.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check
from leadthrough.arm import Arm, DualArm, check_arms
from leadthrough.arm.tip_path import CollisionTest
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.shapes import SceneLike, as_scene

# Of a joint that turns without end, rad.
_TURNS = 2.0 * np.pi
# Searches by their depth inside the margins, m, and their part of the steps: from a grasp the arm
# leaves along a contact, which has no certificate.
_SEARCHES = ((0.0, 0.1), (1e-4, 0.1), (0.0, 0.8))


def connect_configurations(
    arm: Arm | DualArm,
    start: ArrayLike,
    goals: ArrayLike,
    scene: SceneLike = (),
    *,
    seed: int = 0,
    steps: int = 200_000,
) -> Float64Array | None:
    """Configurations (m, joints) on a piecewise straight path from the start to one of the goals.

    The path has been shortened, and is clear all along.

    Args:
        arm: an arm, or two that hold nothing together.
        start: configuration (joints,).
        goals: configurations (k, joints), or (joints,) for one.
        scene: to keep clear of by its margins.
        seed: of the random number generator, >= 0.
        steps: how many edges the trees of a search may try, 1 to 1e7.

    Returns:
        The path; None if none was found.
    """
    check_arms(arm)
    joints = len(arm.joint_names)
    around = CollisionTest(arm._collision, as_scene(scene))
    begin = check.array(start, "start", shape=(joints,))
    ends = np.atleast_2d(check.array_of_rank(goals, "goals", shapes=((joints,), ("k", joints))))
    if not len(ends):
        raise check.refused("goals", "at least one configuration", "none")
    for name, q in (("start", begin[None]), ("goals", ends)):
        if np.any(q < arm.limits.lower) or np.any(q > arm.limits.upper):
            raise InvalidInput(f"{name}: expected joints inside the arm's limits, got {q.tolist()}")
    first = check.integer(seed, "seed", at_least=0, at_most=2**63 - 1)
    most = check.integer(steps, "steps", at_least=1, at_most=10**7)
    both = np.vstack([begin[None], ends])
    lower = np.maximum(arm.limits.lower, both.min(axis=0) - _TURNS)
    upper = np.minimum(arm.limits.upper, both.max(axis=0) + _TURNS)
    for depth, part in _SEARCHES:
        path = core.connect(
            around.model,
            around.shapes,
            begin,
            np.ascontiguousarray(ends),
            lower,
            upper,
            around.scene.margin - depth,
            around.scene.self_collision_margin - depth,
            first,
            max(1, int(part * most)),
        )
        # Inside the margins edges prove less: contacts may be deeper than they were.
        if len(path) and (depth == 0.0 or around.clear_along(path)):
            return path
    return None

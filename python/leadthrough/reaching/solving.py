"""Poses that an arm reaches without touching itself or obstacles, many at a time."""

from __future__ import annotations

import pickle
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from leadthrough.arm import Arm, IkOptions
from leadthrough.check import Float64Array
from leadthrough.shapes import Scene
from leadthrough.tasks import Row

# Solutions of a pose that are looked at: where the first touches, another may be clear.
_TRIES = 3
# Of each search; most poses that can be reached are by the first few.
_RESTARTS = 12
_TOLERANCE = 1e-4  # m and rad


@dataclass(frozen=True, eq=False)
class Workspace:
    """What all tasks of a map have in common."""

    arm: Arm  # that reaches
    scene: Scene  # to be clear of
    orientations: Float64Array  # (k, 4) that are tried at each place
    places: Float64Array  # (n, 3) in m, base frame


def ranges(arm: Arm) -> tuple[Float64Array, Float64Array]:
    """Lowest and highest joints; of a joint that turns without end, a whole turn."""
    lower, upper = arm.limits.lower, arm.limits.upper
    return np.where(np.isfinite(lower), lower, -np.pi), np.where(np.isfinite(upper), upper, np.pi)


def reached(
    arm: Arm,
    positions: Float64Array,
    orientations: Float64Array,
    scene: Scene,
    seed: int,
) -> tuple[NDArray[np.bool_], Float64Array]:
    """Which poses (m,) the arm reaches clear of everything, and its joints there (m, joints)."""
    found = np.zeros(len(positions), dtype=bool)
    joints = np.full((len(positions), len(arm.joint_names)), np.nan)
    rng = np.random.default_rng(seed)
    lower, upper = ranges(arm)
    left = np.arange(len(positions))
    for attempt in range(_TRIES):
        if not len(left):
            break
        middle = 0.5 * (lower + upper)
        seeds = middle if attempt == 0 else rng.uniform(lower, upper, (len(left), len(lower)))
        solved = arm.inverse_kinematics_batch(
            positions[left],
            orientations[left],
            q0=seeds,
            options=IkOptions(
                position_tolerance=_TOLERANCE,
                orientation_tolerance=_TOLERANCE,
                max_restarts=_RESTARTS,
            ),
            seed=seed + attempt,
        )
        good = solved.success.copy()
        if good.any():
            good[good] = arm.is_clear(solved.q[good], scene)
        found[left[good]] = True
        joints[left[good]] = solved.q[good]
        left = left[solved.success & ~good]
    return found, joints


def reach_rows(*, first: int, count: int, seed: int, workspace: Path) -> list[Row]:
    """A row for each place: the number of orientations reached, and the best manipulability."""
    with workspace.open("rb") as file:
        common: Workspace = pickle.load(file)
    places = common.places[first : first + count]
    each = len(common.orientations)
    found, joints = reached(
        common.arm,
        places.repeat(each, axis=0),
        np.tile(common.orientations, (len(places), 1)),
        common.scene,
        seed + first,
    )
    measure = np.zeros(len(found))
    if found.any():
        measure[found] = common.arm.manipulability(joints[found])
    return [
        {"reached": int(own.sum()), "manipulability": float(best)}
        for own, best in zip(
            found.reshape(-1, each), measure.reshape(-1, each).max(axis=1), strict=True
        )
    ]

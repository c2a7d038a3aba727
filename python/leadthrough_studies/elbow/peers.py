"""What others make of a scene: the slow search of `reference`, and RRT-Connect.

The slow search is asked only where `follow` has no solution.
"""

from __future__ import annotations

import time
from itertools import pairwise
from typing import Literal

import numpy as np
from scipy.spatial import KDTree

from leadthrough.arm import Arm, IkOptions
from leadthrough.check import Float64Array
from leadthrough.errors import IkFailure
from leadthrough.motion_planning import connect_configurations
from leadthrough.shapes import Scene
from leadthrough_studies.elbow.reference import searched_for_a_minute
from leadthrough_studies.elbow.scenes import FREE, MARGIN, Reach, drawn_scene, followed
from leadthrough_studies.study import Row

# Configurations that inverse kinematics starts from at either end, and ends that are tried.
_TRIES, _ENDS = 200, 8
# The same where it is asked whether there is any that is clear, and the samples apart.
_MANY_TRIES, _EVERY = 600, 4
_DENSE = 0.02  # rad between the configurations at which the tip is looked at


def searched(*, arm: str, motion: str, seed: int, index: int, files: list[str]) -> list[Row]:
    """One row for a scene that `follow` does not solve: whether the slow search does.

    None where one of the samples has no collision-free configuration.
    """
    body = Arm.load(arm)
    made = drawn_scene(body, arm, seed, index, files)
    try:
        followed(body, arm, made)
        return []
    except IkFailure:
        pass
    if impossible(body, arm, made):
        return []
    begin = time.process_time()
    roadmap = searched_for_a_minute(body, made.tip, made.obstacles, margin=MARGIN, free=FREE[arm])
    return [
        {
            "by": "reference",
            "arm": arm,
            "motion": motion,
            "index": index,
            "solved": int(roadmap.arrived),
            "last_sample": roadmap.last,
            "reference_cpu_s": time.process_time() - begin,
        }
    ]


def connected(*, arm: str, motion: str, seed: int, index: int, files: list[str]) -> list[Row]:
    """One row: whether RRT-Connect finds a way between the ends, and how far the tip strays."""
    body = Arm.load(arm)
    made = drawn_scene(body, arm, seed, index, files)
    starts, goals = (_standing(body, made, i, FREE[arm]) for i in (0, -1))
    begin = time.process_time()
    way = None
    if len(starts) and len(goals):
        way = connect_configurations(body, starts[0], goals, Scene(made.obstacles, MARGIN))
    spent = time.process_time() - begin
    return [
        {
            "by": "RRT-Connect",
            "arm": arm,
            "motion": motion,
            "index": index,
            "solved": int(way is not None),
            "off_path_m": None if way is None else _off_path(body, made, way),
            "connect_cpu_s": spent,
        }
    ]


def _standing(arm: Arm, made: Reach, sample: int, free: tuple[Literal["rz"], ...]) -> Float64Array:
    """Clear configurations (k, joints) at a sample, those nearest to the arm's usual one first."""
    rng = np.random.default_rng(0)
    near = made.joints.positions[sample]
    low, high = (np.clip(ends, -np.pi, np.pi) for ends in (arm.limits.lower, arm.limits.upper))
    seeds = np.vstack([near[None], rng.uniform(low, high, (_TRIES, len(near)))])
    found = arm.inverse_kinematics_batch(
        np.tile(made.tip.positions[sample], (len(seeds), 1)),
        np.tile(made.tip.orientations[sample], (len(seeds), 1)),
        q0=seeds,
        options=IkOptions(free=free, max_restarts=0),
    )
    q = found.q[found.success]
    q = q[np.asarray(arm.is_clear(q, Scene(made.obstacles, MARGIN)))] if len(q) else q
    return np.asarray(q[np.argsort(np.abs(q - near).max(axis=1), kind="stable")][:_ENDS])


def impossible(arm: Arm, name: str, made: Reach) -> bool:
    """Whether one of some samples has no collision-free configuration."""
    rng = np.random.default_rng(0)
    low, high = (np.clip(ends, -np.pi, np.pi) for ends in (arm.limits.lower, arm.limits.upper))
    seeds = rng.uniform(low, high, (_MANY_TRIES, len(arm.joint_names)))
    for i in range(0, len(made.tip), _EVERY):
        near = np.vstack([made.joints.positions[i], seeds])
        found = arm.inverse_kinematics_batch(
            np.tile(made.tip.positions[i], (len(near), 1)),
            np.tile(made.tip.orientations[i], (len(near), 1)),
            q0=near,
            options=IkOptions(
                free=FREE[name], position_tolerance=1e-5, orientation_tolerance=1e-5, max_restarts=0
            ),
        )
        q = found.q[found.success]
        if not np.any(arm.is_clear(q, Scene(made.obstacles, MARGIN))):
            return True
    return False


def _off_path(arm: Arm, made: Reach, way: Float64Array) -> float:
    """How far the tip is from the shown path at the most, m."""
    pieces = [
        a + np.linspace(0.0, 1.0, int(np.ceil(np.abs(b - a).max() / _DENSE)) + 1)[:, None] * (b - a)
        for a, b in pairwise(way)
    ]
    tip, _ = arm.forward_kinematics(np.vstack(pieces))
    return float(KDTree(made.tip.positions).query(tip)[0].max())

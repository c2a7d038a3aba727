"""Motions that `follow` finds, looked at again by another library along what is executed.

The executed motion is a cubic through the samples with their velocities, as controllers make it. No
point of the arm moves farther than 0.1 mm from one configuration on it to the next. A distance that
was found lets those be passed over on the way to which no point comes so far.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from leadthrough.arm import Arm
from leadthrough.check import Float64Array
from leadthrough.errors import IkFailure
from leadthrough.motion import JointTrajectory
from leadthrough_studies.coal_arm import CoalArm
from leadthrough_studies.elbow.scenes import drawn_scene, followed
from leadthrough_studies.study import Row

_STEP = 1e-4  # m
_REACH = 1.3  # m: no point of these arms is farther away from a joint's axis
_PARTS = 20  # of the interval between two samples, in which the way is measured


def rechecked(*, arm: str, motion: str, seed: int, index: int, files: list[str]) -> list[Row]:
    """One row for a scene that `follow` solves: how near coal finds its obstacles."""
    body = Arm.load(arm)
    made = drawn_scene(body, arm, seed, index, files)
    try:
        joints = followed(body, arm, made)
    except IkFailure:
        return []
    peer = CoalArm(body)
    rows = fine_steps(joints)
    least, looked_at = nearest(peer, rows, [peer.solid(shape) for shape in made.obstacles])
    return [
        {
            "by": "coal",
            "arm": arm,
            "motion": motion,
            "index": index,
            "steps": len(rows),
            "looked_at": looked_at,
            "touches": int(least <= 0.0),
            "coal_distance_m": least,
        }
    ]


def fine_steps(joints: JointTrajectory) -> Float64Array:
    """Configurations (m, joints) along what is executed, no point 0.1 mm from one to the next."""
    times, q = joints.times, joints.positions
    assert joints.velocities is not None
    curve = CubicHermiteSpline(times, q, joints.velocities)
    fine = np.linspace(times[0], times[-1], _PARTS * len(q))
    farthest = np.abs(np.diff(curve(fine), axis=0)).sum(axis=1) * _REACH
    moved = np.concatenate([[0.0], np.cumsum(farthest)])
    count = int(np.ceil(moved[-1] / _STEP)) + 1
    return np.asarray(curve(np.interp(np.linspace(0.0, moved[-1], count), moved, fine)))


def nearest(peer: CoalArm, rows: Float64Array, solids: list[Any]) -> tuple[float, int]:
    """The least distance in m of the arm along fine steps, and how many of them were looked at."""
    links = peer.moving_links()
    least, looked_at, at = np.inf, 0, 0
    while at < len(rows):
        peer.place(rows[at])
        distance = min(peer.distance_to(links, *solid) for solid in solids)
        least, looked_at = min(least, distance), looked_at + 1
        at += max(1, int(distance / _STEP))
    return float(least), looked_at

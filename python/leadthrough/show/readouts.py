"""Figures along a motion that a page states and draws: joints, the tip, and nearest pairs."""

from __future__ import annotations

from typing import Any

import numpy as np

from leadthrough.arm import Arm
from leadthrough.arm.collision import nearest_pairs
from leadthrough.check import Float64Array, InvalidRobot, MissingDependency
from leadthrough.motion import JointTrajectory
from leadthrough.shapes import SceneLike, as_scene
from leadthrough.show.animation import sampled, thinned

_POINTS = 2000  # of a path that the tip is compared with
_LEAST = 1e-9  # rad/s (m/s), for limits of zero


def readouts(
    arm: Arm, motion: JointTrajectory | None, scene: SceneLike, wanted: Float64Array | None = None
) -> dict[str, Any] | None:
    """Figures at samples that a page draws; the tip's errors are from a `wanted` path (m, 3)."""
    if motion is None or len(motion.times) < 2:
        return None
    drawn = sampled(arm, motion)
    times, q = drawn.times - drawn.times[0], drawn.positions
    rates = np.gradient(q, times, axis=0)
    limits = arm.limits
    shares = np.abs(rates) / np.maximum(limits.velocity, _LEAST)
    tips = arm.forward_kinematics(q)[0]
    return {
        "times": times.round(4).tolist(),
        "joint": shares.argmax(axis=1).tolist(),
        "share": shares.max(axis=1).round(3).tolist(),
        "speed": np.linalg.norm(np.gradient(tips, times, axis=0), axis=1).round(3).tolist(),
        "error": None
        if wanted is None
        else _distances(tips, thinned(wanted, _POINTS)).round(6).tolist(),
        "names": list(arm.joint_names),
        "positions": q.T.round(3).tolist(),
        "velocities": rates.T.round(3).tolist(),
        "limits": [_finite(each) for each in (limits.lower, limits.upper, limits.velocity)],
        "pairs": _pairs(arm, q, scene),
    }


def _distances(points: Float64Array, path: Float64Array) -> Float64Array:
    """Distances (n,) of points (n, 3) from the straight pieces of a path (m, 3)."""
    along = np.diff(path, axis=0, append=path[-1:])
    squares = np.maximum((along**2).sum(axis=1), np.finfo(np.float64).tiny)
    away = points[:, None] - path
    parts = np.clip(np.einsum("nmi,mi->nm", away, along) / squares, 0.0, 1.0)
    return np.asarray(np.linalg.norm(away - parts[..., None] * along, axis=2).min(axis=1))


def _pairs(arm: Arm, q: Float64Array, scene: SceneLike) -> list[dict[str, Any]]:
    """The nearest obstacle and link, and the nearest links, at configurations (n, joints)."""
    try:
        found = nearest_pairs(arm._collision, q, as_scene(scene).shapes)
    except (InvalidRobot, MissingDependency):  # there is no geometry to compare
        return []
    return [
        {
            "distance": distances.round(4).tolist(),
            "bodies": [" and ".join(names) for names in bodies],
            "points": points.round(3).tolist(),
        }
        for distances, bodies, points in found
        if np.isfinite(distances).all()
    ]


def _finite(limits: Float64Array) -> list[float | None]:
    return [float(limit) if np.isfinite(limit) else None for limit in limits]

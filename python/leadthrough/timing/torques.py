"""Bounds that the joints' torques put on the speed v along a path, and on its derivative u.

With x = v^2, a torque is gain u + bend x + viscous v + rest, and dry friction against the motion.
Viscous friction is no linear row of u and x. At any speed w it is at most its tangent,
viscous (w + x / w) / 2, and up to 2 w at least viscous x / (2 w): rows with these are conservative.
"""

from __future__ import annotations

import numpy as np

import leadthrough._core as core
from leadthrough.arm.limits import JointLimits
from leadthrough.check import Float64Array, LimitsInfeasible
from leadthrough.timing.request import InverseDynamics, efforts, known_efforts

_LEAST_ROOM = 1e-9  # N m (N), of torque left for viscous friction; less is none
_CREEP = 1e-2  # times a motion's speed, at which dry friction is nearly all that resists it


def torque_rows(
    path: core.TimedPath,
    scale: Float64Array,
    dynamics: InverseDynamics,
    limits: JointLimits,
    fraction: Float64Array,
) -> tuple[Float64Array, ...]:
    """Rows (n, joints) lower <= gain u + bend x <= upper: gain, bend, lower and upper."""
    gain, bend, rest, viscous, dry = _efforts_along(path, dynamics)
    most = known_efforts(limits)
    lower = fraction * (-most - rest - np.minimum(dry, 0.0))
    upper = fraction * (most - rest - np.maximum(dry, 0.0))
    stuck = np.flatnonzero(((lower > 0.0) | (upper < 0.0)).any(axis=0))
    if len(stuck):
        name, held = limits.joint_names[stuck[0]], (np.abs(rest) <= most)[:, stuck[0]].all()
        does = "overcome its friction" if held else "hold the arm"
        raise LimitsInfeasible(f"{name} cannot {does} along the path", joint=name)
    room = np.maximum(np.where(viscous > 0.0, upper, -lower), _LEAST_ROOM)
    slow = np.divide(np.abs(path.first), scale, out=np.zeros_like(rest), where=scale > 0.0)
    slow = np.maximum(slow, np.abs(viscous) / room).max(axis=1, keepdims=True)
    # By the length's definition, no speed is above the root of the number of joints.
    speed = 1.0 / np.maximum(slow, len(scale) ** -0.5)
    lower -= 0.5 * speed * np.minimum(viscous, 0.0)
    upper -= 0.5 * speed * np.maximum(viscous, 0.0)
    return gain, bend + 0.5 / speed * viscous, lower, upper


def torque_ratios(
    dynamics: InverseDynamics, limits: JointLimits, q: Float64Array, *rates: Float64Array
) -> Float64Array:
    """The fraction (joints,) that is used of the torques that weight and dry friction leave."""
    qd, qdd = rates
    held = efforts(dynamics, q, _CREEP * qd, np.zeros_like(q))
    used = efforts(dynamics, q, qd, qdd) - held
    left = np.maximum(known_efforts(limits) - np.sign(used) * held, np.finfo(np.float64).tiny)
    return np.asarray((np.abs(used) / left).max(axis=0))


def _efforts_along(path: core.TimedPath, dynamics: InverseDynamics) -> tuple[Float64Array, ...]:
    """Efforts (n, joints) of u = 1, of x = 1, at rest, and of viscous (v = 1) and dry friction."""
    q, along, still = path.positions, path.first, np.zeros_like(path.positions)
    rest = efforts(dynamics, q, still, still)
    gain = efforts(dynamics, q, still, along) - rest
    ahead, back, *faster = (
        efforts(dynamics, q, speed * along, path.second) for speed in (1.0, -1.0, 2.0, -2.0)
    )
    resisted = 0.5 * (ahead - back)
    viscous = 0.5 * (faster[0] - faster[1]) - resisted
    return gain, 0.5 * (ahead + back) - rest, rest, viscous, resisted - viscous

"""Number of physics steps in a period of the controller, from the stiffest mode of the closed loop.

With the mass matrix M, stiffness K and damping D of all dampers, each mode of M^-1 K has a natural
frequency w and a damping rate d. It changes at the rate w, or where it is overdamped at that of its
slower pole, d/2 - sqrt(d^2/4 - w^2). The faster pole is of the drives' dampers, which act at the
end of a step and so are stable at any. Damping that the controller computes is held for a period,
and counts with its full rate.
"""

from __future__ import annotations

import math

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.simulation.controllers import Law, Motion

# Rate of a mode times the step: a joint let go then errs by at most 2 % of its displacement.
MAX_CHANGE = 0.2
_MAX_STEPS = 50  # a period; faster loops are unstable by their controller's period
_ROUNDING = 1e-6  # steps: rates of default gains are multiples of the bound
_ALONG = 11  # fractions of the path, for gains that change along it


def steps_per_period(
    law: Law, q: Float64Array, mass: Float64Array, damping: Float64Array, *, period: float
) -> int:
    """The least number of steps in which no mode changes by more than `MAX_CHANGE` each."""
    rates = _rates(law, q, mass, damping)
    if not np.isfinite(rates).all():
        return _MAX_STEPS
    least = math.ceil(period * float(rates.max()) / MAX_CHANGE - _ROUNDING)
    return min(max(least, 1), _MAX_STEPS)


def _rates(law: Law, q: Float64Array, mass: Float64Array, damping: Float64Array) -> Float64Array:
    """Rates (n, joints) of the modes, 1/s, at fractions of the path."""
    still = np.zeros((_ALONG, len(q)))
    everywhere = np.tile(mass, (_ALONG, 1, 1))
    gains = law.gains(Motion(still + q, everywhere, still, still, np.linspace(0.0, 1.0, _ALONG)))
    back = np.linalg.inv(np.linalg.cholesky(mass))
    with np.errstate(over="ignore", invalid="ignore"):
        stiffness = back @ gains.stiffness @ back.T
    if not np.isfinite(stiffness).all():
        return np.asarray(stiffness)
    squares, modes = np.linalg.eigh(stiffness)
    held = _along(modes, back @ gains.damping @ back.T)
    rest = _along(modes, back @ np.diag(damping + law.drive_damping) @ back.T)
    frequency, half = np.sqrt(np.maximum(squares, 0.0)), 0.5 * (held + rest)
    slower = half - np.sqrt(np.maximum(half**2 - frequency**2, 0.0))
    return np.asarray(np.maximum(np.where(half > frequency, slower, frequency), held))


def _along(modes: Float64Array, matrices: Float64Array) -> Float64Array:
    """Entries (n, joints) of symmetric matrices for modes in the columns of (n, joints, joints)."""
    return np.asarray(
        np.einsum("nji,njk,nki->ni", modes, np.broadcast_to(matrices, modes.shape), modes)
    )

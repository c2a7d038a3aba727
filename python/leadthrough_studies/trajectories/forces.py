"""Section 4.1 of Grioli's notes (2023): the force of a DMP as a sum of weighted Gaussians."""

from __future__ import annotations

import numpy as np
from scipy.signal import StateSpace, lsim

from leadthrough import trajectories as tr
from leadthrough.check import Float64Array
from leadthrough_studies.study import Row, Task

_KERNELS, _DECAY = 20, 4.0
_STIFFNESS, _DAMPING = 150.0, 25.0  # nearly critical
_SAMPLES = 4001
_SEEDS = 20


def tasks(seed: int) -> list[Task]:
    """A task for each random motion.

    Args:
        seed: of the first one.
    """
    return [Task(weights, {"seed": seed + i}) for i in range(_SEEDS)]


def weights(seed: int) -> list[Row]:
    """Weights of eq. 4.10, each alone, beside those that minimise eq. 4.8, together.

    Of a minimum-jerk motion of one second through random points, at rest at both ends, with the
    widths of eq. 4.6 and with the default ones of `lt.DMP`. Errors of the force are root mean
    squares over its largest value, those of the replayed motion over its extent.
    """
    t = np.linspace(0.0, 1.0, _SAMPLES)
    points = np.append(0.0, np.random.default_rng(seed).normal(size=3) + 1.0)
    shown = tr.minimum_jerk_through(np.linspace(0.0, 1.0, 4), points[:, None])
    x, v, a = (shown.evaluate(t, order)[:, 0] for order in range(3))
    wanted = a - _STIFFNESS * (x[-1] - x) + _DAMPING * v  # eq. 4.7 with tau 1
    phase = np.exp(-_DECAY * t)
    drive = phase * (x[-1] - x[0])
    centres = np.exp(-_DECAY * np.arange(_KERNELS) / _KERNELS)
    rows = []
    for widths, inverse in (
        ("printed widths", _KERNELS / centres**2),
        ("our widths", overlapping(centres, 0.8)),
    ):
        regressors = shares_of(phase, centres, inverse) * drive[:, None]
        for fit, found in (
            ("each alone", _each_alone(gaussians(phase, centres, inverse), drive, wanted)),
            ("together", np.linalg.lstsq(regressors, wanted, rcond=None)[0]),
        ):
            made = regressors @ found
            rows.append(
                {
                    "study": "forces",
                    "seed": seed,
                    "way": f"{widths}, {fit}",
                    "force_error": _rms(made - wanted) / float(np.abs(wanted).max()),
                    "replay_error": _rms(_replayed(made, t, x) - x) / float(np.ptp(x)),
                }
            )
    return rows


def gaussians(phase: Float64Array, centres: Float64Array, inverse: Float64Array) -> Float64Array:
    """Equation 4.4 at phases (n,), (n, kernels)."""
    return np.asarray(np.exp(-inverse * (phase[:, None] - centres) ** 2))


def shares_of(phase: Float64Array, centres: Float64Array, inverse: Float64Array) -> Float64Array:
    """The Gaussians over their sum, as in eq. 4.2, (n, kernels)."""
    kernels = gaussians(phase, centres, inverse)
    return np.asarray(kernels / kernels.sum(axis=1, keepdims=True))


def overlapping(centres: Float64Array, value: float) -> Float64Array:
    """Inverse widths with which each Gaussian has a value at its neighbour's centre."""
    gaps = np.diff(centres) ** 2
    return np.asarray(-np.log(value) / np.append(gaps, gaps[-1]))


def _each_alone(kernels: Float64Array, drive: Float64Array, wanted: Float64Array) -> Float64Array:
    return np.asarray((drive * wanted) @ kernels / (drive**2 @ kernels))


def _replayed(force: Float64Array, t: Float64Array, x: Float64Array) -> Float64Array:
    """The motion of eq. 4.1 with the damping on v, from x[0] to x[-1]."""
    spring = StateSpace([[0.0, 1.0], [-_STIFFNESS, -_DAMPING]], [[0.0], [1.0]], [[1.0, 0.0]], 0.0)
    return np.asarray(lsim(spring, _STIFFNESS * x[-1] + force, t, X0=[x[0], 0.0])[1])


def _rms(errors: Float64Array) -> float:
    return float(np.sqrt(np.mean(errors**2)))

"""A simulated person who guides the hand of an arm; every draw comes from the generator given.

Point-to-point movements of people are straight to slightly bowed with a bell-shaped speed (Flash
and Hogan 1985, eq. 3: minimum jerk). On top comes what teaching by hand adds: a bow of its own for
every movement, ends that scatter, and a tremor.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from leadthrough.check import Float64Array
from leadthrough.motion import Demonstration, Trajectory
from leadthrough.preprocess.resample import arc_length

_RATE = 50.0  # Hz
_TREMOR_WAVES = 6


@dataclass(frozen=True)
class Teaching:
    """How a person guides.

    duration: s. spread: standard deviation of the ends, m. bow: of the greatest distance from the
    path wanted, as a share of its length. tremor: its root mean square, m. tremor_band: Hz.
    """

    duration: float = 4.0
    spread: float = 0.03
    bow: float = 0.05
    tremor: float = 0.001
    tremor_band: tuple[float, float] = (4.0, 10.0)


def guide(
    points: Float64Array, teaching: Teaching, rng: np.random.Generator, *, name: str = ""
) -> Demonstration:
    """A movement at rest at both ends, through points (n, d), n >= 2, or near them; in m."""
    wanted = np.asarray(points, dtype=np.float64)
    scattered = wanted + rng.normal(0.0, teaching.spread, wanted.shape)
    times = np.linspace(0.0, teaching.duration, int(teaching.duration * _RATE) + 1)
    u = times / teaching.duration
    progress = u**3 * (10.0 - 15.0 * u + 6.0 * u**2)
    knots = arc_length(scattered)
    curve = CubicSpline(knots / knots[-1], scattered)
    bow = rng.normal(0.0, teaching.bow * knots[-1], wanted.shape[1])
    path = curve(progress) + np.sin(np.pi * progress)[:, None] * bow
    # A hand that rests does not tremble on the recording: it begins and ends with the movement.
    shaking = _tremor(times, teaching, rng, wanted.shape[1]) * np.sin(np.pi * u)[:, None]
    return Demonstration(Trajectory(times, path + shaking), name=name)


def wander(
    lower: Float64Array, upper: Float64Array, teaching: Teaching, rng: np.random.Generator
) -> Demonstration:
    """A movement without a purpose: through five points drawn inside a box from lower to upper."""
    return guide(rng.uniform(lower, upper, (5, len(lower))), teaching, rng)


def _tremor(
    times: Float64Array, teaching: Teaching, rng: np.random.Generator, dimensions: int
) -> Float64Array:
    """A sum of sines whose frequencies and phases are drawn, (n, dimensions)."""
    frequencies = rng.uniform(*teaching.tremor_band, (_TREMOR_WAVES, dimensions))
    phases = rng.uniform(0.0, 2.0 * np.pi, (_TREMOR_WAVES, dimensions))
    waves = np.sin(2.0 * np.pi * frequencies * times[:, None, None] + phases)
    return np.asarray(teaching.tremor * np.sqrt(2.0 / _TREMOR_WAVES) * waves.sum(axis=1))

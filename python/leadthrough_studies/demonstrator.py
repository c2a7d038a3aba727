"""A simulated person who guides an arm by hand; all random numbers come from a given generator.

Point-to-point movements of people are straight to slightly curved and have a bell-shaped speed
(Flash and Hogan 1985, eq. 3: minimum jerk). Teaching by hand adds a curvature of its own to every
movement, scattered ends and tremor. Recordings of joints also have an irregular pace, pauses and
the resolution of encoders.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator

from leadthrough.check import Float64Array
from leadthrough.motion import Demonstration, JointTrajectory, Trajectory, normalised_times
from leadthrough.preprocess.resample import arc_length
from leadthrough.trajectories import minimum_jerk_time_scaling

_RATE = 50.0  # Hz
_TREMOR_WAVES = 6
_PACE_WAVES = 3
_PACE_BAND = (0.1, 0.5)  # Hz, of the variation of the speed


@dataclass(frozen=True)
class Teaching:
    """How a person guides the tip.

    Attributes:
        duration: duration, s.
        spread: standard deviation of every point guided through, m.
        bow: standard deviation of the greatest distance from the wanted path, as a fraction of the
            path's length.
        tremor: root mean square of the tremor, m.
        tremor_band: lowest and highest frequency of the tremor, Hz.
    """

    duration: float = 4.0
    spread: float = 0.03
    bow: float = 0.05
    tremor: float = 0.001
    tremor_band: tuple[float, float] = (4.0, 10.0)


@dataclass(frozen=True)
class JointTeaching:
    """How a person moves the joints of a compliant arm.

    Attributes:
        duration: shortest and longest duration without pauses, s.
        pace: standard deviation of the speed, as a fraction of the speed.
        pauses: largest number of pauses in a movement.
        pause: shortest and longest pause, s.
        tremor: root mean square of the tremor of each joint, rad.
        tremor_band: lowest and highest frequency of the tremor, Hz.
        encoder: encoder steps per turn; 12 bits are assumed, as the arm's maker states none.
    """

    duration: tuple[float, float] = (10.0, 16.0)
    pace: float = 0.2
    pauses: int = 2
    pause: tuple[float, float] = (0.3, 1.0)
    tremor: float = 0.001
    tremor_band: tuple[float, float] = (4.0, 10.0)
    encoder: int = 4096


def guide_joints(
    postures: Float64Array, teaching: JointTeaching, rng: np.random.Generator, *, name: str = ""
) -> Demonstration[JointTrajectory]:
    """A movement of the joints through postures, at rest at both ends, as encoders record it.

    Apart from the tremor, it stays between the postures.

    Args:
        postures: joint positions (n, joints), n >= 2, in rad.
        teaching: how the person moves the joints.
        rng: source of all random numbers.
        name: name of the demonstration.
    """
    wanted = np.asarray(postures, dtype=np.float64)
    knots = arc_length(wanted)
    curve = PchipInterpolator(
        knots / knots[-1], wanted
    )  # monotone between postures, so it never overshoots
    times, progress = _unsteady(teaching, rng)
    shaking = _tremor(times, teaching, rng, wanted.shape[1])
    fade = np.sin(np.pi * times / times[-1])[:, None]
    step = 2.0 * np.pi / teaching.encoder
    recorded = step * np.round((curve(progress) + fade * shaking) / step)
    return Demonstration(JointTrajectory(times, recorded), name=name)


def guide(
    points: Float64Array, teaching: Teaching, rng: np.random.Generator, *, name: str = ""
) -> Demonstration[Trajectory]:
    """A movement of the tip near or through points, at rest at both ends.

    Args:
        points: points (n, d), n >= 2, in m.
        teaching: how the person guides the tip.
        rng: source of all random numbers.
        name: name of the demonstration.
    """
    wanted = np.asarray(points, dtype=np.float64)
    scattered = wanted + rng.normal(0.0, teaching.spread, wanted.shape)
    times = np.linspace(0.0, teaching.duration, int(teaching.duration * _RATE) + 1)
    u = times / teaching.duration
    progress = minimum_jerk_time_scaling(u)
    knots = arc_length(scattered)
    curve = CubicSpline(knots / knots[-1], scattered)
    bow = rng.normal(0.0, teaching.bow * knots[-1], wanted.shape[1])
    path = curve(progress) + np.sin(np.pi * progress)[:, None] * bow
    # The tremor fades in and out, so that the recording begins and ends at rest.
    shaking = _tremor(times, teaching, rng, wanted.shape[1]) * np.sin(np.pi * u)[:, None]
    return Demonstration(Trajectory(times, path + shaking), name=name)


def wander(
    lower: Float64Array, upper: Float64Array, teaching: Teaching, rng: np.random.Generator
) -> Demonstration[Trajectory]:
    """A random movement through five points inside a box.

    Args:
        lower: lower corner (d,) of the box, m.
        upper: upper corner (d,) of the box, m.
        teaching: how the person guides the tip.
        rng: source of all random numbers.
    """
    return guide(rng.uniform(lower, upper, (5, len(lower))), teaching, rng)


def _unsteady(
    teaching: JointTeaching, rng: np.random.Generator
) -> tuple[Float64Array, Float64Array]:
    """Times, s, and the fraction of the path covered: minimum jerk with varying pace and pauses."""
    moving = rng.uniform(*teaching.duration)
    pauses = rng.uniform(*teaching.pause, rng.integers(teaching.pauses + 1))
    times = np.arange(int((moving + pauses.sum()) * _RATE) + 1) / _RATE
    u = normalised_times(times)
    speed = u**2 * (1.0 - u) ** 2 * _pace(times, teaching.pace, rng)
    for middle, length in zip(rng.uniform(0.2, 0.8, len(pauses)), pauses, strict=True):
        # Zero speed over the pause, with smooth flanks where the arm stops and starts again.
        away = 2.0 * np.abs(times - middle * times[-1]) / length
        speed *= 1.0 - np.exp(-((away / 1.2) ** 8))
    covered = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]))])
    return times, covered / covered[-1]


def _pace(times: Float64Array, variation: float, rng: np.random.Generator) -> Float64Array:
    """Slowly varying factors (n,) > 0 around 1."""
    frequencies = rng.uniform(*_PACE_BAND, _PACE_WAVES)
    phases = rng.uniform(0.0, 2.0 * np.pi, _PACE_WAVES)
    waves = np.sin(2.0 * np.pi * frequencies * times[:, None] + phases)
    return np.asarray(np.exp(variation * np.sqrt(2.0 / _PACE_WAVES) * waves.sum(axis=1)))


def _tremor(
    times: Float64Array,
    teaching: Teaching | JointTeaching,
    rng: np.random.Generator,
    dimensions: int,
) -> Float64Array:
    """A sum (n, dimensions) of sines with random frequencies and phases."""
    frequencies = rng.uniform(*teaching.tremor_band, (_TREMOR_WAVES, dimensions))
    phases = rng.uniform(0.0, 2.0 * np.pi, (_TREMOR_WAVES, dimensions))
    waves = np.sin(2.0 * np.pi * frequencies * times[:, None, None] + phases)
    return np.asarray(teaching.tremor * np.sqrt(2.0 / _TREMOR_WAVES) * waves.sum(axis=1))

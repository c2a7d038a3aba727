"""Measures of how well learning preserves the velocity of a motion.

The demonstrated ("shown") velocity is the central difference of the recording, unfiltered. The
learned velocity is the derivative of the ProMP's mean over the same duration. Each column of a
motion is measured separately:

peak_ratio: largest learned speed over the largest demonstrated speed: below 1 if peaks are lost,
  above 1 if learning overshoots.
position_rmse, velocity_rmse: root mean square errors, rad and rad/s, or m and m/s.
velocity_rmse_percent: velocity_rmse in percent of the demonstrated peak.
sign_changes_shown, _learned: number of sign changes of the acceleration, including those by noise.
reversals_shown, _learned: number of sign changes of the acceleration after which the velocity
  changes by more than 5 % of its peak: a single bell has 1.
bell_distance_shown, _learned: root mean square distance of the speed over its peak from a
  minimum-jerk bell, 16 u^2 (1 - u)^2: 0 for a bell, .58 at constant speed.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.models import ProMPSkill
from leadthrough.motion import Motion, normalised_times
from leadthrough_studies.human.polynomial import PolynomialMean
from leadthrough_studies.study import Row

_TURNED = 0.05
_DIGITS = 6


def velocity(times: Float64Array, positions: Float64Array) -> Float64Array:
    """Central differences (n, d) of positions (n, d)."""
    return np.asarray(np.gradient(positions, times, axis=0))


def learned(
    skill: ProMPSkill | PolynomialMean, motion: Motion
) -> tuple[Float64Array, Float64Array]:
    """The skill's mean positions and velocities, (n, d) each, at the times and pace of a motion."""
    same = skill.lasting(motion.duration)
    at = motion.times - motion.times[0]
    return same.distribution(at)[0], same.distribution(at, order=1)[0]


def fidelity(skill: ProMPSkill | PolynomialMean, motions: Sequence[Motion], column: int) -> Row:
    """The measures of one column, averaged over the demonstrated motions."""
    each = [_of_one(skill, motion, column) for motion in motions]
    return {name: float(np.mean([row[name] for row in each])) for name in each[0]}


def course(skill: ProMPSkill | PolynomialMean, motion: Motion, column: int) -> Row:
    """Time series of one column, as demonstrated and as learned, for the figures."""
    position, speed = learned(skill, motion)
    values = {
        "time": motion.times - motion.times[0],
        "position_shown": motion.positions[:, column],
        "position_learned": position[:, column],
        "velocity_shown": velocity(motion.times, motion.positions)[:, column],
        "velocity_learned": speed[:, column],
    }
    return {name: np.round(value, _DIGITS).tolist() for name, value in values.items()}


def _of_one(skill: ProMPSkill | PolynomialMean, motion: Motion, column: int) -> Row:
    position, made = (values[:, column] for values in learned(skill, motion))
    shown = velocity(motion.times, motion.positions)[:, column]
    peak = float(np.abs(shown).max())
    phases = normalised_times(motion.times)
    error = _rms(made - shown)
    return {
        "peak_ratio": float(np.abs(made).max()) / peak,
        "position_rmse": _rms(position - motion.positions[:, column]),
        "velocity_rmse": error,
        "velocity_rmse_percent": 100.0 * error / peak,
        "sign_changes_shown": sign_changes(shown),
        "sign_changes_learned": sign_changes(made),
        "reversals_shown": reversals(shown),
        "reversals_learned": reversals(made),
        "bell_distance_shown": bell_distance(phases, shown),
        "bell_distance_learned": bell_distance(phases, made),
    }


def sign_changes(speed: Float64Array) -> int:
    """Number of sign changes of the differences of a velocity (n,), ignoring zeros."""
    signs = np.sign(np.diff(speed))
    signs = signs[signs != 0.0]
    return int((signs[1:] != signs[:-1]).sum())


def reversals(speed: Float64Array) -> int:
    """Number of reversals of a velocity (n,) by more than 5 % of its peak."""
    least = _TURNED * float(np.abs(speed).max())
    extreme, direction, count = float(speed[0]), 0.0, 0
    for value in speed.tolist():
        ahead = (value - extreme) * direction > 0.0
        if not ahead and abs(value - extreme) > least:
            count += direction != 0.0
            direction, ahead = float(np.sign(value - extreme)), True
        if ahead:
            extreme = value
    return count


def bell_distance(phases: Float64Array, speed: Float64Array) -> float:
    """Root mean square distance of the speed over its peak (n,) from a bell."""
    size = np.abs(speed)
    return _rms(size / size.max() - 16.0 * phases**2 * (1.0 - phases) ** 2)


def _rms(values: Float64Array) -> float:
    return float(np.sqrt((values**2).mean()))

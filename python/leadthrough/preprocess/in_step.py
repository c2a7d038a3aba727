"""Whether demonstrations are in step, and the warps that bring them into step where they are not.

Warping also takes away differences that belong to the shapes, and predictions from what is left are
worse. So it is done freely where demonstrations are clearly out of step, with pauses of some for
example; else a little, where the mean of the others then predicts a left-out demonstration better;
else not at all.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.motion import Motion
from leadthrough.preprocess.curve_distance import dtw_distance
from leadthrough.preprocess.warps import features, mean_timing, spread, warped

# What the whole duration counts as when motions are warped, in their extent: little, and much.
FREE = 0.03
_RIGID = 2.0
# Out of step: free warping leaves less than this fraction of the spread.
_OUT_OF_STEP = 0.45
# Clearly so: of a few motions of random shapes, warping leaves 0.42 and more by chance.
_CLEARLY = 0.3
# A gain in predicting left-out demonstrations counts from this many standard errors on, of at least
# so many demonstrations. Fewer samples are enough to tell.
_SURELY = 2.0
_MIN_COUNT = 4
_FEW_SAMPLES, _MIN_SAMPLES = 200, 100
# Demonstrations this fraction of the duration ahead or behind are told, and as many are compared.
_LATE = 0.15
_MAX_COMPARED = 12
# A glance at fewer samples, warped once, leaves at least this fraction of the spread of motions in
# step: twice of what those clearly out of step keep after closer looks.
_GLANCED_SAMPLES, _GLANCED = 40, 2.0 * _CLEARLY
_ROUNDING = 1e-12  # of the motions' extent


def fractions_in_step(motions: Sequence[Motion]) -> list[Float64Array] | None:
    """Per motion, the fractions (1000,) of its duration that match even ones of the mean."""
    curves = features(motions)
    first = int(np.argmin([motion.duration for motion in motions]))
    free = mean_timing(curves, curves[first], rigidity=FREE)
    if spread(warped(curves, free)) < _OUT_OF_STEP * spread(curves):
        return free
    if _predicts_better(motions):
        return mean_timing(curves, curves[first], rigidity=_RIGID)
    return None


def lateness(motions: Sequence[Motion]) -> Float64Array:
    """How far each motion is ahead of or behind the mean timing, at most."""
    result = np.zeros(len(motions))
    if len(motions) < 2:
        return result
    some = np.linspace(0, len(motions) - 1, min(len(motions), _MAX_COMPARED)).round().astype(int)
    compared = [motions[i] for i in some]
    glanced = features(compared, _GLANCED_SAMPLES)
    warps = mean_timing(glanced, glanced[0], rigidity=FREE, rounds=1)
    if spread(warped(glanced, warps)) > _GLANCED * spread(glanced):
        return result
    curves = features(compared, _MIN_SAMPLES)
    warps = mean_timing(curves, curves[0], rigidity=FREE)
    if spread(warped(curves, warps)) < _CLEARLY * spread(curves):
        late = np.abs(np.array(warps) - np.linspace(0.0, 1.0, _MIN_SAMPLES)).max(axis=1)
        result[some] = np.where(late.max() > _LATE, late, 0.0)
    return result


def _predicts_better(motions: Sequence[Motion]) -> bool:
    """Whether means of rigidly warped motions predict left-out ones better than those of others."""
    if len(motions) < _MIN_COUNT:
        return False
    curves = features(motions, _FEW_SAMPLES)
    size = motions[0].positions.shape[1]
    gains = []
    for i, left_out in enumerate(curves):
        others = [each for j, each in enumerate(curves) if j != i]
        warps = mean_timing(others, others[0], rigidity=_RIGID)
        before = _errors(others, left_out, size)
        gains.append(1.0 - _errors(warped(others, warps), left_out, size) / before)
    gain, deviation = np.mean(gains, axis=0), np.std(gains, axis=0, ddof=1)
    error = deviation / np.sqrt(len(gains))
    return bool(gain[0] > _SURELY * error[0] and (gain > -error).all())


def _errors(curves: Sequence[Float64Array], left_out: Float64Array, size: int) -> Float64Array:
    """Errors of the mean of curves, carried to the ends of the left-out one."""
    rise = np.linspace(0.0, 1.0, len(left_out))[:, None]
    carried = [
        each + (1.0 - rise) * (left_out[0] - each[0]) + rise * (left_out[-1] - each[-1])
        for each in curves
    ]
    missed = np.mean(carried, axis=0) - left_out
    path, wanted = (missed + left_out)[:, :size], left_out[:, :size]
    groups = [missed[:, :size], missed[:, size:]][: 1 + (missed.shape[1] > size)]
    distances = [float(np.linalg.norm(group, axis=1).mean()) for group in groups]
    return np.array([dtw_distance(path, wanted) / len(wanted), *distances]) + _ROUNDING

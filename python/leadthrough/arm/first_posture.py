"""The posture to start a path in.

A path that is followed without a jump stays in the family of postures in which it began, and most
families end somewhere: at a joint limit or at a singularity. So several postures are followed ahead
along a thinned path. The one that gets furthest is preferred, then the one whose joints move slowly
and stay away from their limits.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from leadthrough import _core
from leadthrough.arm.options import free_axes
from leadthrough.arm.tracks import TipPath, solve_sample
from leadthrough.check import Float64Array

# Seeds for the first sample. An arm with a wrist has up to eight postures, and more in which
# a joint has made a whole turn; a redundant arm has a curve of them.
_SEEDS = 48
# The first of them also lead to the point of their curve nearest to the middle of the ranges.
_CENTRED_SEEDS = 16
# The most starts to return.
_STARTS = 24
# Two postures that differ by less than this in every joint are the same, rad or m.
_SAME_POSTURE = 1e-2
# Samples of the thinned path.
_LOOK_AHEAD = 40
# A joint this near to a limit, as a fraction of its range, costs as much as double speed.
_NEAR_A_LIMIT = 0.05


@dataclass(frozen=True, eq=False)
class Start:
    """A posture to start in."""

    q: Float64Array  # (joints,) at the first sample
    midrange: float  # rate in 1/s of the motion towards the wished postures from there


def seeded(chain: _core.Chain, path: TipPath, seed: Float64Array, midrange: float) -> list[Start]:
    """The starts next to `seed`, with and without the pull towards the wished postures."""
    (q,), *_ = solve_sample(chain, path, 0, seed[None], path.options())
    return [Start(q, rate) for rate in _rates(midrange)]


def first_postures(
    chain: _core.Chain,
    path: TipPath,
    *,
    velocity: Float64Array,
    midrange: float,
    tracking: tuple[_core.IkTolerance, int, float],
) -> list[Start]:
    """Starts for the path, the most promising first; at least one."""
    postures, reached = _solutions(chain, path)
    starts = [Start(q, rate) for q in postures for rate in _rates(midrange)]
    if not reached or len(starts) == 1:
        return starts[:1]
    samples = np.unique(np.linspace(0, len(path) - 1, _LOOK_AHEAD).round().astype(int))
    thin = path.only(samples)
    tolerance, iterations, max_step = tracking
    stride = math.ceil(len(path) / _LOOK_AHEAD)
    axes = free_axes(path.free)
    options = _core.TrackOptions(tolerance, iterations, max_step * stride, axes)
    keys = []
    for i, start in enumerate(starts):
        pull = thin.pull(start.midrange)
        q, *_ = _core.track(chain, thin.positions, thin.orientations, start.q, *pull, options)
        keys.append((-len(q), _cost(chain, q, thin.times, velocity), i))
    return [starts[i] for *_, i in sorted(keys)[:_STARTS]]


def _rates(midrange: float) -> tuple[float, ...]:
    return (midrange, 0.0) if midrange > 0.0 else (0.0,)


def _solutions(chain: _core.Chain, path: TipPath) -> tuple[Float64Array, bool]:
    seeds = _seeds(chain)
    q, status, errors = solve_sample(chain, path, 0, seeds, path.options())
    if not (status == 0).any():
        return q[[np.argmin(errors)]], False
    centred, its_status, _ = solve_sample(
        chain, path, 0, seeds[:_CENTRED_SEEDS], path.options(midrange=1.0)
    )
    return _distinct(np.vstack([q[status == 0], centred[its_status == 0]])), True


def _seeds(chain: _core.Chain) -> Float64Array:
    lower = np.maximum(chain.lower, -np.pi)
    upper = np.minimum(chain.upper, np.pi)
    samples = np.random.default_rng(0).uniform(0.0, 1.0, (_SEEDS - 1, len(lower)))
    return np.vstack([chain.middle, lower + samples * (upper - lower)])


def _distinct(q: Float64Array) -> Float64Array:
    kept = q[:1]
    for row in q[1:]:
        if (np.abs(kept - row).max(axis=1) > _SAME_POSTURE).all():
            kept = np.vstack([kept, row])
    return kept


def _cost(
    chain: _core.Chain, q: Float64Array, times: Float64Array, velocity: Float64Array
) -> float:
    """The largest joint speed over its limit, higher where joints come near position limits."""
    limit = np.where(np.isfinite(velocity) & (velocity > 0), velocity, 1.0)
    speeds = np.abs(np.diff(q, axis=0)) / np.diff(times[: len(q)])[:, None] / limit
    margin = margins(chain.lower, chain.upper, q).min()
    return float(speeds.max(initial=0.0)) * (1.0 + _NEAR_A_LIMIT / max(float(margin), 1e-9))


def margins(lower: Float64Array, upper: Float64Array, q: Float64Array) -> Float64Array:
    """The least distance (n,) of a joint to a limit as a fraction of its range; 0.5 at most."""
    bounded = np.isfinite(lower) & np.isfinite(upper) & (lower < upper)
    lower, upper, q = lower[bounded], upper[bounded], q[:, bounded]
    fractions = np.minimum(q - lower, upper - q) / (upper - lower)
    return np.asarray(fractions.min(axis=1, initial=0.5))

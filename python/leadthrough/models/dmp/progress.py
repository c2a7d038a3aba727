"""How far a demonstrated motion has come by each phase: how a moved start or goal enters.

They shift the motion by (1 - c(u)) of the one's offset and c(u) of the other's. c is the fraction
of its own way that the motion has covered: where it holds still the shift holds still too, and
where it is quick the shift is quick. c rises from 0 to 1, with c' = c'' = 0 at both ends.

It is measured on the replayed motion, so that a skill needs nothing for it but what it has learned.
Velocities are smoothed, and speeds below a few per cent of the highest count as none, so that noise
makes no progress.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import comb
from typing import TYPE_CHECKING

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.models.dmp.running_mean import running_mean
from leadthrough.trajectories.minimum_jerk import minimum_jerk_time_scaling

if TYPE_CHECKING:
    from scipy.interpolate import PPoly

# Velocities are sampled at this many intervals of the phase; c has this many pieces.
INTERVALS = 1000
_PIECES = 100
# Fraction of the motion over which velocities, and then speeds, are averaged, twice each.
_SMOOTHING = 0.02
# Fraction of the highest speed below which a motion counts as still.
_STILL = 0.03
# Fraction of the motion in which c starts and comes to rest, also where a recording does not.
_RAMP = 0.03
# Fractions of the motion that a correction takes: at least, after the end, and so much that it can
# end with the motion's own way. The end of a late one is a multiple of the step.
_LEAST = 0.1
_AFTER_END = 0.3
_AMPLE = 0.2
_STEP = 0.05
_ROUNDING = 1e-9
# c this near 1 has come to its end.
_DONE = 1e-4

_POWERS = np.arange(6)
_BINOMIALS = np.array([[comb(q, p) for q in _POWERS] for p in _POWERS], dtype=np.float64)
_RISES = np.maximum(_POWERS[None, :] - _POWERS[:, None], 0)


@dataclass(frozen=True, eq=False)
class Progress:
    """The fraction c(u) of its way that each channel of a motion has covered at phase u."""

    curve: PPoly  # c (channels,), a C2 piecewise polynomial over phases from 0 to 1

    @property
    def breaks(self) -> Float64Array:
        """Phases (pieces + 1,) where its pieces join."""
        return np.asarray(self.curve.x)

    @cached_property
    def coefficients(self) -> Float64Array:
        """Coefficients (6 pieces, channels) of the powers 0 to 5 of u - break, by piece."""
        known = self.curve.c[::-1].transpose(1, 0, 2)
        pieces, count, channels = known.shape
        powers = np.zeros((pieces, 6, channels))
        powers[:, :count] = known
        return powers.reshape(-1, channels)

    @cached_property
    def end(self) -> float:
        """The phase at which all channels are done, up to 1."""
        on_the_way = (self.curve(self.breaks) < 1.0 - _DONE).any(axis=1)
        return float(self.breaks[np.flatnonzero(on_the_way)[-1] + 1])

    @cached_property
    def _expansion(self) -> Float64Array:
        """The matrix (6 pieces, 6) that writes a polynomial about 0 as one about each break."""
        powers = self.breaks[:-1, None, None] ** _RISES
        return np.ascontiguousarray((_BINOMIALS * powers).reshape(-1, 6))

    def expanded(self, polynomial: Float64Array) -> Float64Array:
        """A polynomial (6, channels) about 0 as one about each break, (6 pieces, channels)."""
        return np.asarray(self._expansion @ polynomial)

    def shift(self, start: Float64Array, goal: Float64Array) -> Float64Array:
        """Coefficients (6 pieces, channels) of (1 - c) start + c goal, both (channels,)."""
        result = self.coefficients * (goal - start)
        result[::6] += start
        return result

    def scaled(self, height: Float64Array) -> PPoly:
        """The curve that rises to a height (channels,) instead of to 1."""
        from scipy.interpolate import PPoly

        return PPoly(self.curve.c * height, self.curve.x)

    def part(self, channels: slice) -> Progress:
        """That of some of the channels."""
        from scipy.interpolate import PPoly

        return Progress(PPoly(self.curve.c[:, :, channels], self.curve.x))


def corrected_until(phase: float, end: float) -> float:
    """The phase at which a correction that begins at a phase is done."""
    if phase <= end - _AMPLE:
        return end
    least = _LEAST if phase < 1.0 else _AFTER_END
    if phase + least <= 1.0:
        return 1.0
    return float(np.ceil((phase + least) / _STEP - _ROUNDING) * _STEP)


def progress_of(speeds: Float64Array) -> Progress:
    """The progress of channels with speeds (INTERVALS + 1, channels) at evenly spaced phases."""
    from scipy.interpolate import CubicHermiteSpline, PchipInterpolator, PPoly

    nodes = np.linspace(0.0, 1.0, _PIECES + 1)
    at_nodes = np.maximum(_averaged(speeds)[:: INTERVALS // _PIECES], 0.0)
    at_nodes[:, at_nodes.max(axis=0) <= 0.0] = 1.0
    from_rest = np.clip(np.minimum(nodes, 1.0 - nodes) / _RAMP, 0.0, 1.0)
    at_nodes = at_nodes / at_nodes.max(axis=0) * minimum_jerk_time_scaling(from_rest)[:, None]
    bends = PchipInterpolator(nodes, at_nodes).derivative()(nodes)
    bends[[0, -1]] = 0.0
    covered = CubicHermiteSpline(nodes, at_nodes, bends).antiderivative()
    whole: Float64Array = covered(1.0)
    return Progress(PPoly(covered.c / whole, nodes))


def speeds_of(velocities: Float64Array) -> Float64Array:
    """Smoothed speeds (n,) of velocities (n, d), over the highest; slow ones are 0."""
    speeds: Float64Array = np.linalg.norm(_averaged(velocities), axis=1)
    highest = speeds.max()
    return np.maximum(speeds / highest - _STILL, 0.0) if highest > 0.0 else speeds


def _averaged(values: Float64Array) -> Float64Array:
    """Running means of running means along the first axis."""
    size = int(_SMOOTHING * INTERVALS)
    return running_mean(running_mean(values, size), size)

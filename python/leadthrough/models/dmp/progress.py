"""Progress and pace of a replayed motion, which decide how a moved start or goal enters.

Moved ends shift the motion by (1 - c(u)) of the start's offset and c(u) of the goal's. c is the
fraction of its own path that the replayed motion has covered: it rises from 0 to 1, with
c' = c'' = 0 at both ends. If a query leaves the duration open, it is lengthened until no speed
exceeds MAX_SPEEDUP times its demonstrated peak; slow speeds and still parts set no pace.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import comb
from typing import TYPE_CHECKING

import numpy as np

from leadthrough import rotations
from leadthrough.check import Float64Array
from leadthrough.trajectories.minimum_jerk import minimum_jerk_time_scaling

if TYPE_CHECKING:
    from scipy.interpolate import PPoly

# Velocities are sampled at this many intervals of the phase; c has this many pieces.
INTERVALS = 1000
PHASES = np.linspace(0.0, 1.0, INTERVALS + 1)
COARSE_PHASES = np.linspace(0.0, 1.0, INTERVALS // 4 + 1)  # of the speeds of a query
_PIECES = 100
MAX_SPEEDUP = 1.3  # highest speed of a moved motion, over the demonstrated one
# Fraction of the motion over which velocities, and then speeds, are averaged, twice each.
_SMOOTHING = 0.02
# Fraction of the highest speed below which a motion counts as still.
_STILL = 0.03
# Fraction of the motion in which c starts and comes to rest, also where a recording does not.
_RAMP = 0.03
# Fractions of the motion that a correction takes: at least, after the end, and so much that it can
# end with the motion itself. The end of a late one is a multiple of the step.
_MIN_CORRECTION = 0.1
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
    """The fraction c(u) of its path that each channel of a motion has covered at phase u."""

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
        underway = (self.curve(self.breaks) < 1.0 - _DONE).any(axis=1)
        return float(self.breaks[np.flatnonzero(underway)[-1] + 1])

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
    least = _MIN_CORRECTION if phase < 1.0 else _AFTER_END
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


@dataclass(frozen=True)
class Measure:
    """Thresholds of one kind of motion below which it counts as slow, or as still."""

    slow: float  # speed, per second, that no motion is held back from
    still: float  # extent of a motion that hardly moves
    fastest: bool = False

    def peak(self, velocities: Float64Array) -> float:
        """The highest speed of velocities (n, d)."""
        if self.fastest:
            return float(np.abs(velocities).max())
        return float(np.linalg.norm(velocities, axis=1).max())


MOVING = Measure(slow=0.05, still=2e-3)  # m, or a drawing's unit
ROTATING = Measure(slow=0.25, still=0.05)  # rad
JOINTS = Measure(slow=0.25, still=0.0, fastest=True)  # rad


@dataclass(frozen=True, eq=False)
class Part:
    """A position, an orientation or joints, as replayed."""

    measure: Measure
    velocities: Float64Array  # (INTERVALS + 1, d) per unit of phase, at PHASES
    extent: float  # the farthest that it gets from its start

    @property
    def weight(self) -> float:
        """Weight of its own speed in its progress: from 0, where it is still, to 1."""
        own, still = self.extent**4, self.measure.still**4
        return own / (own + still) if own > 0.0 else 0.0

    @cached_property
    def _own_peak(self) -> float:
        return self.measure.peak(self.velocities)

    def lengthening(self, peak: float, duration: float) -> float:
        """The factor by which a motion of another highest speed must take longer."""
        if self.extent <= self.measure.still:
            return 1.0
        slow = self.measure.slow * duration
        allowed = max(MAX_SPEEDUP * self._own_peak, slow)
        return max(peak / allowed, 1.0)


def pose_progress(moving: Part, rotating: Part) -> Progress:
    """The progress of six channels, three of a position and three of an orientation."""
    own = [speeds_of(part.velocities) for part in (moving, rotating)]
    mixed = [
        part.weight * mine + (1.0 - part.weight) * other
        for part, mine, other in zip((moving, rotating), own, own[::-1], strict=True)
    ]
    return progress_of(np.repeat(np.column_stack(mixed), 3, axis=1))


def angular_velocities(orientations: Float64Array) -> Float64Array:
    """Angular velocities (n, 3), rad per unit of phase, of orientations (n, 4) at even phases."""
    turns = rotations.compose(orientations[1:], rotations.inverse(orientations[:-1]))
    between = rotations.log(turns) * len(turns)
    return np.concatenate([between[:1], 0.5 * (between[1:] + between[:-1]), between[-1:]])


def running_mean(values: Float64Array, size: int, mode: str = "nearest") -> Float64Array:
    """Means (n,) or (n, d) over `size` neighbouring samples."""
    # To the last bit those of SciPy's `uniform_filter1d`, which takes long to import.
    before = size // 2
    beside = [(before, size - 1 - before)] + [(0, 0)] * (values.ndim - 1)
    padded = np.pad(values, beside, mode="edge" if mode == "nearest" else "wrap")
    # One sum that goes along, in the order of the samples.
    first = np.add.accumulate(padded[:size], axis=0)[-1:]
    steps = padded[size:] - padded[:-size]
    return np.asarray(np.add.accumulate(np.concatenate([first, steps]), axis=0) / size)

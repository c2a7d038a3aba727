"""The transformation system of movement primitives: springs with learned forces.

Each channel y is r(u) + e: a reference r from start to goal and an error e that obeys
e'' = -2 RATE e' - RATE^2 e + f(u) over the phase u, time by duration, with alpha = 2 RATE,
beta = alpha / 4 and tau = 1 in the literature's letters. The force is made of kernels in the
canonical state x of discrete motions, or in the angle of rhythmic ones. The forms:

- "blended": r is the minimum-jerk motion from start to goal with their velocities; e begins and
  ends at 0, and the force is not scaled. Hoffmann et al. 2009, their decaying goal replaced.
- "hoffmann": tau v' = K (g - x) - D v - K (g - x0) x(u) + K f (Hoffmann et al. 2009; Pastor 2009).
- "ijspeert": r = g, and the force is scaled by g - y0 (Ijspeert et al. 2002; 2013, section 2.1).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

import leadthrough._core as core
from leadthrough import check
from leadthrough.check import Float64Array, ShortRepr
from leadthrough.models.dmp.progress import Progress
from leadthrough.trajectories.minimum_jerk import quintic_coefficients

FORMS = ("blended", "hoffmann", "ijspeert")
RHYTHMIC = "rhythmic"  # r is the centre of the motion, and the force repeats

RATE = 12.5  # per unit of phase: alpha = 25, beta = 6.25

# Of the canonical state x = exp(-DECAY u), which solves tau x' = -DECAY x and ends at 1 %, as in
# Pastor et al. 2009.
DECAY = float(-np.log(0.01))
MAX_WEIGHTS = 1000

# A force is tabulated at this many evenly spaced phases per weight, and is linear between them.
_INTERVALS_PER_WEIGHT = 20
_ENTRIES = 3_300_000  # of a table that is made at a time
_NEIGHBOURS, _UNDERFLOW = 50, 750.0  # kernels; exp(-750) is 0
# Value of a kernel at its neighbour's centre; 1 at its own.
OVERLAP = 0.8
_ALL = slice(None)


@dataclass(frozen=True, eq=False)
class Kernels:
    """Kernels at evenly spaced phases from 0 to 1; tables of all of them may take gigabytes."""

    phases: Float64Array  # (m,)
    centres: Float64Array  # (weights,) canonical states, of rhythms phases
    sharpness: Float64Array  # (weights,)
    fade: Float64Array  # (m,) canonical state
    rhythmic: bool  # whether they repeat with period 1

    def tables(self, rows: slice = _ALL, some: slice = _ALL) -> tuple[Float64Array, Float64Array]:
        """Values (m, weights), not normalised, and what a weight multiplies where one counts."""
        centres, sharpness = self.centres[some], self.sharpness[some]
        if self.rhythmic:
            angles = 2.0 * np.pi * (self.phases[rows, None] - centres)
            values = np.exp(sharpness * (np.cos(angles) - 1.0))
            return values, np.ones_like(values)
        x, reach = self.fade[rows, None], np.sqrt(_UNDERFLOW / sharpness)
        values = np.zeros((len(x), len(centres)))
        for first in range(0, len(centres), _NEIGHBOURS):
            own = slice(first, first + _NEIGHBOURS)
            farthest = (centres + reach)[own].max(), (centres - reach)[own].min()
            near = slice(*np.searchsorted(-x[:, 0], np.negative(farthest)))
            values[near, own] = np.exp(-sharpness[own] * (x[near] - centres[own]) ** 2)
        return values, x / centres

    def features(self, rows: slice = _ALL, some: slice = _ALL) -> Float64Array:
        """Features (m, weights): the force is features @ weights."""
        if len(self.parts) == 1:
            return np.ascontiguousarray(self._features[rows, some])
        return self._computed(rows, some)

    @cached_property
    def _features(self) -> Float64Array:
        return self._computed(_ALL, _ALL)

    def _computed(self, rows: slice, some: slice) -> Float64Array:
        values, regressor = self.tables(rows, some)
        values /= self._sums[rows, None]
        values *= regressor
        return values

    @cached_property
    def parts(self) -> list[slice]:
        """Ranges of the phases, with tables of moderate size."""
        count = _ENTRIES // len(self.centres)
        return [slice(first, first + count) for first in range(0, len(self.phases), count)]

    @cached_property
    def _sums(self) -> Float64Array:
        return np.concatenate([self.tables(rows)[0].sum(axis=1) for rows in self.parts])


@dataclass(frozen=True, eq=False)
class Ends(ShortRepr):
    """Values and slopes of channels at both ends."""

    start: Float64Array  # values (channels,) at phase 0
    goal: Float64Array  # values (channels,) at phase 1; of a rhythm, its centre
    start_slope: Float64Array  # derivatives (channels,) by the phase at 0
    goal_slope: Float64Array  # derivatives (channels,) by the phase at 1

    def part(self, channels: slice) -> Ends:
        """Those of some of the channels."""
        return Ends(
            self.start[channels],
            self.goal[channels],
            self.start_slope[channels],
            self.goal_slope[channels],
        )

    def equal(self, other: Ends) -> bool:
        """Whether all values are those of others."""
        pairs = zip(vars(self).values(), vars(other).values(), strict=True)
        # As lists, which so few numbers are compared in a quarter of the time.
        return all(mine is theirs or mine.tolist() == theirs.tolist() for mine, theirs in pairs)

    def moved(self, start: Float64Array, goal: Float64Array) -> Ends:
        return Ends(start, goal, self.start_slope, self.goal_slope)

    def joined(self, other: Ends) -> Ends:
        """These channels followed by others."""
        pairs = zip(vars(self).values(), vars(other).values(), strict=True)
        return Ends(*(np.concatenate(pair) for pair in pairs))


@dataclass(frozen=True, eq=False)
class TransformationSystem(ShortRepr):
    """Channels driven by springs and learned forces."""

    form: str  # one of FORMS, or RHYTHMIC
    weights: Float64Array  # (weights, channels)
    ends: Ends  # as demonstrated
    overlap: float = OVERLAP  # of the kernels

    @property
    def kernels(self) -> Kernels:
        return kernels_of(self.form, len(self.weights), self.overlap)

    @cached_property
    def forces(self) -> core.DmpForces:
        return tabulated(self.kernels, self.weights)

    @cached_property
    def demonstrated_course(self) -> core.DmpCourse:
        return course(self.form, self.ends)

    def arrays(self) -> dict[str, Float64Array]:
        overlap = np.array([self.overlap])
        return {"weights": self.weights, **vars(self.ends), "overlap": overlap}

    @staticmethod
    def from_arrays(form: str, weights: int, arrays: Mapping[str, Any]) -> TransformationSystem:
        known = check.frozen(arrays["weights"], "weights", shape=(weights, "channels"))
        ends = [
            check.frozen(arrays[field.name], field.name, shape=(known.shape[1],))
            for field in fields(Ends)
        ]
        overlap = check.frozen(arrays.get("overlap", [OVERLAP]), "overlap", shape=(1,))
        return TransformationSystem(form, known, Ends(*ends), float(overlap[0]))


def kernels_of(form: str, weights: int, overlap: float = OVERLAP) -> Kernels:
    return von_mises_kernels(weights) if form == RHYTHMIC else gaussian_kernels(weights, overlap)


@lru_cache(maxsize=8)
def gaussian_kernels(weights: int, overlap: float) -> Kernels:
    """Gaussian kernels in the canonical state x, whose regressor is x / c_i.

    The centres c_i = exp(-DECAY i / (weights - 1)) are evenly spaced in time; the widths follow
    from the overlap. The literature does not divide by c_i; it makes all weights similar in size.
    """
    centres = _canonical_state(np.linspace(0.0, 1.0, weights))
    gaps = -np.diff(centres)
    inverse_widths = -np.log(overlap) / np.append(gaps, gaps[-1]) ** 2
    phases = _node_phases(weights)
    return Kernels(phases, centres, inverse_widths, _canonical_state(phases), rhythmic=False)


@lru_cache(maxsize=8)
def von_mises_kernels(weights: int) -> Kernels:
    """Von Mises kernels, evenly spaced, whose regressor is 1."""
    phases, centres = _node_phases(weights), np.arange(weights) / weights
    width = -np.log(OVERLAP) / (1.0 - np.cos(2.0 * np.pi / weights))
    return Kernels(phases, centres, np.full(weights, width), np.zeros_like(phases), rhythmic=True)


def _canonical_state(phases: Float64Array) -> Float64Array:
    return np.asarray(np.exp(-DECAY * phases))


def _node_phases(weights: int) -> Float64Array:
    return np.linspace(0.0, 1.0, _INTERVALS_PER_WEIGHT * weights + 1)


def tabulated(kernels: Kernels, weights: Float64Array) -> core.DmpForces:
    nodes = [kernels.features(rows) @ weights for rows in kernels.parts]
    return core.DmpForces(np.concatenate(nodes), kernels.fade, RATE, kernels.rhythmic)


def course(form: str, ends: Ends, *, amplitude: float = 1.0) -> core.DmpCourse:
    """The course between ends: reference of every channel, gain of its force, and drive."""
    count = len(ends.goal)
    gain, drive = np.full(count, amplitude), np.zeros(count)
    if form == "blended":
        reference = minimum_jerk(ends)
    else:
        reference = np.zeros((6, count))
        reference[0] = ends.goal
    if form == "hoffmann":
        drive = -(RATE**2) * (ends.goal - ends.start)
    elif form == "ijspeert":
        gain = ends.goal - ends.start
    return core.DmpCourse(np.array([0.0, 1.0]), np.ascontiguousarray(reference), gain, drive)


def with_via(before: core.DmpCourse, via: Sequence[tuple[float, Float64Array]]) -> core.DmpCourse:
    """A course with detours: the minimum-jerk spline through them, at rest and 0 at both ends."""
    from scipy.interpolate import make_interp_spline

    phases = np.array([0.0, *(phase for phase, _ in via), 1.0])
    nothing = np.zeros(len(before.gain))
    offsets = np.array([nothing, *(offset for _, offset in via), nothing])
    rest = [(1, nothing), (2, nothing)]
    detour = make_interp_spline(phases, offsets, k=5, bc_type=(rest, rest))
    return _added(before, detour, phases)


def shifted(before: core.DmpCourse, progress: Progress, goal: Float64Array) -> core.DmpCourse:
    """A course whose goal is shifted before it has begun: the shift enters by the progress."""
    return _added(before, progress.scaled(goal), progress.breaks)


def redirected(form: str, before: core.DmpCourse, goal: Float64Array) -> core.DmpCourse:
    """The course with another goal (channels,), to which the springs lead at once."""
    shift = goal - end_of(before)
    coefficients = before.coefficients.copy()
    coefficients[::6] += shift
    gain = before.gain + shift if form == "ijspeert" else before.gain
    drive = before.drive - RATE**2 * shift if form == "hoffmann" else before.drive
    return core.DmpCourse(before.breaks, coefficients, gain, drive)


def scaled_by(before: core.DmpCourse, channels: slice, gain: Float64Array) -> core.DmpCourse:
    """The course with other gains (count,) of the forces of some channels."""
    gains = before.gain.copy()
    gains[channels] = gain
    return core.DmpCourse(before.breaks, before.coefficients, gains, before.drive)


def between(start: Float64Array, goal: Float64Array) -> Float64Array:
    """Coefficients (6, channels) of the powers of u of the minimum-jerk motion between values."""
    rest = np.zeros_like(start)
    return np.ascontiguousarray(minimum_jerk(Ends(start, goal, rest, rest)))


def minimum_jerk(ends: Ends) -> Float64Array:
    """Coefficients (6, channels) of the powers of u from start to goal, at no acceleration."""
    return quintic_coefficients(ends.start, ends.goal, ends.start_slope, ends.goal_slope)


def end_of(course: core.DmpCourse) -> Float64Array:
    """Values (channels,) at the end of a course."""
    breaks = course.breaks
    powers = (breaks[-1] - breaks[-2]) ** np.arange(6.0)
    return np.asarray(powers @ course.coefficients[-6:])


def _added(before: core.DmpCourse, curve: Any, breaks: Float64Array) -> core.DmpCourse:
    """A course plus a curve (channels,) whose pieces join at breaks."""
    from scipy.interpolate import PPoly

    powers = before.coefficients.reshape(-1, 6, len(before.gain)).transpose(1, 0, 2)[::-1]
    joined = np.union1d(before.breaks, breaks)
    coefficients = _taylor(PPoly(powers, before.breaks), joined) + _taylor(curve, joined)
    return core.DmpCourse(joined, coefficients, before.gain, before.drive)


def _taylor(curve: Any, breaks: Float64Array) -> Float64Array:
    factorials = (1.0, 1.0, 2.0, 6.0, 24.0, 120.0)
    blocks = [curve(breaks[:-1], order) / scale for order, scale in enumerate(factorials)]
    return np.ascontiguousarray(np.stack(blocks, axis=1).reshape(-1, blocks[0].shape[1]))

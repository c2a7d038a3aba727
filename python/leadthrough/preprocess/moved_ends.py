"""Curves carried to new ends: shifted, rotated with the chord, and bounded by the ends' moves."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from leadthrough.check import Float64Array

# Factor by which a moved end moves the motion at any phase, at most.
MAX_GAIN = 1.45
# Fraction that rotates with the chord; the rest is shifted.
ROTATED = 1.0 / 3.0
# Between these ratios of a curve's chord to its length, rotation fades in: a motion that returns
# to its start has no direction to rotate from.
_RETURNING = (0.05, 0.1)
# Rotation by more than 154 degrees or scaling by more than 5 says little about the new motion, and
# nothing rotates; inside, it fades in over so much of the cosine and of the scale's logarithm.
_MIN_COSINE, _MAX_SCALE = -0.9, 5.0
_FADING_IN = 0.3
_TINY = 1e-300


def with_ends(
    curve: Float64Array,
    start: Float64Array,
    goal: Float64Array,
    fractions: Float64Array | None = None,
) -> Float64Array:
    """Curves (..., n, d), both ends' offsets blended linearly along them or over fractions (n,)."""
    u = np.linspace(0.0, 1.0, curve.shape[-2]) if fractions is None else fractions
    first, last = curve[..., :1, :], curve[..., -1:, :]
    return np.asarray(curve + (1.0 - u)[:, None] * (start - first) + u[:, None] * (goal - last))


@dataclass(frozen=True, eq=False)
class Chords:
    """Curves (k, n, d) to rotate with the chords between their ends."""

    curves: Float64Array

    @cached_property
    def _points(self) -> Float64Array:
        return np.asarray(self.curves - self.curves[:, -1:])

    @cached_property
    def _lengths(self) -> Float64Array:
        return np.asarray(np.linalg.norm(self._points[:, 0], axis=1))

    @cached_property
    def _directions(self) -> Float64Array:
        """Unit vectors (k, d) from goal to start."""
        return np.asarray(self._points[:, 0] / np.maximum(self._lengths, _TINY)[:, None])

    @cached_property
    def _along(self) -> Float64Array:
        """Twice the points' coordinates (k, n) along the chords."""
        return np.asarray(2.0 * np.einsum("knd,kd->kn", self._points, self._directions))

    @cached_property
    def _directed(self) -> Float64Array:
        """The fractions (k,) in [0, 1] by which the curves have a direction."""
        length = np.linalg.norm(np.diff(self.curves, axis=1), axis=2).sum(axis=1)
        ratio = self._lengths / np.maximum(length, _TINY)
        ready = (ratio - _RETURNING[0]) / (_RETURNING[1] - _RETURNING[0])
        return np.asarray(np.clip(ready, 0.0, 1.0))

    def adapted(
        self, ends: Float64Array, shifted: Float64Array, part: float = ROTATED
    ) -> Float64Array:
        """The curves (m, k, n, d) with ends (m, 2, d), a part rotated and the rest as given."""
        wanted = ends[:, 0] - ends[:, 1]
        length = np.linalg.norm(wanted, axis=1)[:, None]
        b = wanted / np.maximum(length, _TINY)
        cosine = b @ self._directions.T
        scale = length / np.maximum(self._lengths, _TINY)
        inside = np.log(_MAX_SCALE) - np.abs(np.log(np.maximum(scale, _TINY)))
        sound = np.clip(np.minimum(cosine - _MIN_COSINE, inside) / _FADING_IN, 0.0, 1.0)
        between = self._directions + b[:, None]
        across = np.einsum("knd,mkd->mkn", self._points, between)
        across /= np.where(sound > 0.0, 1.0 + cosine, 1.0)[..., None]
        rotated = self._points - across[..., None] * between[:, :, None]
        rotated += self._along[..., None] * b[:, None, None]
        rotated *= np.where(sound > 0.0, scale, 1.0)[..., None, None]
        rotated += ends[:, None, 1:]
        fraction = part * (sound * self._directed)[..., None, None]
        return np.asarray((1.0 - fraction) * shifted + fraction * rotated)


def bounded(path: Float64Array, nominal: Float64Array, moved: float | None = None) -> Float64Array:
    """A path (n, d) drawn to a nominal one until none moves beyond `MAX_GAIN` times its ends."""
    if moved is None:
        moved = float(np.linalg.norm((path - nominal)[[0, -1]], axis=1).max())
    shifted = with_ends(nominal, path[0], path[-1])
    off, change = shifted - nominal, path - shifted
    if np.linalg.norm(off + change, axis=1).max() <= MAX_GAIN * moved:
        return path
    return np.asarray(shifted + fraction_inside(off, change, MAX_GAIN * moved) * change)


def fraction_inside(base: Float64Array, more: Float64Array, limit: float) -> float:
    """The largest fraction in [0, 1] with |base + fraction more| <= limit in every row."""
    squared = (more**2).sum(axis=1)
    mixed = (base * more).sum(axis=1)
    room = np.maximum(limit**2 - (base**2).sum(axis=1), 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        largest = (np.sqrt(mixed**2 + squared * room) - mixed) / squared
    return float(np.where(squared > 0.0, largest, 1.0).min(initial=1.0))

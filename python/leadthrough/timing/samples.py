"""Samples of a motion, cut, joined and differentiated."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from leadthrough import _core
from leadthrough.check import Float64Array


@dataclass(frozen=True, eq=False)
class Samples:
    """Samples of a motion."""

    times: Float64Array  # s from the start, (n,)
    places: Float64Array  # where on the path, counted in its way-points, samples or knots, (n,)
    positions: Float64Array  # rad (m), (n, joints)
    velocities: Float64Array  # rad/s (m/s), (n, joints)
    accelerations: Float64Array  # rad/s^2 (m/s^2), (n, joints)

    @staticmethod
    def at_rest(q: Float64Array) -> Samples:
        """A single sample at rest at a configuration (joints,)."""
        still = np.zeros((1, len(q)))
        return Samples(np.zeros(1), np.zeros(1), q[None].copy(), still, still)

    def held_before(self, time: float, rate: float) -> Samples:
        """The motion after a rest."""
        return self._rest(0, time, rate).followed_by(self) if time > 0.0 else self

    def held(self, time: float, rate: float) -> Samples:
        """The motion followed by a rest."""
        return self.followed_by(self._rest(-1, time, rate)) if time > 0.0 else self

    def followed_by(self, other: Samples) -> Samples:
        """Both motions; the other begins where this one ends."""
        return Samples(
            np.concatenate([self.times, self.times[-1] + other.times[1:]]),
            np.concatenate([self.places, other.places[1:]]),
            np.vstack([self.positions, other.positions[1:]]),
            np.vstack([self.velocities, other.velocities[1:]]),
            np.vstack([self.accelerations, other.accelerations[1:]]),
        )

    @staticmethod
    def joined(motions: Sequence[Samples]) -> Samples:
        """All motions; each begins where the one before ends."""
        if len(motions) == 1:
            return motions[0]
        ends = np.cumsum([0.0, *(motion.times[-1] for motion in motions[:-1])])
        cut = [slice(int(i > 0), None) for i in range(len(motions))]
        pairs = list(zip(motions, cut, strict=True))
        return Samples(
            np.concatenate([end + m.times[c] for end, (m, c) in zip(ends, pairs, strict=True)]),
            np.concatenate([m.places[c] for m, c in pairs]),
            np.concatenate([m.positions[c] for m, c in pairs]),
            np.concatenate([m.velocities[c] for m, c in pairs]),
            np.concatenate([m.accelerations[c] for m, c in pairs]),
        )

    def with_rests(self, rows: NDArray[np.intp], rests: Float64Array, rate: float) -> Samples:
        """The motion with further rests."""
        copies = np.ones(len(self.times), dtype=np.intp)
        copies[rows] += np.ceil(rests * rate - 1e-9).astype(np.intp)
        if (copies == 1).all():
            return self
        later = np.concatenate([[0], np.cumsum(copies[:-1] - 1)]) / rate
        repeated = self._rows(np.repeat(np.arange(len(self.times)), copies))
        within = np.arange(len(repeated.times)) - np.repeat(np.cumsum(copies) - copies, copies)
        return replace(repeated, times=repeated.times + np.repeat(later, copies) + within / rate)

    def some(self, count: int) -> Samples:
        """At most `count` evenly spread samples."""
        return self._rows(np.unique(np.linspace(0, len(self.times) - 1, count).astype(np.intp)))

    def thinned(self, parts: int) -> Samples:
        """Every sample of `parts` and the last; one half a step or less before it is left out."""
        if parts == 1:
            return self
        last = len(self.times) - 1
        rows = np.arange(0, last, parts)
        if len(rows) > 1 and last - rows[-1] < 0.5 * parts:
            rows = rows[:-1]
        return self._rows(np.append(rows, last))

    def _rest(self, end: int, time: float, rate: float) -> Samples:
        """Standing still where the motion begins or ends."""
        count = math.ceil(time * rate - 1e-9) + 1
        positions = np.repeat(self.positions[[end]], count, axis=0)
        still, places = np.zeros_like(positions), np.repeat(self.places[end], count)
        return Samples(np.arange(count) / rate, places, positions, still, still)

    def _rows(self, rows: NDArray[np.intp]) -> Samples:
        return Samples(
            self.times[rows],
            self.places[rows],
            self.positions[rows],
            self.velocities[rows],
            self.accelerations[rows],
        )


def differentiated(
    times: Float64Array,
    places: Float64Array,
    q: Float64Array,
    path: _core.TimedPath,
    *,
    speeds: tuple[float, float],
) -> Samples:
    """Samples with their central differences as velocities and accelerations."""
    first, last = times[1] - times[0], times[-1] - times[-2]
    ends = path.length[[0, -1]] + np.array([-speeds[0] * first, speeds[1] * last])
    beyond = path.positions_at(np.ascontiguousarray(ends))
    velocities, accelerations = _core.central_differences(times, q, beyond)
    for end, speed in zip((0, -1), speeds, strict=True):  # there they are known exactly
        velocities[end] = path.first[end] * speed
        accelerations[end] = path.second[end] * speed**2
    return Samples(times, places, q, velocities, accelerations)

"""The pace of a replayed motion: how it comes along, and how much longer a moved one takes.

A start or goal that is moved along the motion's own way makes the motion quicker. Where a query
leaves the duration open, it is lengthened until no speed, linear, angular or of the fastest joint,
exceeds `QUICKER` times its demonstrated peak. Speeds that are slow anyway are not held back, and a
tool that hardly moves, or hardly turns, when it is shown sets no pace for that.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from leadthrough import rotations
from leadthrough.check import Float64Array
from leadthrough.models.dmp.progress import INTERVALS, Progress, progress_of, speeds_of

QUICKER = 1.3  # highest speed of a moved motion, over the demonstrated one
PHASES = np.linspace(0.0, 1.0, INTERVALS + 1)
COARSE_PHASES = np.linspace(0.0, 1.0, INTERVALS // 4 + 1)  # where a query's speeds are looked at


@dataclass(frozen=True)
class Measure:
    """What counts as slow and as still, in one kind of motion."""

    slow: float  # speed, per second, that no motion is held back from
    still: float  # extent of a motion that hardly moves
    fastest: bool = False

    def peak(self, velocities: Float64Array) -> float:
        """The highest speed of velocities (n, d)."""
        if self.fastest:
            return float(np.abs(velocities).max())
        return float(np.linalg.norm(velocities, axis=1).max())


MOVING = Measure(slow=0.05, still=2e-3)  # m, or a drawing's unit
TURNING = Measure(slow=0.25, still=0.05)  # rad
JOINTS = Measure(slow=0.25, still=0.0, fastest=True)  # rad


@dataclass(frozen=True, eq=False)
class Part:
    """A position, an orientation or joints, as replayed."""

    measure: Measure  # what is slow and what is still
    velocities: Float64Array  # (INTERVALS + 1, d) per unit of phase, at PHASES
    extent: float  # the farthest that it gets from its start

    @property
    def weight(self) -> float:
        """How much its own speed says about its progress: from 0, where it is still, to 1."""
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
        allowed = max(QUICKER * self._own_peak, slow)
        return max(peak / allowed, 1.0)


def pose_progress(moving: Part, turning: Part) -> Progress:
    """The progress of six channels, three of a position and three of an orientation."""
    own = [speeds_of(part.velocities) for part in (moving, turning)]
    mixed = [
        part.weight * mine + (1.0 - part.weight) * other
        for part, mine, other in zip((moving, turning), own, own[::-1], strict=True)
    ]
    return progress_of(np.repeat(np.column_stack(mixed), 3, axis=1))


def spins_of(orientations: Float64Array) -> Float64Array:
    """Angular velocities (n, 3), rad per unit of phase, of orientations (n, 4) at even phases."""
    turns = rotations.compose(orientations[1:], rotations.inverse(orientations[:-1]))
    between = rotations.log(turns) * len(turns)
    return np.concatenate([between[:1], 0.5 * (between[1:] + between[:-1]), between[-1:]])

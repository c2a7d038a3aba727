"""The end of a motion: a system comes to its goal only after all time, a motion has to be there.

From a twentieth of the motion's size on, a trajectory is continued to rest at the goal by
the polynomial of fifth order that begins with its velocity and acceleration.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BPoly, CubicHermiteSpline

from leadthrough.check import Float64Array
from leadthrough.errors import NoPath
from leadthrough.models.dynamical.field import Field
from leadthrough.models.dynamical.integration import course
from leadthrough.repr import ShortRepr

# Distances from the goal at which a trajectory has arrived, and at which a motion's last piece
# begins, in sizes of the motion.
NEAR, _LAST = 0.01, 0.05
# Time after which it is given up, in durations of the demonstrations.
LONGEST = 100.0
# The last piece takes this many times as long as at the speed with which it begins, as the end of a
# minimum-jerk motion does; and at most this much, in durations.
_SLOWING, _LONGEST_END = 2.7, 0.25


@dataclass(frozen=True, eq=False)
class Way(ShortRepr):
    """A trajectory from a start to rest at the goal."""

    times: Float64Array
    positions: Float64Array  # positions (n, d) there
    velocities: Float64Array  # velocities (n, d) there

    @property
    def duration(self) -> float:
        """In durations of the demonstrations."""
        return float(self.times[-1])

    def at(self, phases: Float64Array) -> Float64Array:
        """Positions (n, d) at fractions (n,) of the duration."""
        spline = CubicHermiteSpline(self.times, self.positions, self.velocities)
        return np.asarray(spline(phases * self.duration))


def way(field: Field, start: Float64Array) -> Way:
    """The way from a start (d,) to the goal at 0."""
    found = course(field, start, near=_LAST, longest=LONGEST)
    d = len(start)
    x, v = found.states[:, :d], field_velocity(found.states, found.rates, d)
    if np.linalg.norm(x[-1]) > _LAST:
        raise NoPath(
            f"start: the goal was not reached in {LONGEST:.0f} times the demonstrations' duration; "
            "start nearer to the demonstrations, or check the skill's stability",
            reason="not_reached",
        )
    times, ending, slopes = _ending(found.times, x, v)
    return Way(
        np.concatenate([found.times, found.times[-1] + times]),
        np.concatenate([x, ending]),
        np.concatenate([v, slopes]),
    )


def field_velocity(states: Float64Array, rates: Float64Array, size: int) -> Float64Array:
    """Velocities (n, d) of states (n, s): a state of second order holds them."""
    return states[:, size:] if states.shape[1] > size else rates[:, :size]


def _ending(
    times: Float64Array, x: Float64Array, v: Float64Array
) -> tuple[Float64Array, Float64Array, Float64Array]:
    """Times (m,), positions and velocities (m, d) of the last piece, without its begin."""
    distance, speed = float(np.linalg.norm(x[-1])), float(np.linalg.norm(v[-1]))
    if distance == 0.0:
        return np.full(1, 1e-6), np.zeros((1, x.shape[1])), np.zeros((1, x.shape[1]))
    long = min(_SLOWING * distance / max(speed, 1e-12), _LONGEST_END)
    bend = np.zeros(x.shape[1])
    if len(times) > 1:
        bend = (v[-1] - v[-2]) / (times[-1] - times[-2])
        bend *= min(1.0, speed / long / max(float(np.linalg.norm(bend)), 1e-12))
    rest = np.zeros(x.shape[1])
    piece = BPoly.from_derivatives([0.0, long], [[x[-1], v[-1], bend], [rest, rest, rest]])
    inside = np.linspace(0.0, long, 9)[1:]
    positions = np.asarray(piece(inside))
    positions[-1] = 0.0
    return inside, positions, np.asarray(piece.derivative()(inside))

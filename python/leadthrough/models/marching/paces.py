"""The speed that demonstrations teach at a place."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.models import phase
from leadthrough.models.marching.experience import Experience
from leadthrough.preprocess.resample import arc_length

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

_NEIGHBOURS = 8
_STEP = 5  # every fifth of the samples of a demonstration's progress
# People start and end at rest; a tool that only knows where it is has to leave that place.
_LEAST = 0.1  # of the mean speed


class Paces:
    """Speeds along demonstrations, looked up by place."""

    def __init__(self, known: Sequence[Experience]) -> None:
        places, speeds = zip(*(_along(each) for each in known), strict=True)
        self.mean = float(np.mean([each.length / each.duration for each in known]))
        self._places = np.concatenate(places)
        self._speeds = np.maximum(np.concatenate(speeds), _LEAST * self.mean)
        self._count = min(_NEIGHBOURS, len(self._places))

    def at(self, point: Float64Array, *, blur: float) -> float:
        """The speed at a point (d,), in its unit per second."""
        distances, nearest = self._tree.query(point, self._count)
        weights = 1.0 / (np.atleast_1d(distances) + blur)
        return float(weights @ self._speeds[np.atleast_1d(nearest)] / weights.sum())

    @cached_property
    def _tree(self) -> cKDTree:
        from scipy.spatial import cKDTree

        return cKDTree(self._places)


def _along(known: Experience) -> tuple[Float64Array, Float64Array]:
    """Places (n, d) along a demonstration and the speeds (n,) there."""
    covered = arc_length(known.way)
    wanted = known.progress[::_STEP] * covered[-1]
    places = np.column_stack([np.interp(wanted, covered, x) for x in known.way.T])
    rate = phase.speed_of(known.progress)[::_STEP] * (phase.SAMPLES - 1) / known.duration
    return places, rate * covered[-1]

"""Aligned demonstrations of one mode, and the motions that they predict."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, dataclass
from functools import cached_property
from typing import Any, Generic

import numpy as np

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.models import phase
from leadthrough.models.aligned.fading import Option, Predictor
from leadthrough.models.archive import Arrays
from leadthrough.models.coordinates import NODES, Coordinates, coordinates_of
from leadthrough.models.curves import (
    Curves,
    arc_phases,
    by_arc,
    clocks_of,
    columns_of,
    elastic,
    even_phases,
    piece_count,
    scale_of,
    smoothed,
)
from leadthrough.models.queries import CheckedQuery, even_times
from leadthrough.motion import MotionT, MotionT_co, lerp
from leadthrough.planning import detours

_TURN = 2.0 * np.pi


@dataclass(frozen=True, eq=False)
class Mode(check.Frozen, Generic[MotionT_co]):
    """Aligned demonstrations of one mode.

    Attributes:
        coordinates: meaning of the columns; orientations are rotation vectors from one reference.
        scale: lengths and angles (width,) by which columns are divided.
        predictor: the demonstrations, in these columns.
        options: the options that are averaged.
        pieces: number of cubic pieces of a motion; 0 where none hold the demonstrations.
    """

    coordinates: Coordinates[MotionT_co]
    scale: Float64Array
    predictor: Predictor
    options: tuple[Option, ...]
    pieces: int

    @cached_property
    def ends(self) -> Float64Array:
        """Starts and goals (k, 2, width) of the demonstrations, scaled."""
        rows = self.predictor.phased[0].rows
        return check.frozen(rows[:, [0, -1]], "ends", shape=("k", 2, "width"))

    def asked(self, query: CheckedQuery) -> Float64Array:
        """Start and goal (2, width) of a query, scaled; by default the demonstrations' mean."""
        wanted = self.ends.mean(axis=0) * self.scale
        for row, (value, name) in enumerate(((query.start, "start"), (query.goal, "goal"))):
            if value is not None:
                given = self.coordinates.target(value, name, float(row))
                if self.coordinates.kind == "poses" and len(given) > 3:
                    given[3:] = _continued(given[3:], wanted[row, 3:])
                wanted[row, : len(given)] = given
        return np.asarray(wanted / self.scale)

    def distance(self, query: CheckedQuery) -> float:
        """Of the query's ends from those of the nearest demonstration, scaled."""
        apart = np.linalg.norm(self.ends - self.asked(query), axis=2)
        asked = [query.start is not None, query.goal is not None]
        return float(apart[:, asked].sum(axis=1).min())

    @cached_property
    def _nominal(self) -> Float64Array:
        """The path (n, width) between the demonstrations' mean ends, scaled."""
        rows, *_ = self.predictor.predicted(self.options, self.ends.mean(axis=0))
        return smoothed(rows, self.pieces)

    def _predicted(self, query: CheckedQuery) -> tuple[Float64Array, Float64Array, Float64Array]:
        """As by `Predictor.predicted`, no part of the path moved much farther than the ends."""
        rows, phases, clock = self.predictor.predicted(self.options, self.asked(query))
        rows = self.predictor.similar(smoothed(rows, self.pieces), self._nominal)
        return self.predictor.near(rows, self._nominal), phases, clock

    def is_free(self, query: CheckedQuery) -> bool:
        """Whether its path keeps out of the query's obstacles as it is."""
        if not query.obstacles:
            return True
        rows, *_ = self._predicted(query)
        size = self.coordinates.size
        return detours.is_free(rows[:, :size] * self.scale[:size], query.obstacles)

    def motion(self, query: CheckedQuery) -> MotionT_co:
        """The motion that answers a query."""
        from scipy.interpolate import CubicSpline

        rows, phases, clock = self._predicted(query)
        rows, even = rows * self.scale, even_phases(len(rows))
        if query.obstacles:
            rows, phases, clock = self._around(query, rows, phases, clock)
            even = even_phases(len(rows))
        times = even_times(query.end(float(clock[-1])), query.dt)
        at = np.linspace(0.0, clock[-1], phase.SAMPLES)
        rising = np.concatenate([[True], np.diff(clock) > 0.0])
        progress = phase.smoothed(np.interp(at, clock[rising], even[rising]))
        covered = np.interp(times / times[-1], even_phases(len(progress)), progress)
        columns = CubicSpline(even, rows)(covered)
        return self.coordinates.motion(times, np.interp(covered, even, phases), columns)

    def _around(
        self, query: CheckedQuery, rows: Float64Array, phases: Float64Array, clock: Float64Array
    ) -> tuple[Float64Array, Float64Array, Float64Array]:
        """Rows, phases and times that keep clear of obstacles, slower as the path gets longer."""
        size, even = self.coordinates.size, even_phases(len(rows))
        found = detours.around(rows[:, :size], query.obstacles, self.pieces or len(rows))
        if found is None:
            return rows, phases, clock
        points, fractions, longer = found
        made = lerp(fractions, even, np.column_stack([rows, phases, clock]))
        made[:, :size] = points
        made = lerp(even_phases(len(points)), arc_phases(points), made)
        return made[:, :-2], made[:, -2], longer * made[:, -1]

    def arrays(self) -> Arrays:
        """Its arrays by name, for a file."""
        arc, aligned = self.predictor.phased
        return {
            "scale": self.scale,
            "options": np.array([astuple(each) for each in self.options]),
            "pieces": np.array(self.pieces),
            "rows": np.stack([arc.rows, aligned.rows]),
            "clocks": np.stack([arc.times, aligned.times]),
            **self.coordinates.arrays(),
        }


def restored(settings: dict[str, Any], arrays: Arrays) -> Mode:
    """The mode that `Coordinates.settings` and `Mode.arrays` took apart."""
    coordinates = Coordinates.from_archive(settings, arrays)
    rows = check.frozen(arrays["rows"], "rows", shape=(2, "k", "n", coordinates.width))
    clocks = check.frozen(arrays["clocks"], "clocks", shape=rows.shape[:3])
    options = check.with_gaps(arrays["options"], "options", shape=("m", 4))
    phased = Curves(rows[0], clocks[0]), Curves(rows[1], clocks[1])
    return Mode(
        coordinates,
        check.frozen(arrays["scale"], "scale", shape=(coordinates.width,)),
        Predictor(phased, coordinates.size, coordinates.kind != "joints"),
        tuple(Option.of_row(row) for row in options),
        check.integer(int(arrays["pieces"]), "pieces", at_least=0),
    )


def learned(motions: Sequence[MotionT]) -> Mode[MotionT]:
    """The mode of demonstrations alike."""
    columns, reference = columns_of(motions)
    scale = scale_of(columns, motions[0].positions.shape[1])
    clocks = clocks_of(motions)
    curves = by_arc([each / scale for each in columns], clocks)
    aligned = elastic(curves)
    even = even_phases(aligned.rows.shape[1])
    phases = [np.interp(own, at, even) for own, at in zip(clocks, aligned.times, strict=True)]
    coordinates = coordinates_of(
        motions, phases, middle=lambda _: np.repeat(reference, len(NODES), 0)
    )
    predictor = Predictor((curves, aligned), coordinates.size, coordinates.kind != "joints")
    options = predictor.chosen()
    return Mode(
        coordinates,
        check.frozen(scale, "scale", shape=("n",)),
        predictor,
        tuple(options),
        piece_count(curves.rows),
    )


def _continued(vector: Float64Array, near: Float64Array) -> Float64Array:
    """The rotation vector (3,) of the same rotation that lies nearest to another."""
    angle = float(np.linalg.norm(vector))
    if angle == 0.0:
        return vector
    axis = vector / angle
    turns = np.round((float(axis @ near) - angle) / _TURN)
    return np.asarray(axis * (angle + _TURN * turns))

"""The mean of aligned demonstrations, carried to a new start and goal as they show it.

Alignment takes the timing out of the shapes; each of several demonstrated modes is learned apart.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.models import modes
from leadthrough.models.aligned.predictor import Option, Predictor
from leadthrough.models.archive import Arrays, FittedSkill
from leadthrough.models.coordinates import NODES, Coordinates, coordinates_of
from leadthrough.models.curves import (
    MAX_ROWS,
    PROGRESS_SAMPLES,
    Curves,
    arc_phases,
    by_arc,
    columns_of,
    elastic,
    even_phases,
    piece_count,
    scale_of,
    smoothed,
    smoothed_progress,
)
from leadthrough.models.protocol import Demonstrations, Outliers, Unfitted
from leadthrough.models.queries import CheckedQuery, even_times
from leadthrough.motion import MotionT, MotionT_co, lerp
from leadthrough.planning import detours

_TURN = 2.0 * np.pi
_ROUNDING = 1e-9


@dataclass(frozen=True)
class AlignedMean(Unfitted):
    """The mean of elastically aligned demonstrations of points, joints or poses.

    How offsets of a new start and goal fade along the motion is learned from the demonstrations'
    own offsets, by predicting each of them from the others; so is which of them count for a query.
    It has no settings.
    """

    def fit(
        self, demonstrations: Demonstrations[MotionT], *, outliers: Outliers = "refuse"
    ) -> AlignedMeanSkill[MotionT]:
        """A skill from demonstrations.

        Args:
            demonstrations: one or more demonstrations, or motions: all of points, all of the same
                joints or all of poses. Several modes are told apart, each with its own mean.
            outliers: treatment of one that contradicts all others: "refuse", "drop" or "keep", as
                for `learn`.

        Raises:
            FitError: if there is none, one does not move or contradicts all others, or the last
                orientations of those of one mode have no mean.
        """
        return modes.learned_by_mode(
            lambda own: _learned(self, own), demonstrations, outliers, 10 * modes.MAX_ROWS
        )


@dataclass(frozen=True, eq=False)
class AlignedMeanSkill(FittedSkill[MotionT_co]):
    """Aligned demonstrations of a mode, and of the others; made by `AlignedMean.fit`.

    `generate` takes the mode whose demonstrations start and end nearest to the query.

    Attributes:
        model: the settings that it was fitted with.
        coordinates: meaning of the columns; orientations are rotation vectors from one reference.
        scale: lengths and angles (width,) by which columns are divided.
        predictor: the aligned demonstrations, in these columns.
        shares: options of the predictor and their shares in the mean.
        pieces: number of cubic pieces of a motion; 0 where none hold the demonstrations.
    """

    model: AlignedMean
    coordinates: Coordinates[MotionT_co]
    scale: Float64Array
    predictor: Predictor
    shares: dict[Option, float]
    pieces: int

    kind: ClassVar[str] = "aligned_mean"

    @property
    def supports(self) -> frozenset[str]:
        """Parts of a query that it honours; joints have no place among obstacles."""
        places = {"obstacles"} if self.coordinates.kind != "joints" else set()
        return frozenset({"start", "goal", "duration"} | places)

    @property
    def duration(self) -> float:
        """Mean duration of the demonstrations, s."""
        return float(self.predictor.phased[0].times[:, -1].mean())

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

    def _distance(self, query: CheckedQuery) -> float:
        """Of the query's ends from those of the nearest demonstration, scaled."""
        apart = np.linalg.norm(self.ends - self.asked(query), axis=2)
        asked = [query.start is not None, query.goal is not None]
        return float(apart[:, asked].sum(axis=1).min())

    @cached_property
    def _nominal(self) -> Float64Array:
        """The path (n, width) between the demonstrations' mean ends, scaled."""
        rows, *_ = self.predictor.predicted(self.shares, self.ends.mean(axis=0))
        return smoothed(rows, self.pieces)

    def _predicted(self, query: CheckedQuery) -> tuple[Float64Array, Float64Array, Float64Array]:
        """As by `Predictor.predicted`, no part of the path moved much farther than the ends."""
        rows, phases, clock = self.predictor.predicted(self.shares, self.asked(query))
        rows = self.predictor.similar(smoothed(rows, self.pieces), self._nominal)
        return self.predictor.near(rows, self._nominal), phases, clock

    def _is_free(self, query: CheckedQuery) -> bool:
        """Whether its path keeps out of the query's obstacles as it is."""
        if not query.obstacles:
            return True
        rows, *_ = self._predicted(query)
        size = self.coordinates.size
        return detours.is_free(rows[:, :size] * self.scale[:size], query.obstacles)

    def _answer(self, query: CheckedQuery) -> MotionT_co:
        from scipy.interpolate import CubicSpline

        rows, phases, clock = self._predicted(query)
        rows, even = rows * self.scale, even_phases(len(rows))
        if query.obstacles:
            rows, phases, clock = self._around(query, rows, phases, clock)
            even = even_phases(len(rows))
        times = even_times(query.end(float(clock[-1])), query.dt)
        at = np.linspace(0.0, clock[-1], max(PROGRESS_SAMPLES, len(rows)))
        rising = np.concatenate([[True], np.diff(clock) > 0.0])
        progress = smoothed_progress(np.interp(at, clock[rising], even[rising]))
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

    def to_archive(self) -> tuple[dict[str, Any], Arrays]:
        arc, aligned = self.predictor.phased
        arrays = {
            "scale": self.scale,
            "options": np.array([(*astuple(each), x) for each, x in self.shares.items()]),
            "pieces": np.array(self.pieces),
            "rows": np.stack([arc.rows, aligned.rows]),
            "clocks": np.stack([arc.times, aligned.times]),
            **self.coordinates.arrays(),
        }
        return self.coordinates.settings(), arrays


def _learned(model: AlignedMean, motions: Sequence[MotionT]) -> AlignedMeanSkill[MotionT]:
    columns, reference = columns_of(motions)
    scale = scale_of(columns, motions[0].positions.shape[1])
    clocks = [each.times - each.times[0] for each in motions]
    curves = by_arc([each / scale for each in columns], clocks)
    aligned = elastic(curves)
    if curves.rows.shape[1] > MAX_ROWS:  # along minutes, tremor makes lengths of arcs differ
        curves = aligned
    even = even_phases(aligned.rows.shape[1])
    phases = [np.interp(own, at, even) for own, at in zip(clocks, aligned.times, strict=True)]
    coordinates = coordinates_of(
        motions, phases, middle=lambda _: np.repeat(reference, len(NODES), 0)
    )
    predictor = Predictor((curves, aligned), coordinates.size, coordinates.kind != "joints")
    return AlignedMeanSkill(
        model,
        coordinates,
        check.frozen(scale, "scale", shape=("n",)),
        predictor,
        predictor.chosen(),
        piece_count(curves.rows),
    )


def from_archive(settings: dict[str, Any], arrays: Arrays) -> AlignedMeanSkill:
    coordinates = Coordinates.from_archive(settings, arrays)
    rows = check.frozen(arrays["rows"], "rows", shape=(2, "k", "n", coordinates.width))
    clocks = check.frozen(arrays["clocks"], "clocks", shape=rows.shape[:3])
    options = check.with_gaps(arrays["options"], "options", shape=("m", "n"))
    if options.shape[1] == 4:  # of equal shares, as earlier versions wrote them
        options = np.insert(options, 4, 1.0 / max(len(options), 1), axis=1)
    if options.shape[1] == 5:  # without combinations
        options = np.insert(options, 4, 0.0, axis=1)
    options = check.with_gaps(options, "options", shape=("m", 6))
    shares = options[:, 5]
    if not ((shares > 0.0).all() and abs(shares.sum() - 1.0) < _ROUNDING):
        raise check.refused("options", "shares > 0 whose sum is 1", shares)
    phased = Curves(rows[0], clocks[0]), Curves(rows[1], clocks[1])
    return AlignedMeanSkill(
        AlignedMean(),
        coordinates,
        check.frozen(arrays["scale"], "scale", shape=(coordinates.width,)),
        Predictor(phased, coordinates.size, coordinates.kind != "joints"),
        {
            Option(int(phase), float(width), float(prior), float(rotated), bool(combined)): float(x)
            for phase, width, prior, rotated, combined, x in options
        },
        check.integer(int(arrays["pieces"]), "pieces", at_least=0),
    )


def _continued(vector: Float64Array, near: Float64Array) -> Float64Array:
    """The rotation vector (3,) of the same rotation that lies nearest to another."""
    angle = float(np.linalg.norm(vector))
    if angle == 0.0:
        return vector
    axis = vector / angle
    turns = np.round((float(axis @ near) - angle) / _TURN)
    return np.asarray(axis * (angle + _TURN * turns))

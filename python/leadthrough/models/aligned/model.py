"""The mean of aligned demonstrations, carried to a new start and goal as they show it.

Alignment takes the timing out of the shapes; each of several demonstrated ways is learned apart.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, dataclass
from functools import cached_property
from typing import Any, ClassVar, Generic

import numpy as np

from leadthrough import check, rotations
from leadthrough.check import Float64Array
from leadthrough.models import phase
from leadthrough.models.aligned.curves import Curves, by_arc, elastic, even_phases, ways
from leadthrough.models.aligned.fading import Option, Predictor
from leadthrough.models.archive import Arrays, FittedSkill
from leadthrough.models.coordinates import NODES, Coordinates, coordinates_of
from leadthrough.models.demonstrations import Demonstrations, motions_of
from leadthrough.models.mean_orientation import mean_orientations
from leadthrough.models.protocol import Unfitted
from leadthrough.models.queries import CheckedQuery, even_times
from leadthrough.motion import Motion, MotionT, MotionT_co, PoseTrajectory

# Weight of the orientations' extent against the positions'; smaller turns than the least are noise.
_TURNING, _MIN_TURN = 0.3, 0.1  # , rad
_TURN = 2.0 * np.pi


@dataclass(frozen=True)
class AlignedMean(Unfitted):
    """The mean of elastically aligned demonstrations of points, joints or poses.

    How offsets of a new start and goal fade along the motion is learned from the demonstrations'
    own offsets, by predicting each of them from the others; so is which of them count for a query.
    It has no settings.
    """

    def fit(self, demonstrations: Demonstrations[MotionT]) -> AlignedMeanSkill[MotionT]:
        """A skill from demonstrations.

        Args:
            demonstrations: one or more demonstrations, or motions: all of points, all of the same
                joints or all of poses. Several ways are told apart, each with its own mean.

        Raises:
            FitError: if there is none, one does not move, or the last orientations of those of one
                way have no mean.
        """
        motions = motions_of(demonstrations)
        numbers = ways(by_arc(_features(motions), _clocks(motions)).rows)
        groups = [np.flatnonzero(numbers == number) for number in range(numbers.max() + 1)]
        return AlignedMeanSkill(
            self, tuple(_learned([motions[i] for i in group]) for group in groups)
        )


@dataclass(frozen=True, eq=False)
class Way(Generic[MotionT_co]):
    """Aligned demonstrations that go one way.

    Attributes:
        coordinates: meaning of the columns; orientations are rotation vectors from one reference.
        scale: lengths and angles (width,) by which columns are divided.
        predictor: the demonstrations, in these columns.
        options: the options that are averaged.
    """

    coordinates: Coordinates[MotionT_co]
    scale: Float64Array
    predictor: Predictor
    options: tuple[Option, ...]

    @cached_property
    def ends(self) -> Float64Array:
        """Starts and goals (k, 2, width) of the demonstrations, scaled."""
        return self.predictor.phased[0].rows[:, [0, -1]]

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

    def motion(self, query: CheckedQuery) -> MotionT_co:
        """The motion that answers a query."""
        from scipy.interpolate import CubicSpline

        rows, phases, clock = self.predictor.predicted(self.options, self.asked(query))
        even = even_phases(len(rows))
        times = even_times(query.end(float(clock[-1])), query.dt)
        at = np.linspace(0.0, clock[-1], phase.SAMPLES)
        rising = np.concatenate([[True], np.diff(clock) > 0.0])
        progress = phase.smoothed(np.interp(at, clock[rising], even[rising]))
        covered = np.interp(times / times[-1], even_phases(len(progress)), progress)
        columns = CubicSpline(even, rows * self.scale)(covered)
        return self.coordinates.motion(times, np.interp(covered, even, phases), columns)


@dataclass(frozen=True, eq=False)
class AlignedMeanSkill(FittedSkill[MotionT_co]):
    """The demonstrated ways, each as aligned demonstrations; made by `AlignedMean.fit`.

    `generate` takes the way whose demonstrations start and end nearest to the query. Motions start
    and end at rest.

    Attributes:
        model: the settings that it was fitted with.
        ways: the ways; the one with the most demonstrations answers queries without ends.
    """

    model: AlignedMean
    ways: tuple[Way[MotionT_co], ...]

    kind: ClassVar[str] = "aligned_mean"
    supports: ClassVar[frozenset[str]] = frozenset({"start", "goal", "duration"})

    @property
    def coordinates(self) -> Coordinates[MotionT_co]:
        """Coordinates of the most demonstrated way."""
        return self._most_demonstrated.coordinates

    @property
    def duration(self) -> float:
        """Mean duration of the most demonstrated way, s."""
        return float(self._most_demonstrated.predictor.phased[0].times[:, -1].mean())

    @property
    def _most_demonstrated(self) -> Way[MotionT_co]:
        return max(self.ways, key=lambda way: len(way.ends))

    def _answer(self, query: CheckedQuery) -> MotionT_co:
        if query.start is None and query.goal is None:
            return self._most_demonstrated.motion(query)
        return min(self.ways, key=lambda way: way.distance(query)).motion(query)

    def to_archive(self) -> tuple[dict[str, Any], Arrays]:
        arrays: dict[str, Float64Array] = {}
        for i, way in enumerate(self.ways):
            arc, aligned = way.predictor.phased
            own = {
                "scale": way.scale,
                "options": np.array([astuple(each) for each in way.options]),
                "rows": np.stack([arc.rows, aligned.rows]),
                "clocks": np.stack([arc.times, aligned.times]),
                **way.coordinates.arrays(),
            }
            arrays |= {f"{name}_{i}": array for name, array in own.items()}
        return {"ways": [way.coordinates.settings() for way in self.ways]}, arrays


def from_archive(settings: dict[str, Any], arrays: Arrays) -> AlignedMeanSkill:
    """The skill from the settings and arrays that `AlignedMeanSkill.to_archive` returned."""
    ways_ = []
    for i, own in enumerate(settings["ways"]):
        part = {
            name.removesuffix(f"_{i}"): array
            for name, array in arrays.items()
            if name.endswith(f"_{i}")
        }
        ways_.append(_restored(own, part))
    return AlignedMeanSkill(AlignedMean(), tuple(ways_))


def _restored(settings: dict[str, Any], arrays: Arrays) -> Way:
    coordinates = Coordinates.from_archive(settings, arrays)
    rows = check.frozen(arrays["rows"], "rows", shape=(2, "k", "n", coordinates.width))
    clocks = check.frozen(arrays["clocks"], "clocks", shape=rows.shape[:3])
    options = check.with_gaps(arrays["options"], "options", shape=("m", 4))
    phased = Curves(rows[0], clocks[0]), Curves(rows[1], clocks[1])
    return Way(
        coordinates,
        check.frozen(arrays["scale"], "scale", shape=(coordinates.width,)),
        Predictor(phased, coordinates.size, coordinates.kind != "joints"),
        tuple(Option.of_row(row) for row in options),
    )


def _learned(motions: Sequence[MotionT]) -> Way[MotionT]:
    """Demonstrations of one way."""
    columns = [each.positions for each in motions]
    poses = [each for each in motions if isinstance(each, PoseTrajectory)]
    reference = None
    if poses:
        reference = mean_orientations([each.orientations[-1:] for each in poses])
        columns = [np.hstack([each.positions, _lifted(each, reference)]) for each in poses]
    scale = _scale(columns, motions[0].positions.shape[1])
    clocks = _clocks(motions)
    curves = by_arc([each / scale for each in columns], clocks)
    aligned = elastic(curves)
    even = even_phases(aligned.rows.shape[1])
    phases = [np.interp(own, at, even) for own, at in zip(clocks, aligned.times, strict=True)]
    coordinates = coordinates_of(
        motions, phases, middle=lambda _: np.repeat(reference, len(NODES), 0)
    )
    predictor = Predictor((curves, aligned), coordinates.size, coordinates.kind != "joints")
    options = predictor.chosen()
    return Way(coordinates, scale, predictor, tuple(options))


def _clocks(motions: Sequence[Motion]) -> list[Float64Array]:
    return [each.times - each.times[0] for each in motions]


def _lifted(motion: PoseTrajectory, reference: Float64Array) -> Float64Array:
    """Rotation vectors (n, 3) from a reference (1, 4), continuous, the last at most pi long."""
    back = rotations.inverse(np.repeat(reference, len(motion.times), 0))
    return rotations.lift(rotations.compose(back, motion.orientations), anchor="goal")


def _continued(vector: Float64Array, near: Float64Array) -> Float64Array:
    """The rotation vector (3,) of the same rotation that lies nearest to another."""
    angle = float(np.linalg.norm(vector))
    if angle == 0.0:
        return vector
    axis = vector / angle
    turns = np.round((float(axis @ near) - angle) / _TURN)
    return np.asarray(axis * (angle + _TURN * turns))


def _scale(columns: Sequence[Float64Array], size: int) -> Float64Array:
    """The extent (width,) of positions, and that of orientations for their weight."""
    width = columns[0].shape[1]
    extent = [np.mean([_extent(each[:, :size]) for each in columns])]
    if width > size:
        turn = np.mean([_extent(each[:, size:]) for each in columns])
        extent.append(max(float(turn), _MIN_TURN) / _TURNING)
    scale = np.repeat([each or 1.0 for each in extent], [size, width - size][: len(extent)])
    return np.asarray(scale, dtype=np.float64)


def _extent(rows: Float64Array) -> float:
    return float(np.linalg.norm(np.ptp(rows, axis=0)))


def _features(motions: Sequence[Motion]) -> list[Float64Array]:
    """Rows to tell ways apart, of positions and of rotation matrices, which need no reference."""
    columns = [
        np.hstack([each.positions, rotations.to_matrix(each.orientations).reshape(-1, 9)])
        if isinstance(each, PoseTrajectory)
        else each.positions
        for each in motions
    ]
    scale = _scale(columns, motions[0].positions.shape[1])
    return [each / scale for each in columns]

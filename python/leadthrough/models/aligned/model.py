"""The mean of aligned demonstrations, carried to a new start and goal as they show it.

Alignment takes the timing out of the shapes; each of several demonstrated ways is learned apart.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.models.aligned.columns import clocks_of, features_of
from leadthrough.models.aligned.curves import by_arc, ways
from leadthrough.models.aligned.way import Way, learned, restored
from leadthrough.models.archive import Arrays, FittedSkill
from leadthrough.models.coordinates import Coordinates
from leadthrough.models.demonstrations import Demonstrations, motions_of
from leadthrough.models.protocol import Unfitted
from leadthrough.models.queries import CheckedQuery
from leadthrough.motion import MotionT, MotionT_co


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
        numbers = ways(by_arc(features_of(motions), clocks_of(motions)).rows)
        groups = [np.flatnonzero(numbers == number) for number in range(numbers.max() + 1)]
        return AlignedMeanSkill(
            self, tuple(learned([motions[i] for i in group]) for group in groups)
        )


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

    @property
    def supports(self) -> frozenset[str]:
        """Parts of a query that it honours; joints have no place among obstacles."""
        places = {"obstacles"} if self.coordinates.kind != "joints" else set()
        return frozenset({"start", "goal", "duration"} | places)

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
            arrays |= {f"{name}_{i}": array for name, array in way.arrays().items()}
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
        ways_.append(restored(own, part))
    return AlignedMeanSkill(AlignedMean(), tuple(ways_))

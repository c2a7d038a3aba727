"""The mean of aligned demonstrations, carried to a new start and goal as they show it.

Alignment takes the timing out of the shapes; each of several demonstrated modes is learned apart.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from leadthrough.models.aligned.mode import Mode, learned, restored
from leadthrough.models.archive import Arrays, FittedSkill
from leadthrough.models.coordinates import Coordinates
from leadthrough.models.modes import MAX_ROWS, learned_by_mode
from leadthrough.models.protocol import Demonstrations, Outliers, Unfitted, motions_of
from leadthrough.models.queries import CheckedQuery
from leadthrough.motion import MotionT, MotionT_co


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
        return learned_by_mode(
            lambda own: AlignedMeanSkill(self, learned(own)),
            motions_of(demonstrations, outliers=outliers),
            10 * MAX_ROWS,
        )


@dataclass(frozen=True, eq=False)
class AlignedMeanSkill(FittedSkill[MotionT_co]):
    """Aligned demonstrations of a mode, and of the others; made by `AlignedMean.fit`.

    `generate` takes the mode whose demonstrations start and end nearest to the query.

    Attributes:
        model: the settings that it was fitted with.
        mode: the aligned demonstrations.
    """

    model: AlignedMean
    mode: Mode[MotionT_co]

    kind: ClassVar[str] = "aligned_mean"

    @property
    def supports(self) -> frozenset[str]:
        """Parts of a query that it honours; joints have no place among obstacles."""
        places = {"obstacles"} if self.coordinates.kind != "joints" else set()
        return frozenset({"start", "goal", "duration"} | places)

    @property
    def coordinates(self) -> Coordinates[MotionT_co]:
        """Coordinates of its columns."""
        return self.mode.coordinates

    @property
    def duration(self) -> float:
        """Mean duration of the demonstrations, s."""
        return float(self.mode.predictor.phased[0].times[:, -1].mean())

    def _answer(self, query: CheckedQuery) -> MotionT_co:
        return self.mode.motion(query)

    def _distance(self, query: CheckedQuery) -> float:
        return self.mode.distance(query)

    def _is_free(self, query: CheckedQuery) -> bool:
        return self.mode.is_free(query)

    def to_archive(self) -> tuple[dict[str, Any], Arrays]:
        return self.coordinates.settings(), self.mode.arrays()


def from_archive(settings: dict[str, Any], arrays: Arrays) -> AlignedMeanSkill:
    """The skill from the settings and arrays that `AlignedMeanSkill.to_archive` returned."""
    return AlignedMeanSkill(AlignedMean(), restored(settings, arrays))

"""The mean of aligned demonstrations, carried to a new start and goal as they show it.

Alignment takes the timing out of the shapes; each of several demonstrated modes is learned apart.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.models.aligned.mode import Mode, learned, restored
from leadthrough.models.archive import Arrays, FittedSkill
from leadthrough.models.coordinates import Coordinates
from leadthrough.models.protocol import Demonstrations, Outliers, Unfitted, motions_of
from leadthrough.models.queries import CheckedQuery, checked_query
from leadthrough.motion import MotionT, MotionT_co, Target
from leadthrough.shapes import Shape


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
        return AlignedMeanSkill(self, learned(motions_of(demonstrations, outliers=outliers)))


@dataclass(frozen=True, eq=False)
class AlignedMeanSkill(FittedSkill[MotionT_co]):
    """The demonstrated modes, each as aligned demonstrations; made by `AlignedMean.fit`.

    `generate` takes the mode whose demonstrations start and end nearest to the query.

    Attributes:
        model: the settings that it was fitted with.
        modes: the modes; the one with the most demonstrations answers queries without ends.
    """

    model: AlignedMean
    modes: tuple[Mode[MotionT_co], ...]

    kind: ClassVar[str] = "aligned_mean"

    @property
    def supports(self) -> frozenset[str]:
        """Parts of a query that it honours; joints have no place among obstacles."""
        places = {"obstacles"} if self.coordinates.kind != "joints" else set()
        return frozenset({"start", "goal", "duration"} | places)

    @property
    def coordinates(self) -> Coordinates[MotionT_co]:
        """Coordinates of the most demonstrated mode."""
        return self._most_demonstrated.coordinates

    @property
    def duration(self) -> float:
        """Mean duration of the most demonstrated mode, s."""
        return float(self._most_demonstrated.predictor.phased[0].times[:, -1].mean())

    @property
    def _most_demonstrated(self) -> Mode[MotionT_co]:
        return max(self.modes, key=lambda mode: len(mode.ends))

    @checked_query
    def generate(
        self,
        *,
        start: Target | None = None,
        goal: Target | None = None,
        duration: float | None = None,
        dt: float = 0.01,
        obstacles: Sequence[Shape] = (),
        mode: int | None = None,
    ) -> MotionT_co:
        """A motion of the demonstrated type; parts that are left out are as demonstrated.

        Args:
            start: point or joints (d,); of poses a position (3,), or (position (3,), orientation
                (4,) as w, x, y, z).
            goal: likewise, at the end.
            duration: s, > 0.
            dt: s, > 0, upper bound of the sampling step.
            obstacles: shapes to keep clear of; not of joints.
            mode: index in `modes`; by default the one whose demonstrations start and end nearest,
                or with obstacles the nearest one that is free of them, if there is any.

        Raises:
            UnsupportedQuery: for a part that is not among `supports`.
            NoPath: if obstacles leave no path.
        """
        query = CheckedQuery(start, goal, duration, dt, obstacles)
        self.refuse_obstacles(query)
        if mode is not None:
            last = len(self.modes) - 1
            return self.modes[check.integer(mode, "mode", at_least=0, at_most=last)].motion(query)
        return self._answer(query)

    def _answer(self, query: CheckedQuery) -> MotionT_co:
        ranked = sorted(self.modes, key=lambda mode: mode.distance(query))
        free = (mode for mode in ranked if mode.is_free(query))
        return next(free, ranked[0]).motion(query)

    def to_archive(self) -> tuple[dict[str, Any], Arrays]:
        arrays: dict[str, Float64Array] = {}
        for i, mode in enumerate(self.modes):
            arrays |= {f"{name}_{i}": array for name, array in mode.arrays().items()}
        return {"modes": [mode.coordinates.settings() for mode in self.modes]}, arrays


def from_archive(settings: dict[str, Any], arrays: Arrays) -> AlignedMeanSkill:
    """The skill from the settings and arrays that `AlignedMeanSkill.to_archive` returned."""
    restored_modes = []
    for i, own in enumerate(settings["modes"]):
        part = {
            name.removesuffix(f"_{i}"): array
            for name, array in arrays.items()
            if name.endswith(f"_{i}")
        }
        restored_modes.append(restored(own, part))
    return AlignedMeanSkill(AlignedMean(), tuple(restored_modes))

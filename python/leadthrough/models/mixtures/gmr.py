"""Motions by Gaussian mixture regression over time.

Source: Calinon, Guenter and Billard 2007, "On learning, representing, and generalizing a task in a
humanoid robot".
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.blas_threads import one_blas_thread
from leadthrough.check import Float64Array, InvalidInput, UnsupportedQuery
from leadthrough.models import archive
from leadthrough.models.archive import Arrays, FittedSkill
from leadthrough.models.coordinates import Coordinates
from leadthrough.models.gaussians.mixture import Mixture
from leadthrough.models.mixtures import phases as phase_mixtures
from leadthrough.models.mixtures.phases import MAX_COMPONENTS, SAMPLES, adapted, timed_columns
from leadthrough.models.modes import common_phases, learned_by_mode
from leadthrough.models.protocol import Demonstrations, Outliers, Unfitted, motions_of
from leadthrough.models.queries import CheckedQuery, asked_times, even_times
from leadthrough.motion import Motion, MotionT, MotionT_co, normalised_times
from leadthrough.preprocess.moved_ends import with_ends
from leadthrough.preprocess.resample import arc_length


@dataclass(frozen=True)
class GMR(Unfitted):
    """Gaussian mixture regression of points, joints or poses over time.

    Attributes:
        components: number of components, 1 to 512; None: as few, doubled from 8, as keep the mean
            within 2 % of the positions' extent from that of the demonstrations, or within 4 % if
            twice as many come hardly nearer: up to 64, and up to 512 of motions whose detail 200
            samples lose.
        seed: seed of the random number generator that draws the starts of EM, >= 0.
        starts: number of starts of EM that are followed to the end, >= 1; the most likely result
            is taken. 1 is several times faster.
    """

    components: int | None = None
    seed: int = 0
    starts: int = 5

    slider: ClassVar[tuple[str, int, int]] = ("components", 1, 20)

    def __post_init__(self) -> None:
        if self.components is not None:
            check.integer(self.components, "components", at_least=1, at_most=MAX_COMPONENTS)
        check.integer(self.seed, "seed", at_least=0)
        check.integer(self.starts, "starts", at_least=1)

    @one_blas_thread
    def fit(
        self, demonstrations: Demonstrations[MotionT], *, outliers: Outliers = "refuse"
    ) -> GMRSkill[MotionT]:
        """A skill from demonstrations, each resampled at 200 evenly spaced times, or up to 1,600.

        Args:
            demonstrations: one or more demonstrations, or motions: all of points, all of the same
                joints or all of poses.
            outliers: treatment of one that contradicts all others: "refuse", "drop" or "keep", as
                for `learn`.

        Raises:
            FitError: if there is none, one does not move or contradicts all others, or the
                orientations of poses have no mean.
        """
        return learned_by_mode(self._fitted, demonstrations, outliers)

    def _fitted(self, motions: Sequence[MotionT]) -> GMRSkill[MotionT]:
        samples = phase_mixtures.sampled(motions, least=self.components or SAMPLES)
        search = {"seed": self.seed, "starts": self.starts}
        poses = samples.coordinates.kind == "poses"
        fit = phase_mixtures.fit_phases(
            samples.points, self.components, samples=len(samples.rows[0]), poses=poses, **search
        )
        model = replace(self, components=fit.mixture.count)
        return GMRSkill(
            model,
            samples.coordinates,
            fit.mixture,
            samples.duration,
            samples.ends,
            len(samples.motions),
        )


# Any: settings are whatever JSON holds.
def from_archive(settings: dict[str, Any], arrays: archive.Arrays) -> GMRSkill:
    coordinates = Coordinates.from_archive(settings, arrays)
    mixture = Mixture(arrays["weights"], arrays["means"], arrays["covariances"])
    if mixture.size != coordinates.width + 1:
        raise InvalidInput(f"means: expected {coordinates.width + 1} columns, got {mixture.size}")
    # A file of version 0.1 has no model; its mixture tells the number of components.
    model = GMR(**settings.get("model", {"components": mixture.count}))
    ends = check.frozen(arrays["ends"], "ends", shape=(2, coordinates.width))
    duration = check.number(settings["duration"], "duration", above=0.0)
    return GMRSkill(model, coordinates, mixture, duration, ends, int(settings["shown"]))


@dataclass(frozen=True, eq=False)
class GMRSkill(FittedSkill[MotionT_co]):
    """A mixture over time and the columns of a motion; made by `GMR.fit`.

    `generate` returns its mean, moved to a start and a goal: the offsets fade along the path.

    Attributes:
        model: the settings that it was fitted with; `components` is the number that was fitted.
        coordinates: meaning of the d columns: points, joints, or for poses the
            position and a rotation vector from a reference orientation.
        mixture: mixture of 1 + d columns, the time first, s.
        duration: duration of the motion, s.
        ends: mean start and goal (2, d) of the demonstrations.
        demonstration_count: number of demonstrations that it has learned.
    """

    model: GMR
    coordinates: Coordinates[MotionT_co]
    mixture: Mixture
    duration: float
    ends: Float64Array
    demonstration_count: int

    kind: ClassVar[str] = "gmr"
    supports: ClassVar[frozenset[str]] = frozenset({"start", "goal", "duration"})

    def regress(self, times: ArrayLike) -> tuple[Float64Array, Float64Array]:
        """Mean and covariance of the columns.

        Args:
            times: times (n,) of the motion, s. Outside [0, duration] the first and last components
                are extrapolated.

        Returns:
            Mean (n, d) and covariance (n, d, d).
        """
        given = check.array(times, "times", shape=("n",))
        return self.mixture.regress(given[:, None], inputs=[0])

    def distribution(self, times: ArrayLike) -> tuple[Float64Array, Float64Array]:
        """Mean (n, d) and covariance (n, d, d) of the columns: `regress`, as other skills name it.

        Args:
            times: times (n,) of the motion, s.
        """
        return self.regress(asked_times(times, "times"))

    def _answer(self, query: CheckedQuery) -> MotionT_co:
        times = even_times(query.end(self.duration), query.dt)
        phases = normalised_times(times)
        columns, _ = self.regress(phases * self.duration)
        length = arc_length(columns[:, : self.coordinates.size])
        covered = length / length[-1] if length[-1] > 0.0 else phases
        ends = wanted_ends(self.coordinates, self.ends, query)
        columns = with_ends(columns, ends[0], ends[1], covered)
        return self.coordinates.motion(times, phases, columns)

    def updated(self, demonstrations: Demonstrations[Motion]) -> GMRSkill[MotionT_co]:
        """A skill that has learned further demonstrations; the earlier ones are not needed.

        The components are adapted; their number stays.

        Args:
            demonstrations: one or more demonstrations of the skill's type of motion.

        Raises:
            FitError: if there is none, or one does not move.
        """
        motions, before = motions_of(demonstrations), self.demonstration_count
        present = self.generate()
        own, *others = common_phases([present, *motions])
        phases = [np.interp(each, own, normalised_times(present.times)) for each in others]
        least = phase_mixtures.POINTS_A_COMPONENT * self.mixture.count
        each = phase_mixtures.samples_of(motions, phases, least)
        samples = timed_columns(motions, phases, self.coordinates, self.duration, each)
        points, count = np.concatenate(samples), before + len(motions)
        mixture = adapted(
            self.mixture,
            points,
            len(points) / len(motions) * before,
            poses=self.coordinates.kind == "poses",
        )
        ends = np.sum([each[[0, -1], 1:] for each in samples], axis=0)
        return replace(
            self,
            mixture=mixture,
            ends=(self.ends * before + ends) / count,
            demonstration_count=count,
        )

    def component_orientations(self) -> Float64Array:
        """Mean orientations (k, 4) of the components of a skill of poses, w, x, y, z.

        Raises:
            UnsupportedQuery: if the skill is not of poses.
        """
        if self.coordinates.kind != "poses":
            raise UnsupportedQuery(
                "component_orientations: expected a skill of poses, this is one of "
                f"{self.coordinates.kind}"
            )
        phases = np.clip(self.mixture.means[:, 0] / self.duration, 0.0, 1.0)
        order = np.argsort(phases, kind="stable")
        orientations = self.coordinates.orientations(self.mixture.means[order, 4:], phases[order])
        result = np.empty_like(orientations)
        result[order] = orientations
        return result

    def to_archive(self) -> tuple[dict[str, Any], Arrays]:
        settings = {
            "model": asdict(self.model),
            "duration": self.duration,
            "shown": self.demonstration_count,  # the name in files
            **self.coordinates.settings(),
        }
        arrays = {
            "weights": self.mixture.weights,
            "means": self.mixture.means,
            "covariances": self.mixture.covariances,
            "ends": self.ends,
            **self.coordinates.arrays(),
        }
        return settings, arrays


def wanted_ends(coordinates: Coordinates, ends: Float64Array, query: CheckedQuery) -> Float64Array:
    """Start and goal (2, d), where a query leaves them open those of the demonstrations."""
    wanted = ends.copy()
    for row, (place, name) in enumerate(((query.start, "start"), (query.goal, "goal"))):
        if place is not None:
            given = coordinates.target(place, name, float(row))
            wanted[row, : len(given)] = given
    return wanted

"""Motions by Gaussian mixture regression over time.

Source: Calinon, Guenter and Billard 2007, "On learning, representing, and generalizing a task in a
humanoid robot".
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from leadthrough import check
from leadthrough.blas_threads import one_blas_thread
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.models import archive
from leadthrough.models.chart import Chart
from leadthrough.models.demonstrated import Demonstrations
from leadthrough.models.gaussians.fitting import FittedMixture
from leadthrough.models.gaussians.mixture import Mixture
from leadthrough.models.mixtures.gmr_skill import GMRSkill
from leadthrough.models.mixtures.phases import choose_phases, fit_phases
from leadthrough.models.mixtures.samples import SAMPLES, sampled
from leadthrough.models.unfitted import Unfitted
from leadthrough.motion import MotionT


@dataclass(frozen=True)
class GMR(Unfitted):
    """Gaussian mixture regression of points, joints or poses over time.

    Attributes:
        components: number of components, 1 to 200; None for the number from 1 to 15 with the least
            Bayesian information criterion.
        seed: seed of the random number generator that draws the starts of EM, >= 0.
        starts: number of starts of EM that are followed to the end, >= 1; the most likely result
            is taken. 1 is several times faster.

    Raises:
        InvalidInput: if a setting is out of range.
    """

    components: int | None = 8
    seed: int = 0
    starts: int = 5

    def __post_init__(self) -> None:
        if self.components is not None:
            check.integer(self.components, "components", at_least=1, at_most=SAMPLES)
        check.integer(self.seed, "seed", at_least=0)
        check.integer(self.starts, "starts", at_least=1)

    @one_blas_thread
    def fit(self, demonstrations: Demonstrations[MotionT]) -> GMRSkill[MotionT]:
        """A skill from demonstrations, each resampled at 200 evenly spaced times.

        Args:
            demonstrations: one or more demonstrations, or motions: all of points, all of the same
                joints or all of poses.

        Raises:
            InvalidInput: if the demonstrations differ in type.
            FitError: if there is none, one does not move, or the orientations of poses have no
                mean.
        """
        shown = sampled(demonstrations)
        fit = self._fitted(shown.points, poses=shown.chart.kind == "poses")
        model = replace(self, components=fit.mixture.count)
        return GMRSkill(
            model, shown.chart, fit.mixture, shown.duration, shown.ends, len(shown.motions)
        )

    def _fitted(self, points: Float64Array, *, poses: bool) -> FittedMixture:
        """The mixture of times and columns (n, 1 + d)."""
        if self.components is None:
            return choose_phases(points, poses=poses, seed=self.seed, starts=self.starts)
        return fit_phases(points, self.components, poses=poses, seed=self.seed, starts=self.starts)


# Any: settings are whatever JSON holds.
def from_archive(settings: dict[str, Any], arrays: archive.Arrays) -> GMRSkill:
    """The skill from the settings and arrays that `GMRSkill.to_archive` returned."""
    chart = Chart.from_archive(settings, arrays)
    mixture = Mixture(arrays["weights"], arrays["means"], arrays["covariances"])
    if mixture.size != chart.width + 1:
        raise InvalidInput(f"means: expected {chart.width + 1} columns, got {mixture.size}")
    # A file of version 0.1 has no model; its mixture tells the number of components.
    model = GMR(**settings.get("model", {"components": mixture.count}))
    ends = check.frozen(arrays["ends"], "ends", shape=(2, chart.width))
    duration = check.number(settings["duration"], "duration", above=0.0)
    return GMRSkill(model, chart, mixture, duration, ends, int(settings["shown"]))

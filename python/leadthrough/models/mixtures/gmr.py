"""Motions by Gaussian mixture regression over time.

Source: Calinon, Guenter and Billard 2007, "On learning, representing, and generalizing a task in a
humanoid robot".
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from leadthrough import check
from leadthrough.models.chart import SAMPLES, chart_of, motions_of, timed_columns
from leadthrough.models.mixtures.fitting import choose_components, fit_mixture
from leadthrough.models.mixtures.gmr_skill import GMRSkill
from leadthrough.motion import Demonstration, normalised_times


@dataclass(frozen=True)
class GMR:
    """Gaussian mixture regression of points, joints or poses over time.

    components: of the mixture, >= 1; None: 1 to 15, those with the least Bayesian information
    criterion. seed: of the draws that start EM.
    """

    components: int | None = 8
    seed: int = 0

    def __post_init__(self) -> None:
        if self.components is not None:
            check.integer(self.components, "components", at_least=1, at_most=SAMPLES)
        check.integer(self.seed, "seed", at_least=0)

    def fit(self, demonstrations: Sequence[Demonstration]) -> GMRSkill:
        """A skill from demonstrations, all of points, of the same joints, or of poses.

        Each is taken at 200 even shares of its time. Raises InvalidInput; FitError for one that
        does not move.
        """
        motions = motions_of(demonstrations)
        phases = [normalised_times(motion.times) for motion in motions]
        chart = chart_of(motions, phases)
        duration = float(np.median([motion.duration for motion in motions]))
        samples = timed_columns(motions, phases, chart, duration)
        points = np.concatenate(samples)
        if self.components is None:
            fit = choose_components(points, seed=self.seed)
        else:
            fit = fit_mixture(points, self.components, seed=self.seed)
        ends = np.mean([each[[0, -1], 1:] for each in samples], axis=0)
        return GMRSkill(chart, fit.mixture, duration, ends, len(motions))

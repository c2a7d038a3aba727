"""Probabilistic movement primitives: a distribution over motions.

A motion is basis functions over its phase times weights, and the weights are normally distributed
over the demonstrations. Source: Paraschos et al. 2013, "Probabilistic movement primitives".
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import FitError, InvalidInput
from leadthrough.models.chart import chart_of, motions_of, scales
from leadthrough.models.promp.basis import KINDS, LEAST, Basis
from leadthrough.models.promp.em import expectation_maximisation
from leadthrough.models.promp.least_squares import least_squares
from leadthrough.models.promp.skill import ProMPSkill
from leadthrough.motion import Demonstration, Motion, normalised_times

ESTIMATORS = ("least_squares", "em")

# A curve fitted to less of the phase than this is free to do anything in the rest.
_LEAST_COVERED = 0.9


@dataclass(frozen=True)
class ProMP:
    """A probabilistic movement primitive of points, joints or poses.

    weights: basis functions a column, >= 4. basis: "gaussian"; "bspline"; "rhythmic", for motions
    of one period that end where they began. width: of the bells, standard deviations in spacings
    of their centres, 0.3 to 3: velocities ripple with narrow ones, from 0.6 down, and wide ones are
    hard to tell from each other. estimator: "least_squares", quick, exact at both ends
    of every demonstration; "em", which weighs noisy samples against each other and takes
    demonstrations that show only a part of the motion. regularization: of the least-squares
    curves, > 0, what a wiggle costs beside an error.
    """

    weights: int = 20
    basis: str = "gaussian"
    width: float = 1.0
    estimator: str = "least_squares"
    regularization: float = 1e-5

    def __post_init__(self) -> None:
        check.integer(self.weights, "weights", at_least=LEAST, at_most=10_000)
        check.choice(self.basis, "basis", KINDS)
        check.number(self.width, "width", at_least=0.3, at_most=3.0)
        check.choice(self.estimator, "estimator", ESTIMATORS)
        check.number(self.regularization, "regularization", above=0.0)

    def fit(
        self, demonstrations: Sequence[Demonstration], *, phases: Sequence[Any] | None = None
    ) -> ProMPSkill:
        """A skill from demonstrations, all of points, of the same joints, or of poses.

        phases: (n,) increasing in [0, 1] for each demonstration, where its samples stand in the
        motion (rhythmic: in periods); by default the share of its time. A demonstration of a part
        covers a part of [0, 1], which needs the estimator "em". Raises InvalidInput; FitError for
        a demonstration that does not move, or that is too short for its part.
        """
        motions = motions_of(demonstrations)
        at = (
            [normalised_times(motion.times) for motion in motions]
            if phases is None
            else _phases(phases, motions, rhythmic=self.basis == "rhythmic")
        )
        chart = chart_of(motions, at)
        columns = [
            chart.columns(motion, u, f"demonstrations[{i}]")
            for i, (motion, u) in enumerate(zip(motions, at, strict=True))
        ]
        scale = scales(columns, chart)
        basis = Basis(self.basis, self.weights, float(self.width))
        if self.estimator == "em":
            fit = expectation_maximisation(basis, at, columns, scale)
        else:
            _refuse_parts(at)
            fit = least_squares(basis, at, columns, scale, self.regularization)
        whole = [m.duration / float(u[-1] - u[0]) for m, u in zip(motions, at, strict=True)]
        return ProMPSkill(basis, chart, fit.weights, fit.noise, scale, float(np.median(whole)))


def _phases(
    phases: Sequence[Any], motions: Sequence[Motion], *, rhythmic: bool
) -> list[Float64Array]:
    if not isinstance(phases, Sequence) or len(phases) != len(motions):
        raise InvalidInput(f"phases: expected a sequence of {len(motions)} arrays")
    checked = []
    for i, (given, motion) in enumerate(zip(phases, motions, strict=True)):
        name = f"phases[{i}]"
        u = check.array(given, name, shape=(len(motion.times),))
        if not (np.diff(u) > 0).all():
            raise InvalidInput(f"{name}: expected strictly increasing phases")
        if not rhythmic and not (u[0] >= 0.0 and u[-1] <= 1.0):
            raise InvalidInput(f"{name}: expected phases in [0, 1], got {u[0]:.6g} to {u[-1]:.6g}")
        checked.append(u)
    return checked


def _refuse_parts(phases: Sequence[Float64Array]) -> None:
    for i, u in enumerate(phases):
        if u[-1] - u[0] < _LEAST_COVERED:
            raise FitError(
                f"demonstrations[{i}]: covers the phases {u[0]:.3g} to {u[-1]:.3g} only; "
                'fit with estimator="em", which takes parts of a motion'
            )

"""Probabilistic movement primitives: normal distributions over motions.

A motion is a weighted sum of basis functions of its phase; over the demonstrations, the weights are
normally distributed.

Source: Paraschos et al. 2013, "Probabilistic movement primitives".
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.blas_threads import one_blas_thread
from leadthrough.check import Float64Array
from leadthrough.errors import FitError, InvalidInput
from leadthrough.models import archive
from leadthrough.models.chart import Chart, chart_of, scales
from leadthrough.models.demonstrations import Demonstrations, motions_of, warn_of_misalignment
from leadthrough.models.promp import limits
from leadthrough.models.promp.basis import KINDS, LEAST, Basis, BasisKind
from leadthrough.models.promp.belief import Experience
from leadthrough.models.promp.em import expectation_maximisation
from leadthrough.models.promp.estimation import LEAST_COVERED, Shown
from leadthrough.models.promp.gaussian import Gaussian
from leadthrough.models.promp.least_squares import least_squares
from leadthrough.models.promp.skill import ProMPSkill
from leadthrough.models.protocol import Unfitted
from leadthrough.motion import Motion, MotionT, normalised_times

Estimator: TypeAlias = Literal["least_squares", "em"]

# Margins of the basis: of files which do not say, and of fewer functions than these, which cannot
# be spared outside the motion.
_EARLIER_MARGIN, _LEAST_MARGIN = 1.0, 0.25
_FEW = 15


@dataclass(frozen=True)
class ProMP(Unfitted):
    """A probabilistic movement primitive of points, joints or poses.

    Attributes:
        weights: number of basis functions per column, 4 to 10,000.
        basis: "gaussian", "bspline", or "rhythmic" for motions of one period that end where they
            began.
        width: standard deviation of the Gaussian and rhythmic functions, in spacings of their
            centres, 0.3 to 3. Velocities ripple with narrow functions, from 0.6 down; wide ones
            are hard to tell from each other.
        estimator: "least_squares", which is quick and exact at both ends of every demonstration,
            or "em", which weighs noisy samples against each other and takes demonstrations of only
            a part of the motion.
        regularization: cost of a wiggle of a least-squares curve relative to that of an error, > 0.
        margin: how far the outermost Gaussian functions lie beyond the ends of the motion, in
            spacings of the centres, 0 to 1. The less, the finer is the detail that as many
            functions resolve; the more, the smoother is the motion at its ends. By default 1, and
            0.25 for fewer than 15 functions.

    Raises:
        InvalidInput: if a setting is out of range.
    """

    weights: int = 20
    basis: BasisKind = "gaussian"
    width: float = 1.0
    estimator: Estimator = "least_squares"
    regularization: float = 1e-5
    margin: float | None = None

    def __post_init__(self) -> None:
        check.integer(self.weights, "weights", at_least=LEAST, at_most=10_000)
        check.choice(self.basis, "basis", KINDS)
        check.number(self.width, "width", at_least=0.3, at_most=3.0)
        check.choice(self.estimator, "estimator", get_args(Estimator))
        check.number(self.regularization, "regularization", above=0.0)
        if self.margin is not None:
            check.number(self.margin, "margin", at_least=0.0, at_most=1.0)

    @one_blas_thread
    def fit(
        self,
        demonstrations: Demonstrations[MotionT],
        *,
        phases: Sequence[ArrayLike] | None = None,
    ) -> ProMPSkill[MotionT]:
        """A skill from demonstrations, all of points, of the same joints, or of poses.

        Args:
            demonstrations: one or more demonstrations, or motions, of one type.
            phases: for each demonstration, the phases (n,) of its samples, increasing in [0, 1];
                of rhythmic motions in periods. By default its normalised times. A demonstration
                of a part of the motion covers a part of [0, 1], which needs estimator="em".

        Raises:
            InvalidInput: if the demonstrations differ in type or the phases do not fit them.
            FitError: if there is no demonstration, one does not move, one shows too small a part
                for its estimator, or none shows some part of the motion.

        Warns:
            MisalignmentWarning: if demonstrations are misaligned in time and no phases are given.
        """
        motions = motions_of(demonstrations)
        at = (
            [normalised_times(motion.times) for motion in motions]
            if phases is None
            else _checked_phases(phases, motions, rhythmic=self.basis == "rhythmic")
        )
        chart = chart_of(motions, at)
        if phases is None:
            warn_of_misalignment(motions)
        columns = [
            chart.columns(motion, u, f"demonstrations[{i}]")
            for i, (motion, u) in enumerate(zip(motions, at, strict=True))
        ]
        shown = Shown(at, columns, scales(columns, chart))
        basis = _basis_of(self)
        if self.estimator == "em":
            fit = expectation_maximisation(basis, shown)
        else:
            _refuse_parts(at)
            fit = least_squares(basis, shown, self.regularization)
        whole = [m.duration / float(u[-1] - u[0]) for m, u in zip(motions, at, strict=True)]
        duration = float(np.median(whole))
        experience = None
        if len(fit.curves) > 0:
            paces = np.log(np.divide(whole, duration))
            experience = Experience(basis, fit.curves, paces, fit.noise, shown.scale)
        return ProMPSkill(
            self,
            basis,
            chart,
            fit.weights,
            fit.noise,
            shown.scale,
            duration,
            experience=experience,
        )


# Any: settings are whatever JSON holds.
def from_archive(settings: dict[str, Any], arrays: archive.Arrays) -> ProMPSkill:
    """The skill from the settings and arrays that `ProMPSkill.to_archive` returned."""
    model = _model_of(settings)
    basis, chart = _basis_of(model), Chart.from_archive(settings, arrays)
    size = chart.width * basis.count
    weights = Gaussian(
        check.frozen(arrays["mean"], "mean", shape=(size,)),
        check.frozen(arrays["covariance"], "covariance", shape=(size, size)),
    )
    noise, scale = (
        check.frozen(arrays[name], name, shape=(chart.width,)) for name in ("noise", "scale")
    )
    bounds = None
    if "lower" in arrays:
        bounds = limits.checked(arrays["lower"], arrays["upper"], chart.width)
    experience = None
    if "curves" in arrays:
        curves = check.frozen(arrays["curves"], "curves", shape=("m", size))
        paces = check.frozen(arrays["paces"], "paces", shape=("n",))
        experience = Experience(basis, curves, paces, noise, scale)
    duration = float(settings["duration"])
    skill = ProMPSkill(model, basis, chart, weights, noise, scale, duration, bounds, experience)
    if bounds is not None and "truncated" not in settings:
        # An earlier version wrote the distribution that it had already moved inside the limits.
        vars(skill)["weights"] = weights
    return skill


def _model_of(settings: dict[str, Any]) -> ProMP:
    """The model in a file; the earliest ones have only its basis, in three entries."""
    if "model" in settings:
        return ProMP(**{"margin": _EARLIER_MARGIN, **settings["model"]})
    count, width = int(settings["count"]), float(settings.get("width", ProMP.width))
    return ProMP(weights=count, basis=settings["basis"], width=width, margin=_EARLIER_MARGIN)


def _basis_of(model: ProMP) -> Basis:
    margin = model.margin
    if margin is None:
        margin = _EARLIER_MARGIN if model.weights >= _FEW else _LEAST_MARGIN
    return Basis(model.basis, model.weights, float(model.width), float(margin))


def _checked_phases(
    phases: Sequence[ArrayLike], motions: Sequence[Motion], *, rhythmic: bool
) -> list[Float64Array]:
    if not isinstance(phases, Sequence) or len(phases) != len(motions):
        got = len(phases) if isinstance(phases, Sequence) else type(phases).__name__
        raise InvalidInput(
            f"phases: expected one array per demonstration, {len(motions)}, got {got}"
        )
    checked = []
    for i, (given, motion) in enumerate(zip(phases, motions, strict=True)):
        name = f"phases[{i}]"
        u = check.array(given, name, shape=(len(motion.times),))
        if (np.diff(u) <= 0).any():
            at = int(np.argmax(np.diff(u) <= 0))
            raise InvalidInput(
                f"{name}: expected strictly increasing phases, "
                f"got {u[at]:.6g} then {u[at + 1]:.6g} at samples {at} and {at + 1}"
            )
        if not rhythmic and not (u[0] >= 0.0 and u[-1] <= 1.0):
            raise InvalidInput(f"{name}: expected phases in [0, 1], got {u[0]:.6g} to {u[-1]:.6g}")
        checked.append(u)
    return checked


def _refuse_parts(phases: Sequence[Float64Array]) -> None:
    for i, u in enumerate(phases):
        if u[-1] - u[0] < LEAST_COVERED:
            raise FitError(
                f"demonstrations[{i}]: covers only the phases {u[0]:.3g} to {u[-1]:.3g}; "
                'set estimator="em", which takes parts of a motion'
            )

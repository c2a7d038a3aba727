"""What the estimators of a ProMP's weights take and return."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from leadthrough.check import Float64Array
from leadthrough.models.promp.gaussian import Gaussian

# The least standard deviation that a motion is believed to have, as a fraction of its reach.
LEAST_SPREAD = 3e-2
# A curve fitted to a smaller part of the phases than this is free to do anything in the rest.
LEAST_COVERED = 0.9


@dataclass(frozen=True, eq=False)
class Shown:
    """Demonstrations as columns over phases.

    Attributes:
        phases: phases (n,) of the samples of each motion.
        columns: columns (n, d) of the samples of each motion.
        scale: reach (d,) of the motions.
    """

    phases: Sequence[Float64Array]
    columns: Sequence[Float64Array]
    scale: Float64Array


@dataclass(frozen=True, eq=False)
class Fit:
    """What an estimator found."""

    weights: Gaussian  # distribution of the weights (d k,), one column after the other
    noise: Float64Array  # variances (d,) of the samples about their curves
    curves: Float64Array  # weights (m, d k) of the m demonstrations that show the whole motion
    history: tuple[float, ...] = ()

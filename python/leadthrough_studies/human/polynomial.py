"""The mean of a ProMP with the polynomial basis that Yang et al. name beside the Gaussian one.

Each demonstration is fitted by Legendre polynomials over its phase, with least squares, and the
weights are averaged. Legendre's span the same curves as the powers, which are badly conditioned.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial import Legendre

from leadthrough.check import Float64Array
from leadthrough.motion import Demonstration, normalised_times


@dataclass(frozen=True, eq=False)
class PolynomialMean:
    """A polynomial of the phase for each coordinate.

    Attributes:
        curves: of each coordinate, over the phase from 0 to 1.
        duration: s.
    """

    curves: tuple[Legendre, ...]
    duration: float

    def lasting(self, duration: float) -> PolynomialMean:
        """The same motion with another duration in s."""
        return replace(self, duration=duration)

    def distribution(self, times: Float64Array, *, order: int = 0) -> tuple[Float64Array]:
        """The mean (n, d) of a derivative, as the first entry, as that of a ProMP skill."""
        phases = times / self.duration
        columns = [curve.deriv(order)(phases) if order else curve(phases) for curve in self.curves]
        return (np.stack(columns, axis=1) / self.duration**order,)


def polynomial_mean(shown: Sequence[Demonstration], *, weights: int) -> PolynomialMean:
    """The mean of demonstrations.

    Args:
        shown: at least one.
        weights: number of polynomials.
    """
    fits = [
        [
            Legendre.fit(
                normalised_times(each.motion.times), column, weights - 1, domain=(0.0, 1.0)
            )
            for column in each.motion.positions.T
        ]
        for each in shown
    ]
    curves = [sum(own[1:], own[0]) / len(own) for own in zip(*fits, strict=True)]
    return PolynomialMean(tuple(curves), float(np.mean([each.motion.duration for each in shown])))

"""Modified DS: a network's velocities, corrected by a Lyapunov function that is a network too.

The velocities f(x) of the original system are a network's; V is a neural function with a single
minimum, learned so that it falls along the demonstrations; the modified system is f(x) + u(x) with
the least u for which V falls.

Source: Zhang, Cheng, Li and Cao 2022, "Learning accurate and stable point-to-point motions: a
dynamic system approach", IEEE Robotics and Automation Letters 7, 1510-1517 (reference 29 of Prados
et al. 2023). We know it by its summary, not by its formulas. So these are ours: V(x) = |x|^2
exp(2 h(x)) with a network h whose slope along rays is bounded (`star_network`), the hidden units of
f at random samples with ridge regression behind them, and the correction, which is CLF-DM's.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from leadthrough import check
from leadthrough.models.dynamical import star_network
from leadthrough.models.dynamical.corrected import Corrected
from leadthrough.models.dynamical.lyapunov import Descent
from leadthrough.models.dynamical.model import DynamicalModel
from leadthrough.models.dynamical.regression import network_regression
from leadthrough.models.dynamical.samples import Shown

_NEAR = 0.05  # sizes of the motion
_RIDGE, _WIDTH = 1e-5, 0.1


@dataclass(frozen=True)
class ModifiedDS(DynamicalModel):
    """A network of velocities, made stable by a neural Lyapunov function.

    Attributes:
        units: number of hidden units of the velocities' network, 1 to 1000.
        energy_units: number of hidden units of the Lyapunov function, 1 to 200.
        slowest: least speed down the Lyapunov function, in sizes of the motion per duration, > 0.
        seed: seed of the random number generator that draws the hidden units, >= 0.

    Raises:
        InvalidInput: if a setting is out of range.
    """

    units: int = 100
    energy_units: int = 20
    slowest: float = 0.1
    seed: int = 0

    slider: ClassVar[tuple[str, int, int]] = ("units", 10, 300)

    def __post_init__(self) -> None:
        check.integer(self.units, "units", at_least=1, at_most=1000)
        check.integer(self.energy_units, "energy_units", at_least=1, at_most=200)
        check.number(self.slowest, "slowest", above=0.0)
        check.integer(self.seed, "seed", at_least=0)

    def _learned(self, shown: Shown) -> Corrected:
        x, v = shown.x, shown.v
        energy = star_network.fitted(x, v, self.energy_units, seed=self.seed)
        regression = network_regression(
            x, v, self.units, width=_WIDTH, ridge=_RIDGE, seed=self.seed
        )
        return Corrected(regression, energy, Descent(self.slowest, _NEAR))

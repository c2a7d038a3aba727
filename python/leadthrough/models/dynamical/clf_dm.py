"""CLF-DM: any regression of velocities, corrected online by a learned Lyapunov function.

Three steps: a control Lyapunov function V, the weighted sum of asymmetric quadratic functions, is
learned so that it falls along the demonstrations; velocities f(x) are regressed, here by Gaussian
mixture regression; and x' = f(x) + u*(x) with the least u* for which V falls,

    u* = 0 where grad V . f <= -rho |grad V|,
    u* = -(grad V . f + rho |grad V|) / |grad V|^2 grad V elsewhere.

Source: Khansari-Zadeh and Billard 2014, "Learning control Lyapunov function to ensure stability of
dynamical system-based robot reaching motions", Robotics and Autonomous Systems 62, 752-765. What it
leaves open and is ours: rho(x) = rho_0 (1 - exp(-|x| / 0.05)) is a speed, as it is multiplied by
|grad V|; V is learned from twelve starts, with bounded parameters; what the regression gives at the
goal, where the velocity has to be 0, is taken off within a twentieth of the motion's size; and four
deviations and more away from all demonstrations, f gives way to -3 x.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from leadthrough import check
from leadthrough.models.dynamical import asymmetric_quadratics
from leadthrough.models.dynamical.corrected import Corrected
from leadthrough.models.dynamical.lyapunov import Descent
from leadthrough.models.dynamical.model import DynamicalModel
from leadthrough.models.dynamical.regression import mixture_regression
from leadthrough.models.dynamical.samples import Shown

_NEAR = 0.05  # sizes of the motion


@dataclass(frozen=True)
class CLFDM(DynamicalModel):
    """Gaussian mixture regression of velocities, made stable by a learned Lyapunov function.

    Attributes:
        components: number of components of the regression, 1 to 50.
        quadratics: number of asymmetric quadratic functions of the Lyapunov function, 0 to 20.
        slowest: least speed down the Lyapunov function, in sizes of the motion per duration, > 0.
        seed: seed of the random number generator that draws all starts, >= 0.

    Raises:
        InvalidInput: if a setting is out of range.
    """

    components: int = 8
    quadratics: int = 3
    slowest: float = 0.1
    seed: int = 0

    slider: ClassVar[tuple[str, int, int]] = ("components", 1, 20)

    def __post_init__(self) -> None:
        check.integer(self.components, "components", at_least=1, at_most=50)
        check.integer(self.quadratics, "quadratics", at_least=0, at_most=20)
        check.number(self.slowest, "slowest", above=0.0)
        check.integer(self.seed, "seed", at_least=0)

    def _learned(self, shown: Shown) -> Corrected:
        x, v = shown.x, shown.v
        energy = asymmetric_quadratics.fitted(x, v, self.quadratics, seed=self.seed)
        regression = mixture_regression(x, v, self.components, seed=self.seed)
        return Corrected(regression, energy, Descent(self.slowest, _NEAR))

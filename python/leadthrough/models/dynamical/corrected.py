"""A regression of velocities, corrected so that a learned energy falls."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array
from leadthrough.models.dynamical.field import Field
from leadthrough.models.dynamical.lyapunov import Descent, Energy

# Distance from the goal within which the regression's velocity at the goal is subtracted.
_AT_GOAL = 0.05
# Far from all demonstrations, the velocity is -x times this, per duration, before it is corrected.
_HOME = 3.0
# Deviations from the nearest samples at which a regression is trusted by half.
_TRUSTED = 4.0


class Regression(Protocol):
    """Velocities at positions."""

    @property
    def size(self) -> int:
        """Number d of columns."""

    def velocity(self, x: Float64Array) -> Float64Array:
        """Velocities (n, d) at positions (n, d)."""

    def trust(self, x: Float64Array) -> Float64Array:
        """Trust (n,) at positions (n, d): 1 at demonstrations, falling to 0 away from them."""

    def arrays(self) -> Mapping[str, NDArray[Any]]:
        """Its arrays, by the names of its attributes."""


@dataclass(frozen=True, eq=False)
class Corrected(Field):
    """x' = f(x) + u(x): a regression f, and the least u with which the energy falls."""

    regression: Regression
    potential: Energy  # the energy
    descent: Descent  # least speed down the energy

    name: ClassVar[str] = "corrected"
    regressions: ClassVar[Any]  # class of the regression
    energies: ClassVar[Any]  # class of the energy

    @property
    def size(self) -> int:
        """Number d of columns."""
        return self.regression.size

    def velocity(self, x: Float64Array) -> Float64Array:
        """Velocities (n, d) at positions (n, d)."""
        fading = np.exp(-0.5 * ((x / _AT_GOAL) ** 2).sum(axis=1, keepdims=True))
        trust = self.regression.trust(x)[:, None]
        velocity = trust * (self.regression.velocity(x) - fading * self._rest)
        velocity -= _HOME * (1.0 - trust) * x
        return self.descent.corrected(velocity, x, self.potential.gradient(x))

    def energy(self, states: Float64Array) -> Float64Array:
        """Energies (n,) of positions (n, d)."""
        return self.potential.value(states)

    def power(self, states: Float64Array) -> Float64Array:
        """Derivatives (n,) of the energy at positions (n, d)."""
        uphill = self.potential.gradient(states)
        return np.asarray((uphill * self.velocity(states)).sum(axis=1))

    def arrays(self) -> Mapping[str, NDArray[Any]]:
        """Its arrays, by the names of its attributes."""
        descent = np.array([self.descent.slowest, self.descent.near])
        return {"descent": descent, **self.regression.arrays(), **self.potential.arrays()}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """The system with these arrays."""
        return cls(
            cls.regressions.from_arrays(arrays),
            cls.energies.from_arrays(arrays),
            Descent(*map(float, arrays["descent"])),
        )

    @cached_property
    def _rest(self) -> Float64Array:
        """Velocity (1, d) of the regression at the goal."""
        return self.regression.velocity(np.zeros((1, self.regression.size)))


def trusted(nearness: Float64Array) -> Float64Array:
    """1 where one of exp(-d_i^2 / 2), (n, k), is large, 1/2 where d = 4, 0 beyond: (n,)."""
    near = nearness.sum(axis=1)
    return np.asarray(near / (near + np.exp(-0.5 * _TRUSTED**2)))

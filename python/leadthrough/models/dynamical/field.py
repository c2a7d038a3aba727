"""What the dynamical systems have in common: a velocity everywhere, and an energy that falls.

Systems stand in normalised columns: the goal is 0, the demonstrations lie about in the unit ball,
and the time is in durations of the demonstrations.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar

from numpy.typing import NDArray

from leadthrough.check import Float64Array


class Field(ABC):
    """A system whose trajectories all end at 0: x' = f(x) with a falling energy V(x)."""

    name: ClassVar[str]  # what files call this kind of system

    @property
    @abstractmethod
    def size(self) -> int:
        """Number d of columns."""

    @abstractmethod
    def velocity(self, x: Float64Array) -> Float64Array:
        """Velocities (n, d) at positions (n, d)."""

    @abstractmethod
    def energy(self, states: Float64Array) -> Float64Array:
        """Energies (n,) of states (n, s): 0 at the goal, positive elsewhere."""

    @abstractmethod
    def power(self, states: Float64Array) -> Float64Array:
        """Derivatives (n,) of the energy along the trajectories through states (n, s)."""

    def states(self, x: Float64Array) -> Float64Array:
        """The states (n, s) in which motions start at positions (n, d)."""
        return x

    def rate(self, states: Float64Array) -> Float64Array:
        """Derivatives (n, s) of states (n, s); the first d columns of a state are the position."""
        return self.velocity(states)

    @abstractmethod
    def arrays(self) -> Mapping[str, NDArray[Any]]:
        """What it is made of, by the names of its attributes."""

"""Dynamical systems: a velocity everywhere, and an energy that falls.

Columns are normalised: the goal is 0, the demonstrations lie about in the unit ball, and the time
is in durations of the demonstrations.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array


class Field(ABC):
    """A system whose trajectories all end at 0: x' = f(x) with a falling energy V(x)."""

    name: ClassVar[str]  # of this kind of system in files

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
        """Its arrays, by the names of its attributes."""

    @classmethod
    @abstractmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """The system with these arrays."""


def squared_distances(x: Float64Array, centres: Float64Array) -> Float64Array:
    """Squared distances (n, k) of positions (n, d) from centres (k, d).

    Args:
        x: positions (n, d).
        centres: centres (k, d).
    """
    mixed = x @ centres.T
    squared = (x**2).sum(axis=1)[:, None] - 2.0 * mixed + (centres**2).sum(axis=1)
    return np.asarray(np.maximum(squared, 0.0))

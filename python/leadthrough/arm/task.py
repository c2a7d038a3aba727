"""What all tasks for an arm have in common, and the checks of their arguments.

A task that reaches wants its error to decay at `gain`, 1/s: in velocities like exp(-gain t), in
accelerations like a second-order system of that frequency and `damping_ratio` (De Luca, Oriolo and
Siciliano 1992). A task that keeps a distance (a cone, joint limits, an obstacle) is unilateral: the
distance may shrink no faster than `gain` times what is left of it (the velocity damper of Faverjon
and Tournassoud 1987). It begins to act `margin` before its limit and acts fully from half of that.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import _core, check
from leadthrough.arm import magnitudes
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.repr import ShortRepr

# m/s and rad/s, or a point: nothing along any axis.
ZERO = (0.0, 0.0, 0.0)
STILL = (*ZERO, *ZERO)
# The same as arrays: loops make tasks in every step, and what is left out need not be checked anew.
_NOTHING = {
    len(axes): magnitudes.frozen(axes, "axes", shape=(len(axes),)) for axes in (ZERO, STILL)
}

# The frame of a link, at a point given in it.
FrameOf = Callable[[str | None, Float64Array], _core.Frame]


@dataclass(frozen=True, eq=False, init=False)
class ArmTask(ShortRepr, ABC):
    """A task for a `TaskStack`: something to reach, or to keep away from.

    Attributes:
        gain: rate at which the error decays, 1/s, > 0.
        damping_ratio: of the decay where accelerations are commanded, > 0; 1 is critical.
    """

    gain: float
    damping_ratio: float

    def __init__(self, gain: float, damping_ratio: float) -> None:
        vars(self).update(
            gain=magnitudes.positive(gain, "gain"),
            damping_ratio=magnitudes.positive(damping_ratio, "damping_ratio"),
        )

    @abstractmethod
    def _compiled(self, frame_of: FrameOf) -> _core.ArmTask:
        """The task as the core takes it."""


def vector(value: ArrayLike, name: str, size: int) -> Float64Array:
    """A read-only copy (size,) of a value of moderate size."""
    if (value is ZERO or value is STILL) and len(value) == size:
        return _NOTHING[size]
    return magnitudes.frozen(value, name, shape=(size,))


def orientation(value: ArrayLike) -> Float64Array:
    """A read-only unit quaternion (4,) w, x, y, z."""
    unit = check.quaternions(value, "orientation", shape=(4,))
    unit.setflags(write=False)
    return unit


def direction(value: ArrayLike, name: str) -> Float64Array:
    """A read-only unit vector (3,).

    Raises:
        InvalidInput: if it has another shape or is zero.
    """
    given = check.array(value, name, shape=(3,))
    largest = float(np.abs(given).max())
    if largest == 0.0:
        raise InvalidInput(f"{name}: expected a direction, got the zero vector")
    scaled = given / largest
    unit = np.asarray(scaled / np.linalg.norm(scaled))
    unit.setflags(write=False)
    return unit

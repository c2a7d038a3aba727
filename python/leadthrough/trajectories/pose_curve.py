"""Curves of poses: a curve of positions beside one of rotations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.motion import PoseTrajectory
from leadthrough.repr import ShortRepr
from leadthrough.trajectories import curve
from leadthrough.trajectories.curve import Curve
from leadthrough.trajectories.rotation_curve import RotationCurve

# Domains may differ by rounding, relative to their length.
_SAME = 1e-9


@dataclass(frozen=True, eq=False)
class PoseCurve(ShortRepr):
    """Positions in 3-D and rotations over one domain.

    Attributes:
        positions: a curve in 3-D, m.
        orientations: a curve of rotations over the same domain.

    Raises:
        InvalidInput: if they are not such curves, or their domains differ.
    """

    positions: Curve
    orientations: RotationCurve

    def __post_init__(self) -> None:
        if not isinstance(self.positions, Curve):
            raise InvalidInput(f"positions: expected a curve, got {type(self.positions).__name__}")
        if not isinstance(self.orientations, RotationCurve):
            what = type(self.orientations).__name__
            raise InvalidInput(f"orientations: expected a curve of rotations, got {what}")
        a, b = self.positions.domain, self.orientations.domain
        if not np.allclose(a, b, rtol=0.0, atol=_SAME * (a[1] - a[0])):
            raise InvalidInput(f"orientations: expected the domain {a} of positions, got {b}")
        dimensions = len(self.positions.evaluate(a[0]))
        if dimensions != 3:
            raise InvalidInput(f"positions: expected a curve in 3-D, got {dimensions}-D")

    @property
    def domain(self) -> tuple[float, float]:
        """First and last time."""
        return self.positions.domain

    @property
    def knots(self) -> Float64Array:
        """The knots of both."""
        return np.union1d(self.positions.knots, self.orientations.knots)

    def evaluate(self, t: ArrayLike, derivative: int = 0) -> tuple[Float64Array, Float64Array]:
        """Positions and rotations, or linear and angular velocities or accelerations.

        Args:
            t: times of the domain, (n,) or one.
            derivative: 0, 1 or 2.

        Returns:
            Positions (n, 3) and unit quaternions (n, 4), or their derivatives, (n, 3) each, in the
            base frame.

        Raises:
            InvalidInput: if a time lies outside the domain, or the order is another.
        """
        times = curve.times_inside(t, self.domain)
        return (
            self.positions.evaluate(times, derivative),
            self.orientations.evaluate(times, derivative),
        )

    def sampled(self, times: ArrayLike) -> PoseTrajectory:
        """The poses at given times.

        Args:
            times: strictly increasing, (n,), of the domain.

        Raises:
            InvalidInput: if they do not rise, or one lies outside the domain.
        """
        t = curve.times_inside(times, self.domain)
        return PoseTrajectory(t, *self.evaluate(t))

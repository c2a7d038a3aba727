"""Curves of poses: a curve of positions beside one of rotations."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.motion import PoseTrajectory
from leadthrough.trajectories import curve
from leadthrough.trajectories.curve import Curve
from leadthrough.trajectories.rotation_curve import RotationCurve

# Domains may differ by rounding, relative to their length.
_SAME = 1e-9


@dataclass(frozen=True, eq=False)
class PoseCurve:
    """Positions in 3-D and rotations over one domain. Raises InvalidInput."""

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

    def evaluate(self, t: Any, derivative: int = 0) -> tuple[Float64Array, Float64Array]:
        """Positions and rotations, or linear and angular velocities or accelerations.

        Raises InvalidInput.
        """
        times = curve.times_inside(t, self.domain)
        return (
            self.positions.evaluate(times, derivative),
            self.orientations.evaluate(times, derivative),
        )

    def sampled(self, times: Any) -> PoseTrajectory:
        """The poses at rising times (n,). Raises InvalidInput."""
        t = curve.times_inside(times, self.domain)
        return PoseTrajectory(t, *self.evaluate(t))

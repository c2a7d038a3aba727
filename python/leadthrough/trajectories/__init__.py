"""Curves of many kinds behind one interface."""

from leadthrough.trajectories.curve import Curve
from leadthrough.trajectories.spline import Spline

__all__ = ["Curve", "Spline"]

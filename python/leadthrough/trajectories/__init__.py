"""Curves of many kinds behind one interface: `evaluate(t, derivative)`, `domain`, `knots`.

After Grioli's notes on trajectories (2023), chapters 2 and 3.
"""

from leadthrough.trajectories.bezier import Bezier, de_casteljau, joined
from leadthrough.trajectories.bspline import BSpline, Nurbs, bspline_near, nurbs_through
from leadthrough.trajectories.curve import Curve, PointCurve
from leadthrough.trajectories.filters import (
    FilterState,
    FirstOrderFilter,
    JerkFilter,
    LinearFilter,
    LineState,
    SecondOrderFilter,
    StraightFilter,
    TimeOptimalFilter,
)
from leadthrough.trajectories.interpolation import (
    clamped_cubic,
    hermite,
    linear,
    natural_cubic,
    periodic_cubic,
    smooth,
    smoothing,
)
from leadthrough.trajectories.law import PoseCurve, run_by
from leadthrough.trajectories.minimum_jerk import (
    State,
    minimum_jerk,
    minimum_jerk_through,
    minimum_jerk_time_scaling,
    point_to_point,
)
from leadthrough.trajectories.polynomial import Lagrange, chebyshev_nodes, osculating
from leadthrough.trajectories.profiles import double_s, trapezoid
from leadthrough.trajectories.rotation import (
    RotationBezier,
    RotationCurve,
    RotationSpline,
    Slerp,
    Squad,
)
from leadthrough.trajectories.spline import Spline

__all__ = [
    "BSpline",
    "Bezier",
    "Curve",
    "FilterState",
    "FirstOrderFilter",
    "JerkFilter",
    "Lagrange",
    "LineState",
    "LinearFilter",
    "Nurbs",
    "PointCurve",
    "PoseCurve",
    "RotationBezier",
    "RotationCurve",
    "RotationSpline",
    "SecondOrderFilter",
    "Slerp",
    "Spline",
    "Squad",
    "State",
    "StraightFilter",
    "TimeOptimalFilter",
    "bspline_near",
    "chebyshev_nodes",
    "clamped_cubic",
    "de_casteljau",
    "double_s",
    "hermite",
    "joined",
    "linear",
    "minimum_jerk",
    "minimum_jerk_through",
    "minimum_jerk_time_scaling",
    "natural_cubic",
    "nurbs_through",
    "osculating",
    "periodic_cubic",
    "point_to_point",
    "run_by",
    "smooth",
    "smoothing",
    "trapezoid",
]

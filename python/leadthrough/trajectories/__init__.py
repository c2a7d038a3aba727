"""Curves of many kinds behind one interface: `evaluate(t, derivative)`, `domain`, `knots`.

After Grioli's notes on trajectories (2023), chapters 2 and 3.
"""

from leadthrough.trajectories.bezier import (
    Bezier as Bezier,
    de_casteljau as de_casteljau,
    joined as joined,
)
from leadthrough.trajectories.bspline import (
    BSpline as BSpline,
    Nurbs as Nurbs,
    as_bspline as as_bspline,
    bezier_pieces as bezier_pieces,
    bspline_near as bspline_near,
    nurbs_through as nurbs_through,
    with_knot as with_knot,
)
from leadthrough.trajectories.curve import (
    Curve as Curve,
    PointCurve as PointCurve,
    Spline as Spline,
)
from leadthrough.trajectories.filters import (
    FilterState as FilterState,
    FirstOrderFilter as FirstOrderFilter,
    JerkFilter as JerkFilter,
    LinearFilter as LinearFilter,
    SecondOrderFilter as SecondOrderFilter,
    TimeOptimalFilter as TimeOptimalFilter,
)
from leadthrough.trajectories.interpolation import (
    clamped_cubic as clamped_cubic,
    hermite as hermite,
    linear as linear,
    natural_cubic as natural_cubic,
    periodic_cubic as periodic_cubic,
    smooth as smooth,
    smoothing as smoothing,
)
from leadthrough.trajectories.law import PoseCurve as PoseCurve, run_by as run_by
from leadthrough.trajectories.minimum_jerk import (
    State as State,
    minimum_jerk as minimum_jerk,
    minimum_jerk_through as minimum_jerk_through,
    minimum_jerk_time_scaling as minimum_jerk_time_scaling,
    point_to_point as point_to_point,
)
from leadthrough.trajectories.polynomial import (
    Lagrange as Lagrange,
    chebyshev_nodes as chebyshev_nodes,
    osculating as osculating,
)
from leadthrough.trajectories.profiles import double_s as double_s, trapezoid as trapezoid
from leadthrough.trajectories.rotation import (
    RotationBezier as RotationBezier,
    RotationCurve as RotationCurve,
    RotationSpline as RotationSpline,
    Slerp as Slerp,
    Squad as Squad,
)
from leadthrough.trajectories.straight_filter import (
    LineState as LineState,
    StraightFilter as StraightFilter,
)

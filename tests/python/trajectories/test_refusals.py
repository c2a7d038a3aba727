"""Refusals of `trajectories`: calls, by what their messages name."""

import numpy as np
import pytest
from refusals import refused

from leadthrough import rotations, trajectories as tr

TIMES = np.array([-1.0, -0.3, 0.1, 0.4, 1.0, 1.3])
UNEVEN = np.array([0.0, 1e-6, 0.5, 0.500001, 0.9, 5.0])
SINES = np.sin(np.outer(TIMES, [1.0, 2.0, 3.0]))
PATH = tr.Bezier([[0.0, 0.0, 0.0], [1.0, 2.0, 0.5], [2.0, -1.0, 1.0], [3.0, 0.0, 0.0]])
PIECE = tr.Bezier([[0.0, 0.0], [1.0, 1.0]])
TURNED = tr.Slerp(TIMES, rotations.exp(SINES))
LIMITS = {"velocity": 2.0, "acceleration": 3.0, "jerk": 8.0}
RUCKIG = {"velocity": [1.0, 2.0, 0.5], "acceleration": 3.0, "jerk": 20.0}
LAW = {"velocity": 1.0, "acceleration": 1.0}
ORIGIN, WAY = [0.0, 0.0, 0.0], np.array([3.0, -4.0])
REST, MOVING = tr.FilterState.at_rest([0.0]), tr.FilterState(*np.array([[0.0], [1.0], [0.0]]))
BOUNDED, OPTIMAL = tr.JerkFilter(1.0, 1.0, 1.0), tr.TimeOptimalFilter(1.0, 1.0)

REFUSED = {
    "": [
        lambda: tr.BSpline(np.zeros((3, 1)), [0, 0, 1, 1], 2),
        lambda: tr.BSpline(np.zeros((3, 1)), [0, 0, 0, 0, 0, 0], 2),
        lambda: tr.BSpline(np.zeros((3, 1)), [0, 1, 0, 1, 2, 3], 2),
        lambda: tr.BSpline(np.zeros((2, 1)), [0, 0, 0, 1, 1], 2),
        lambda: tr.Nurbs(np.zeros((3, 1)), [1, 0, 1], [0, 0, 0, 1, 1, 1], 2),
        lambda: tr.Bezier(np.zeros((2, 1)), (1.0, 1.0)),
        lambda: tr.Bezier(np.zeros((1000, 1))),
        lambda: tr.Bezier(np.zeros((2, 1))).split(1.0),
        lambda: tr.chebyshev_nodes(1),
        lambda: tr.smoothing(TIMES, TIMES, weight=-1.0),
        lambda: tr.smooth(TIMES, TIMES, continuity=40),
        lambda: tr.Spline([0.0, 1.0], np.empty((1, 0, 2))),
        lambda: tr.minimum_jerk([0.0], [1.0, 2.0], duration=1.0),
        lambda: tr.minimum_jerk([0.0], [1.0], duration=0.0),
        lambda: tr.trapezoid([0.0], [0.0], velocity=1.0, acceleration=1.0),
        lambda: tr.trapezoid([0.0], [1.0], velocity=0.0, acceleration=1.0),
        lambda: tr.double_s([0.0], [1.0], velocity=1.0, acceleration=1.0, jerk=[1.0, 2.0]),
        lambda: tr.FirstOrderFilter(0.0),
        lambda: tr.SecondOrderFilter(1.0, np.nan),
        lambda: tr.TimeOptimalFilter(1.0, [-1.0]),
        lambda: tr.TimeOptimalFilter([[1.0]], 1.0),
        lambda: tr.TimeOptimalFilter([1.0, 2.0], 1.0).step(REST, [1.0], 0.1),
        lambda: OPTIMAL.step(REST, [np.nan], 0.1),
        lambda: OPTIMAL.step(REST, [1.0], 0.0),
        lambda: OPTIMAL.step("state", [1.0], 0.1),
        lambda: tr.FilterState.at_rest(3.0),
        lambda: tr.FilterState([np.nan], [0.0], [0.0]),
        lambda: tr.FilterState([0.0], [0.0, 0.0], [0.0]),
        lambda: tr.FilterState([0.0], [0.0], np.inf),
        lambda: tr.LineState(*[[0.0]] * 6, "rest", BOUNDED, BOUNDED),
        lambda: tr.JerkFilter(1.0, 1.0, 0.0),
        lambda: tr.JerkFilter(1.0, 1.0, 1.0, -1.0),
        lambda: tr.JerkFilter(1.0, np.nan, 1.0),
        lambda: tr.JerkFilter(1.0, 1.0, 1.0, jerk_down=[[1.0]]),
        lambda: tr.JerkFilter(1.0, 1.0, [1.0, 1.0]).step(REST, [1.0], 0.1),
        lambda: BOUNDED.step(REST, [np.inf], 0.1),
        lambda: BOUNDED.step(REST, [1.0, 2.0], 0.1),
        lambda: BOUNDED.step(REST, [1e300], 0.1),
        lambda: BOUNDED.step(REST, [1.0], -0.1),
        lambda: BOUNDED.step("state", [1.0], 0.1),
        lambda: BOUNDED.step_together(None, [1.0], 0.1),
        lambda: BOUNDED.durations(REST, "there"),
        lambda: BOUNDED.resting_place(3.0),
        lambda: tr.JerkFilter([1.0, 2.0], [1.0, 2.0, 3.0], 1.0),
        lambda: tr.JerkFilter(1.0, 1.0, 1e300),
        lambda: tr.StraightFilter("limits"),
        lambda: tr.StraightFilter(BOUNDED).step(REST, [1.0], 0.1, velocity=[1.0, 2.0]),
        lambda: BOUNDED.step(REST, [1.0], 0.1, velocity=[np.nan]),
        lambda: tr.StraightFilter(BOUNDED).step(None, [1.0], 0.1),
        lambda: tr.point_to_point(ORIGIN, [], **RUCKIG),
        lambda: tr.point_to_point([], [], **RUCKIG),
        lambda: tr.point_to_point(ORIGIN, [1.0, 1.0], **RUCKIG),
        lambda: tr.point_to_point(ORIGIN, [1.0, np.nan, 0.0], **RUCKIG),
        lambda: tr.point_to_point(ORIGIN, ORIGIN, **RUCKIG),
        lambda: tr.point_to_point(ORIGIN, [1.0, 1.0, 1.0], **RUCKIG | {"jerk": 0.0}),
        lambda: tr.point_to_point(ORIGIN, [1.0, 1.0, 1.0], **RUCKIG | {"velocity": [1.0, 1.0]}),
        lambda: tr.point_to_point(ORIGIN, [1e9, 1.0, 1.0], **RUCKIG),
    ],
    "velocity": [lambda: tr.point_to_point([0.0], tr.State([1.0], [3.0]), **LIMITS)],
    "the last like the first": [lambda: tr.periodic_cubic(TIMES, np.arange(6.0))],
    "control_points": [lambda: tr.bspline_near(TIMES, SINES, control_points=3)],
    "weights": [lambda: tr.nurbs_through(TIMES, SINES, weights=-np.ones(6))],
    "times: expected steps of similar length": [
        lambda: tr.smooth(UNEVEN, SINES, continuity=4),
        lambda: tr.minimum_jerk_through(UNEVEN, SINES),
    ],
    "times": [lambda: tr.bspline_near(TIMES[::-1], SINES, control_points=5)],
    "law: .*domain": [lambda: tr.run_by(PATH, tr.trapezoid([0.0], [1.2], **LAW))],
    "law": [lambda: tr.run_by(PATH, tr.trapezoid([0.0, 0.0], [1.0, 1.0], **LAW))],
    r"pieces\[1\]: expected a curve from where and when": [
        lambda: tr.joined([PIECE, tr.Bezier([[1.0, 2.0], [2.0, 2.0]], (1.0, 2.0))])
    ],
    "pieces: expected at least one": [lambda: tr.joined([])],
    "points: expected 2 columns": [lambda: PIECE.continued([[1.0, 2.0, 3.0]], duration=1.0)],
    "along the line": [lambda: tr.double_s(ORIGIN[:2], WAY, **LIMITS, start_velocity=[1.0, 1.0])],
    "at most the limit": [lambda: tr.double_s(ORIGIN[:2], WAY, **LIMITS, end_velocity=2.0 * WAY)],
    r"expected a velocity \(2,\)": [
        lambda: tr.double_s(ORIGIN[:2], WAY, **LIMITS, end_velocity=1.0)
    ],
    "domain": [lambda: tr.PoseCurve(tr.natural_cubic(TIMES, SINES).rescaled(2.0), TURNED)],
    "3-D": [lambda: tr.PoseCurve(tr.linear(TIMES, SINES[:, :2]), TURNED)],
    "orientations": [lambda: tr.PoseCurve(tr.linear(TIMES, SINES), tr.linear(TIMES, SINES))],
}


@pytest.mark.parametrize(
    ("named", "wrong"), [(named, call) for named, calls in REFUSED.items() for call in calls]
)
def test_wrong_input_is_refused(named, wrong):
    refused(named, wrong)

"""Splines, Bezier pieces and B-splines are the same curves; knots change nothing."""

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from leadthrough import trajectories as tr
from leadthrough.errors import InvalidInput

RNG = np.random.default_rng(0)
TIMES = np.cumsum(RNG.uniform(0.5, 1.5, 20))
POINTS = RNG.normal(size=(20, 2))
FINE = np.linspace(TIMES[0], TIMES[-1], 401)


@pytest.mark.parametrize("continuity", [1, 2, 4])
def test_a_smooth_curve_through_points_is_a_chain_of_bezier_curves(continuity):
    curve = tr.smooth(TIMES, POINTS, continuity=continuity, ends="natural")
    pieces = tr.bezier_pieces(curve)
    chain = tr.joined(pieces)
    assert len(pieces) == 19
    assert (chain.smoothness(tolerance=1e-7) >= continuity + 1).all()
    np.testing.assert_allclose(chain.evaluate(TIMES), POINTS, atol=1e-9)
    np.testing.assert_allclose(chain.evaluate(FINE), curve.evaluate(FINE), atol=1e-9)
    # It stays near its points, and a chain continued from its start does not.
    assert np.abs([each.points for each in pieces]).max() < 20.0
    if continuity == 2:
        continued = [tr.Bezier(np.linspace(*POINTS[:2], 4), TIMES[:2])]
        for end, duration in zip(POINTS[2:], np.diff(TIMES)[1:], strict=True):
            continued.append(continued[-1].continued([end], duration=duration, continuity=2))
        assert np.abs(continued[-1].points).max() > 1e3 * np.abs(pieces[-1].points).max()


@pytest.mark.parametrize("degree", [1, 3, 5])
def test_a_b_spline_comes_back_from_its_pieces(degree):
    peer = make_interp_spline(TIMES, POINTS, k=degree)
    made = tr.BSpline(peer.c, peer.t, degree)
    again = tr.as_bspline(made.spline(), tolerance=1e-6)
    np.testing.assert_allclose(again.knot_vector, peer.t)
    np.testing.assert_allclose(again.points, peer.c, atol=1e-9 * np.abs(peer.c).max())
    chain = tr.joined(tr.bezier_pieces(made))
    np.testing.assert_allclose(chain.evaluate(FINE), peer(FINE), atol=1e-9 * np.abs(peer.c).max())


def test_less_smooth_knots_stand_more_often():
    first = tr.Bezier([[0, 0], [1, 2], [2, 0]])
    chain = tr.joined([first, first.continued([[4, 1]], duration=2.0, continuity=1)])
    corner = tr.joined([first, tr.Bezier([[2, 0], [2, 1], [0, 0]], (1.0, 2.0))])
    for path, times in ((chain, 1), (corner, 2)):
        made = tr.as_bspline(path)
        assert (made.knot_vector == 1.0).sum() == times
        at = np.linspace(*path.domain, 101)
        np.testing.assert_allclose(made.evaluate(at), path.evaluate(at), atol=1e-13)


def test_a_knot_more_changes_nothing_but_the_control_points():
    peer = make_interp_spline(TIMES, POINTS, k=3)
    made = tr.BSpline(peer.c, peer.t, 3)
    for time in (TIMES[4], TIMES[4], 0.5 * (TIMES[0] + TIMES[1]), 0.5 * (TIMES[-2] + TIMES[-1])):
        more = tr.with_knot(made, time)
        truth = peer.insert_knot(time)
        peer, made = truth, more
        np.testing.assert_allclose(more.knot_vector, truth.t)
        np.testing.assert_allclose(more.points, truth.c, atol=1e-12)
    with pytest.raises(InvalidInput, match="time"):
        tr.with_knot(made, TIMES[4])


def test_other_curves_are_refused():
    for call in (tr.bezier_pieces, tr.as_bspline):
        with pytest.raises(InvalidInput, match="spline"):
            call(tr.Bezier([[0.0], [1.0]]))

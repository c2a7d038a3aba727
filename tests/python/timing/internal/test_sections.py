"""Sections of a path, cut where the motion rests, and the verification of what is made of them."""

import numpy as np
import pytest
from motions import minimum_jerk
from scipy.interpolate import CubicSpline, PchipInterpolator

import leadthrough as lt
from leadthrough.arm import JointLimits
from leadthrough.errors import LimitsInfeasible
from leadthrough.timing import retiming
from leadthrough.timing.section_law import Samples
from leadthrough.timing.sections import Section, fit_within, moving_samples, through
from leadthrough.trajectories import Spline


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_section_is_cut_where_it_moves_whichever_way(side):
    spline = Spline([0.0, 1.0, 2.0], side * np.array([[[0.0], [1.0]], [[1.0], [1.0]]]))
    parts = Section(spline, np.arange(3), spline.knots).cut_at(np.array([0.5, 1.5]))
    assert [part.spline.domain for part in parts] == [(0.0, 0.5), (0.0, 1.0), (0.0, 0.5)]
    ends = [part.spline.evaluate(part.spline.domain[1])[0] for part in parts]
    np.testing.assert_allclose(ends, side * np.array([0.5, 1.5, 2.0]), atol=1e-15)


def test_parts_keep_the_rows_near_them_and_interpolate_as_the_whole():
    q = np.random.default_rng(1).normal(size=(200, 2)).cumsum(axis=0)
    whole = Section(through(np.arange(200.0), q), np.arange(200), np.arange(200.0))
    cuts = np.linspace(1.5, 197.5, 50)
    clock = PchipInterpolator(whole.parameters, np.arange(200.0) ** 2)
    parts = whole.cut_at(cuts)
    assert sum(len(part.rows) for part in parts) < 2.1 * 200 + 50 * 4
    for part, begin in zip(parts, [0.0, *cuts], strict=True):
        inside = np.linspace(*part.spline.domain, 20)
        own = PchipInterpolator(part.parameters, part.rows.astype(float) ** 2)
        np.testing.assert_allclose(own(inside), clock(begin + inside), rtol=1e-12, atol=1e-9)


def test_a_violation_raises_instead_of_being_returned(monkeypatch):
    wrong = Samples(*(np.arange(9.0), np.arange(9.0)), *(np.eye(9, 2),) * 3)
    monkeypatch.setattr(retiming, "time_lines", lambda *_: wrong)
    limits = JointLimits(("j0", "j1"), [-9, -9], [9, 9], [0.1, 0.1], [2, 2], [20, 20])
    with pytest.raises(LimitsInfeasible, match="no motion was found that satisfies the limits: j"):
        lt.retime([[0.0, 0.0], [1.0, 1.0]], limits)


def test_reaches_between_rests_are_a_few_pieces_over_their_own_times():
    """Each of 20,000 samples was a piece, as the clock that skips slow parts has corners there."""
    u = np.linspace(0.0, 10.0, 20_001)
    from_rest = minimum_jerk(u % 1.0)
    ends = np.random.default_rng(0).uniform(-0.4, 0.4, (12, 7))
    first = u.astype(int)
    q = ends[first] + from_rest[:, None] * (ends[first + 1] - ends[first])
    kept, times = moving_samples(2.0 * u, q, 5e-6, timed=True)
    spline = fit_within(times, q[kept], 5e-6, corners=False)
    assert len(spline.knots) < 500
    np.testing.assert_allclose(spline.evaluate(times), q[kept], atol=5e-6)


@pytest.mark.parametrize("count", [2, 3, 4, 12, 100])
def test_cubics_through_all_samples_are_scipy_s(count):
    rng = np.random.default_rng(3)
    times, q = np.cumsum(rng.uniform(0.01, 1.0, count)), rng.normal(size=(count, 3))
    theirs = CubicSpline(times, q, bc_type="not-a-knot" if count > 2 else "natural")
    ours = through(times, q).coefficients
    expected = theirs.c[::-1].transpose(1, 0, 2)
    if count > 3:  # to the bit: motions along them are the same as before
        np.testing.assert_array_equal(ours, expected)
    np.testing.assert_allclose(ours, expected, atol=1e-10 * np.abs(expected).max())

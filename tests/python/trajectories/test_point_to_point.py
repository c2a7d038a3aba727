"""Point-to-point motion by ruckig."""

import sys

import numpy as np
import pytest

from leadthrough import trajectories as tr
from leadthrough.errors import InvalidInput, MissingDependency

LIMITS = {"velocity": [1.0, 2.0, 0.5], "acceleration": 3.0, "jerk": 20.0}


def test_it_meets_both_states_and_keeps_the_limits():
    pytest.importorskip("ruckig")
    rng = np.random.default_rng(0)
    for _ in range(50):
        start = tr.State(rng.normal(size=3), rng.uniform(-0.4, 0.4, 3), rng.uniform(-1, 1, 3))
        end = tr.State(rng.normal(size=3), rng.uniform(-0.4, 0.4, 3))
        curve = tr.point_to_point(start, end, **LIMITS)
        for time, wanted in zip(curve.domain, (start, end), strict=True):
            np.testing.assert_allclose(curve.evaluate(time), wanted.position, atol=1e-8)
            np.testing.assert_allclose(curve.evaluate(time, 1), wanted.velocity, atol=1e-8)
            rate = np.broadcast_to(wanted.acceleration, 3)
            np.testing.assert_allclose(curve.evaluate(time, 2), rate, atol=1e-8)
        t = np.linspace(*curve.domain, 500)
        for order, limit in enumerate(([1.0, 2.0, 0.5], 3.0, 20.0), 1):
            assert (np.abs(curve.evaluate(t, order)) <= np.array(limit) + 1e-6).all()
        assert (curve.smoothness(tolerance=1e-6) >= 3).all()


def test_from_rest_to_rest_it_is_the_double_s():
    pytest.importorskip("ruckig")
    limits = {"velocity": 1.0, "acceleration": 2.0, "jerk": 10.0}
    for length in (0.01, 0.5, 3.0):
        found = tr.point_to_point([0.0], [length], **limits)
        assert found.domain[1] == pytest.approx(tr.double_s([0.0], [length], **limits).domain[1])


@pytest.mark.parametrize(
    ("start", "end", "change"),
    [
        ([0.0, 0.0, 0.0], [], {}),
        ([], [], {}),
        ([0.0, 0.0, 0.0], [1.0, 1.0], {}),
        ([0.0, 0.0, 0.0], [1.0, np.nan, 0.0], {}),
        ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0], {}),
        ([0.0, 0.0, 0.0], [1.0, 1.0, 1.0], {"jerk": 0.0}),
        ([0.0, 0.0, 0.0], [1.0, 1.0, 1.0], {"velocity": [1.0, 1.0]}),
        ([0.0, 0.0, 0.0], [1e9, 1.0, 1.0], {}),
    ],
)
def test_input_that_crashes_ruckig_is_refused(start, end, change):
    with pytest.raises(InvalidInput):
        tr.point_to_point(start, end, **{**LIMITS, **change})


def test_a_final_velocity_above_the_limit_is_refused():
    pytest.importorskip("ruckig")
    with pytest.raises(InvalidInput, match="velocity"):
        tr.point_to_point([0.0], tr.State([1.0], [3.0]), velocity=1.0, acceleration=2.0, jerk=10.0)


def test_without_ruckig_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "ruckig", None)
    with pytest.raises(MissingDependency, match=r"leadthrough\[ruckig\]"):
        tr.point_to_point([0.0], [1.0], velocity=1.0, acceleration=1.0, jerk=1.0)

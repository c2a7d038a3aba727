"""Sections of a path, cut where the motion rests, and the verification of what is made of them."""

import numpy as np
import pytest

import leadthrough as lt
from leadthrough.arm.limits import JointLimits
from leadthrough.errors import LimitsInfeasible
from leadthrough.timing import retiming
from leadthrough.timing.samples import Samples
from leadthrough.timing.sections import Section
from leadthrough.trajectories import Spline


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_section_is_cut_where_it_moves_whichever_way(side):
    spline = Spline([0.0, 1.0, 2.0], side * np.array([[[0.0], [1.0]], [[1.0], [1.0]]]))
    parts = Section(spline, np.arange(3), spline.knots).cut_at(np.array([0.5, 1.5]))
    assert [part.spline.domain for part in parts] == [(0.0, 0.5), (0.0, 1.0), (0.0, 0.5)]
    ends = [part.spline.evaluate(part.spline.domain[1])[0] for part in parts]
    np.testing.assert_allclose(ends, side * np.array([0.5, 1.5, 2.0]), atol=1e-15)


def test_a_violation_raises_instead_of_being_returned(monkeypatch):
    wrong = Samples(*(np.arange(9.0), np.arange(9.0)), *(np.eye(9, 2),) * 3)
    monkeypatch.setattr(retiming, "time_lines", lambda *_: wrong)
    limits = JointLimits(("j0", "j1"), [-9, -9], [9, 9], [0.1, 0.1], [2, 2], [20, 20])
    with pytest.raises(LimitsInfeasible, match="no motion was found that satisfies the limits: j"):
        lt.retime([[0.0, 0.0], [1.0, 1.0]], limits)

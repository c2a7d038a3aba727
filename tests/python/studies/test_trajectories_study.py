"""The statements of the lecture notes hold."""

import pytest

from leadthrough_studies.catalogue import STUDIES
from leadthrough_studies.study import run
from leadthrough_studies.trajectories.study import TrajectoriesConfig


@pytest.fixture(scope="module")
def outcome(tmp_path_factory):
    out = tmp_path_factory.mktemp("trajectories")
    config = TrajectoriesConfig(nodes=(9, 33), splines=2)
    return run(STUDIES["trajectories"], config, out=out), out


@pytest.fixture(scope="module")
def values(outcome):
    return {(line["what"], line["measure"]): line["value"] for line in outcome[0].report.table}


def test_all_tasks_succeed_and_figures_are_drawn(outcome):
    result, out = outcome
    assert not result.failures
    assert (out / "runge.png").stat().st_size > 1000
    assert (out / "phase_plane.png").stat().st_size > 1000


def test_only_evenly_spaced_nodes_fail_on_runges_function(values):
    assert values["33 even nodes", "error"] > 100.0 * values["9 even nodes", "error"]
    assert values["33 chebyshev nodes", "error"] < 0.1 * values["9 chebyshev nodes", "error"]


def test_euler_angles_turn_about_a_straying_axis(values):
    assert values["slerp", "axis_strays_rad"] < 1e-6
    assert values["Euler angles", "axis_strays_rad"] == pytest.approx(3.14159265 / 3, abs=1e-2)


def test_the_sampled_filter_neither_chatters_nor_overshoots(values):
    assert values["bang-bang", "switches_in_the_last_second"] > 20
    assert values["bang-bang", "overshoot"] > 0.0
    assert values["filter", "switches_in_the_last_second"] == 0
    assert values["filter", "overshoot"] == 0.0


def test_minimum_jerk_has_the_smallest_jerk(values):
    costs = {what: value for (what, measure), value in values.items() if measure == "jerk"}
    assert min(costs, key=costs.get) == "minimum jerk"


def test_retimed_splines_keep_their_limits(values):
    shares = [
        value for (_, measure), value in values.items() if measure == "share_inside_all_limits"
    ]
    assert shares == [1.0, 1.0, 1.0]

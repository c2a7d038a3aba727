"""The statements of the lecture notes hold."""

import numpy as np
import pytest
from sklearn.cluster import KMeans

from leadthrough_studies.catalogue import STUDIES
from leadthrough_studies.study import run
from leadthrough_studies.trajectories import generalization
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
    for figure in ("2_1", "3_1", "4_1", "4_2", "4_3", "4_4"):
        assert (out / f"figure_{figure}.png").stat().st_size > 1000


def test_only_evenly_spaced_nodes_fail_on_runges_function(values):
    assert values["33 even nodes", "error"] > 100.0 * values["9 even nodes", "error"]
    assert values["33 chebyshev nodes", "error"] < 0.1 * values["9 chebyshev nodes", "error"]


def test_the_function_as_printed_converges_by_either_basis(values):
    assert values["33 nodes", "printed_error"] < 0.01 * values["9 nodes", "printed_error"]
    assert values["33 nodes", "condition"] > 1e9 > values["33 nodes", "basis_condition"]
    assert values["33 nodes", "difference"] < 1e-9


def test_a_spline_has_as_much_freedom_as_continuous_derivatives(values):
    assert [values[f"C{order}", "left"] for order in (1, 2, 3, 4)] == [1, 2, 3, 4]


def test_minimum_jerk_is_a_bezier_curve_of_six_points(values):
    assert values["minimum jerk", "points"] == 6
    assert values["minimum jerk", "difference"] < 1e-10


def test_weights_that_are_fitted_alone_do_not_minimise_the_error_of_the_force(values):
    for measure in ("force_error", "replay_error"):
        alone = values["printed widths, each alone", f"{measure}_low"]
        assert alone > 5.0 * values["printed widths, together", f"{measure}_high"]


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


def test_k_means_and_em_never_lose_what_they_have_gained(values, outcome):
    assert values["random points", "largest_rise"] <= 0.0
    assert values["EM", "least_gain"] > -1e-9
    assert values["EM", "least_ratio"] > 0.9  # the notes would stop below 0.01
    assert values["plus_plus", "first_inertia"] < values["random", "first_inertia"]
    steps = [row for row in outcome[0].rows if row["study"] == "k-means"]
    assert steps[-1]["changed"] == 0
    # scikit-learn from the same points comes to the same clusters.
    points = generalization._scaled(generalization.demonstrations(0))
    first = np.array(steps[0]["centres"])
    peer = KMeans(len(first), init=first, n_init=1, tol=0.0).fit(points)
    assert steps[-1]["inertia"] == pytest.approx(peer.inertia_, rel=1e-9)


def test_regression_follows_the_demonstrations_mean(values):
    assert values["weighted Gaussians", "error_m"] < 0.01  # of 0.3 m
    assert values["GMR", "error_m"] < 0.03

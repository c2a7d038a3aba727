"""The singularity study, with a short sweep."""

import json

import numpy as np
import pytest

from leadthrough.arm import Arm
from leadthrough_studies.damped_least_squares import DampedLeastSquares, follow_path
from leadthrough_studies.singularity.by_ranges import follow_by_ranges
from leadthrough_studies.singularity.paths import (
    APPROACHES,
    DEVIATION,
    METHODS,
    motion,
    slowest_direction,
    start,
)
from leadthrough_studies.singularity.study import STUDY
from leadthrough_studies.study import run, selected

CONFIG = STUDY.configure(quick=True, seed=0)
PANDA = Arm.load("panda")
NUMBERS = pytest.mark.parametrize("number", APPROACHES)


@pytest.fixture(scope="module")
def outcome(tmp_path_factory):
    out = tmp_path_factory.mktemp("singularity")
    return run(STUDY, CONFIG, out=out), out


@pytest.fixture(scope="module")
def rows(outcome):
    assert not outcome[0].failures
    own = selected(outcome[0].rows, study="approach")
    return {(row["approach"], row["method"]): row for row in own}


def test_every_approach_is_made_by_every_method(rows):
    assert set(rows) == {(number, method) for number in APPROACHES for method in METHODS}


@NUMBERS
def test_the_way_leads_through_the_posture(number):
    approach = APPROACHES[number]
    way = motion(PANDA, approach)
    position, orientation = PANDA.forward_kinematics(np.array(approach.posture))
    near = np.linalg.norm(way.positions - position, axis=1).argmin()
    assert 0.6 < way.times[near] / way.times[-1] < 0.75  # three quarters of the way, not of time
    assert np.linalg.norm(way.positions[near] - position) < 2e-3
    assert abs(way.orientations[near] @ orientation) > 0.9999


@NUMBERS
def test_the_way_takes_the_direction_that_costs_the_joints_most(number):
    q = np.array(APPROACHES[number].posture)
    weights = np.repeat([1.0, 0.3], 3)
    weighted = weights[:, None] * PANDA.jacobian(q)
    direction = weights * slowest_direction(PANDA, q)
    assert np.linalg.norm(direction) == pytest.approx(1.0)
    cost = np.linalg.norm(np.linalg.pinv(weighted) @ direction)
    assert cost == pytest.approx(1.0 / np.linalg.svd(weighted)[1][-1])


def test_damping_lowers_the_peak_of_the_speed(rows):
    for number in APPROACHES:
        plain, damped = (
            rows[number, method]["peak_share_of_velocity_limit"] for method in ("plain", "damped")
        )
        assert damped < plain


def test_the_plain_inverse_breaks_limits_where_follow_keeps_them(rows):
    assert rows[2, "plain"]["peak_share_of_velocity_limit"] > 1.2
    for number in APPROACHES:
        for method in ("follow, slowing", "follow, deviating"):
            # Central differences of positions whose steps keep the limit.
            assert rows[number, method]["peak_share_of_velocity_limit"] <= 1.0 + 1e-6


def test_slowing_keeps_to_the_path_and_deviating_to_the_time(rows):
    for number in APPROACHES:
        slowing, deviating = (rows[number, f"follow, {how}"] for how in ("slowing", "deviating"))
        assert slowing["largest_error_m"] < 1e-5
        assert slowing["duration_s"] >= 4.0 - 1e-9
        assert deviating["largest_error_m"] <= DEVIATION[0]
        assert deviating["duration_s"] == pytest.approx(4.0)


def test_more_damping_leaves_more_of_the_path(outcome):
    own = selected(outcome[0].rows, study="sweep", approach=2, alpha=0.0, nullspace_gain=0.0)
    errors = [row["largest_error_m"] for row in sorted(own, key=lambda row: row["damping"])]
    assert errors == sorted(errors)


@NUMBERS
def test_without_scaling_the_steps_are_those_of_the_arm_and_with_it_joints_keep_to_their_middle(
    number,
):
    way = motion(PANDA, APPROACHES[number])
    q = start(PANDA, APPROACHES[number], way)
    settings = DampedLeastSquares()
    plain = follow_path(PANDA, way, q0=q, settings=settings).joints.positions
    same, scaled = (
        follow_by_ranges(PANDA, way, q, settings, scaled=each).positions for each in (False, True)
    )
    np.testing.assert_allclose(same, plain, atol=1e-8)
    lower, upper = PANDA.limits.lower, PANDA.limits.upper
    strays = [
        np.sum(((path - 0.5 * (lower + upper)) / (upper - lower)) ** 2, axis=1).mean()
        for path in (scaled, same)
    ]
    assert strays[0] < strays[1]


def test_tables_one_and_two_stand_beside_the_papers(outcome):
    lines = outcome[0].report.summary["tables_1_and_2"]
    assert len(lines) == 8
    told = {(line["table"], line["method"], line["below"]): line for line in lines}
    assert told["I", "damped", 10]["paper_percent"] == 83.0
    assert told["II", "plain", 10]["paper_percent"] == 72.0


def test_the_table_quotes_the_paper(outcome):
    table = {(row["approach"], row["method"]): row for row in outcome[0].report.table}
    assert table[1, "damped"]["paper_below_8_percent"] == 20.0
    assert table[1, "plain"]["paper_peak_velocity_7"] == -1.0
    assert table[2, "follow, slowing"]["paper_below_8_percent"] is None


def test_results_and_figures_are_written(outcome):
    out = outcome[1]
    document = json.loads((out / "results.json").read_text())
    assert len(document["table"]) == len(APPROACHES) * len(METHODS)
    for name in ("approach_1", "approach_2", "condition", "sweep"):
        assert (out / f"{name}.png").stat().st_size > 10_000

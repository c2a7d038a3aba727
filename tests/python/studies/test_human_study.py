"""Human against damped-least-squares demonstrations, learned by ProMPs; a short sweep."""

import json

import numpy as np
import pytest
from motions import minimum_jerk

import leadthrough as lt
from leadthrough.arm import Arm
from leadthrough_studies.human.demonstrations import GOAL, START
from leadthrough_studies.human.measures import bell_distance, fidelity, reversals, sign_changes
from leadthrough_studies.human.recordings import execution, symbol
from leadthrough_studies.human.report import CLAIMS
from leadthrough_studies.human.study import SOURCES, STUDY, WAYS, HumanConfig, tasks
from leadthrough_studies.study import run, selected

CONFIG = HumanConfig(
    demonstrations=4, swept_weights=(6, 20), swept_widths=(0.35, 1.0), seeds=2, seed=1
)
U = np.linspace(0.0, 1.0, 201)
BELL = 16.0 * U**2 * (1.0 - U) ** 2


@pytest.fixture(scope="module")
def outcome(tmp_path_factory):
    out = tmp_path_factory.mktemp("human")
    return run(STUDY, CONFIG, out=out), out


@pytest.fixture(scope="module")
def rows(outcome):
    assert not outcome[0].failures
    return outcome[0].rows


def learned(rows, source, way):
    return selected(rows, study="learning", source=source, learned_from=way)


def test_every_source_is_learned_in_every_way_and_compared_with_the_claim(rows, outcome):
    for source in SOURCES:
        for way in WAYS:
            assert [row["column"] for row in learned(rows, source, way)] == [
                f"joint {joint}" for joint in (1, 3, 5)
            ]
    table = outcome[0].report.table
    assert {row["paper"] for row in table} == set(CLAIMS.values())


def test_both_sources_reach_the_same_place():
    arm = Arm.load("panda")
    wanted, _ = arm.forward_kinematics(GOAL)
    for source, tolerance in (("human", 0.1), ("DLS-IK", 1e-3)):
        first = SOURCES[source](1, 0)[0].motion
        np.testing.assert_allclose(first.positions[0], START, atol=0.01)
        reached, _ = arm.forward_kinematics(first.positions[-1])
        assert np.linalg.norm(reached - wanted) < tolerance


def test_averaging_loses_the_peaks_of_people_but_not_of_damped_least_squares(rows):
    human, damped = (learned(rows, source, "all") for source in SOURCES)
    assert np.mean([row["peak_ratio"] for row in human]) < 0.85
    for row in damped:
        assert row["peak_ratio"] == pytest.approx(1.0, abs=0.05)
        assert row["reversals_learned"] <= 2.0
    for a, b in zip(human, damped, strict=True):
        assert a["sign_changes_shown"] > 10 * b["sign_changes_shown"]


def test_narrow_basis_functions_overshoot_and_oscillate_for_either_source(rows):
    swept = selected(rows, study="sweep", weights=20)
    for narrow, wide in zip(selected(swept, width=0.35), selected(swept, width=1.0), strict=True):
        assert narrow["peak_ratio"] > 1.2
        assert wide["peak_ratio"] < 1.05
        assert narrow["reversals_learned"] > 3 * wide["reversals_learned"]


def test_the_bell_comes_from_the_time_law(rows):
    own = selected(rows, study="time laws", weights=20, column="joint 3")
    far = {row["law"]: row["bell_distance_learned"] for row in own}
    assert far["line, minimum jerk"] < 0.15
    for law in ("joints interpolated", "line, constant speed", "line, servo"):
        assert far[law] > 0.4


def test_measures_of_a_bell_and_of_constant_speed():
    assert bell_distance(U, -0.3 * BELL) == pytest.approx(0.0, abs=1e-12)
    assert bell_distance(U, np.ones(201)) == pytest.approx(0.58, abs=0.01)
    assert sign_changes(BELL) == reversals(BELL) == 1
    trembling = BELL + 0.01 * np.sin(60 * np.pi * U)
    assert sign_changes(trembling) > 10
    assert reversals(trembling) == 1
    assert reversals(BELL * np.sin(6 * np.pi * U)) == 6


def test_learned_velocity_of_a_quicker_motion_is_larger():
    curve = np.column_stack([minimum_jerk(U), U])
    slow, fast = (lt.JointTrajectory(duration * U, curve) for duration in (4.0, 1.0))
    skill = lt.ProMP().fit([lt.Demonstration(slow)])
    for motion in (slow, fast):
        assert fidelity(skill, [motion], 0)["peak_ratio"] == pytest.approx(1.0, abs=0.01)


def test_recorded_motions_of_an_arm_are_measured(recordings):
    rows = execution(
        source="trial1",
        file=recordings / "panda_execution" / "trial1.csv",
        joints=[1, 3, 5],
        weights=20,
    )
    assert {row["column"] for row in rows} == {"joint 1", "joint 3", "joint 5"}
    assert len(rows) > 10


def test_aligning_a_recorded_symbol_restores_its_peaks(recordings):
    rows = symbol(source="symbol17", file=recordings / "panda_symbol" / "symbol17.mat", weights=20)
    ratios = {(row["learned_from"], row["column"]): row["peak_ratio"] for row in rows}
    for column in "xy":
        assert ratios["all", column] < 0.7
        assert ratios["all, aligned", column] > 0.85


def test_a_folder_of_recordings_adds_tasks(recordings):
    config = HumanConfig(recordings=str(recordings))
    assert len(tasks(config)) == len(tasks(HumanConfig())) + 3


def test_results_and_figures_are_written(outcome):
    out = outcome[1]
    document = json.loads((out / "results.json").read_text())
    assert "time law" in document["summary"]["explained"]
    for name in ("joint_1", "joint_3", "joint_5", "sweep", "time_laws"):
        assert (out / f"{name}.png").stat().st_size > 10_000

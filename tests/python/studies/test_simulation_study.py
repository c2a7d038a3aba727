"""Motions of the studies in simulation: sound ones are fit to run, and every fault is found."""

import pytest

from leadthrough.errors import NoPath
from leadthrough_studies.simulation import motions
from leadthrough_studies.simulation.motions import given
from leadthrough_studies.simulation.study import SETTINGS, STUDY, SimulationConfig
from leadthrough_studies.study import selected

MOTIONS = {"reaches of a Panda": 1, "reaches of a UR3": 1}
CONFIG = SimulationConfig(MOTIONS, dampings=(0.1,), people=1)


@pytest.fixture(scope="module")
def rows():
    return [row for task in STUDY.tasks(CONFIG) for row in task.function(**task.arguments)]


@pytest.fixture(scope="module")
def report(rows):
    return STUDY.report(CONFIG, rows)


def test_sound_motions_are_fit_to_run_and_off_by_what_theory_says(rows):
    sound = selected(rows, study="sound")
    assert len(sound) == len(SETTINGS) * len(MOTIONS)
    for row in sound:
        assert row["fit_to_run"], row["findings"]
        assert row["torque_percent"] <= 100.0
        assert row["of_allowed"] <= 1.0
        if row["setting"] != "computed torque, ideal arm":
            assert 0.7 < row["joint_error_mrad"] / row["expected_mrad"] < 1.3


def test_every_fault_is_found(rows, report):
    faults = selected(rows, study="fault", is_one=1)
    assert {row["fault"] for row in faults} == {row["what"] for row in report.table[4:]}
    assert all(row["found"] for row in faults)


def test_conditioning_and_naturalness_are_compared(report):
    summary = report.summary
    assert {row["approach"] for row in summary["conditioning"]} == {1, 2}
    assert {row["learned"] for row in summary["naturalness"]} == {0, 1}
    assert set(report.figures) == {"errors", "conditioning", "naturalness"}
    assert "fit to run" in "".join(report.pages["simulated"])


def test_a_motion_that_there_is_none_of_gives_its_reason(monkeypatch):
    def none(index, seed):
        raise NoPath("there is none", reason="drawn")

    monkeypatch.setitem(motions.SOURCES, "none", none)
    assert given("none", 0, 0) == "there is none"

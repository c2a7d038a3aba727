"""The comparison of all models, on one motion and on poses made by hand."""

from dataclasses import replace

import numpy as np
import pytest

import leadthrough as lt
from leadthrough import rotations
from leadthrough.models import LPVDS
from leadthrough_studies.comparison import STUDY, measures, methods, on_arms, study
from leadthrough_studies.study import run, selected

U = np.linspace(0.0, 1.0, 1000)
FEW = ("FastMarching", "ProMP", "LPV-DS", "FSM-DM", "nearest demonstration, shifted")


def recorded(offset):
    """Positions in cm along a bow that starts at an offset, and a turn about the vertical."""
    positions = np.column_stack([30.0 + 20.0 * U, offset * (1 - U), 30.0 + 5 * np.sin(np.pi * U)])
    down = np.tile([0.0, 1.0, 0.0, 0.0], (len(U), 1))
    turned = rotations.compose(rotations.exp(np.outer(U, [0.0, 0.0, 0.8])), down)
    return np.hstack([positions, turned])


def test_all_parts_are_in_the_report_and_a_second_start_has_nothing_left_to_do(tmp_path):
    file = tmp_path / "bow.npy"
    np.save(file, np.stack([recorded(x) for x in (-4.0, 0.0, 4.0)]))
    config = study.ComparisonConfig(
        ("Angle",),
        FEW,
        courses=(("reach over a box", ""),),
        motions_of_poses=(("bow", str(file)),),
        poses=FEW,
        left_out=1,
        folds=0,
        starts=50,
    )
    outcome = run(STUDY, config, out=tmp_path / "out")
    assert not outcome.failures
    table = outcome.report.table
    assert {row["part"] for row in table} == {"IN", "LOO", "bow", "reach over a box"}
    assert len(table) == 4 * len(FEW)
    for row in table:
        assert row["panda_executed"] == row["panda_reachable"] == row["panda_clear"] == 1
        assert row["goal_end_mm"] < 1e-3
    for row in selected(table, part="LOO"):
        assert row["SEA_mm2"] < 1000.0
        assert row["end_mm"] < 1e-6
        assert row["push_Frechet_mm"] > 0.0
    printed = {line["method"]: line for line in outcome.report.summary["table_2"]}
    assert printed["SEDS"]["SEA_printed"] == 8.18e5
    assert printed["FSM-DM"]["SEA_mm2"] == selected(table, part="IN", method="FSM-DM")[0]["SEA_mm2"]
    (shown_stable, *_) = outcome.report.summary["stability"]
    assert shown_stable["arrived"] == shown_stable["starts"] == 50
    assert set(outcome.report.figures) >= {"figure_16", "figure_17", "figure_18", "stability"}
    assert selected(table, part="LOO", method="LPV-DS")[0]["violations"] == 0
    shown = (tmp_path / "out" / "comparison.html").read_text()
    assert all(text in shown for text in ("Table 2", "Handwriting, left out", "Angle", "FSM-DM"))
    again = run(STUDY, replace(config), out=tmp_path / "out")
    assert again.rows == outcome.rows


def test_inner_cross_validation_takes_the_model_that_predicts_left_out_demonstrations():
    class Guess:
        def __init__(self, value):
            self.value = value

        def fit(self, shown):
            return self.value + 0 * len(shown)

    def error(skill, left_out):
        return abs(skill - sum(left_out))

    models = [Guess(1.0), Guess(2.0), Guess(5.0)]
    assert methods.chosen(models, [2.0, 2.0, 2.0], error, folds=2).value == 2.0
    assert methods.chosen(models, [5.0] * 3, error, folds=3).value == 5.0
    assert methods.chosen(models, [5.0] * 3, error, folds=0).value == 2.0


def test_arm_refuses_what_it_cannot_reach_and_tells_how_much_slower_it_is():
    t = np.linspace(0.0, 1.0, 50)
    made = lt.Trajectory(t, np.outer(t**2 * (3 - 2 * t), [40.0, 20.0]))
    row = on_arms.on_arm("panda", on_arms.on_paper("panda", made))
    assert row["executed"] == 1
    assert row["slower"] >= 1.0
    assert row["begins_at"] < 0.2
    far = replace(made, positions=20.0 * made.positions)
    assert on_arms.on_arm("panda", on_arms.on_paper("panda", far))["executed"] == 0


def test_direction_error_is_small_for_the_system_that_made_the_motion():
    skill = LPVDS(components=3).fit(lt.io.lasa.load("Angle"))
    made = skill.generate(duration=skill.generate().duration * skill.pace, dt=0.005)
    whole = measures.direction_error(skill, made)
    assert whole < 0.15  # how it comes to rest at the goal is not the system's own
    assert measures.direction_error(skill, made, slowest=0.2) < whole
    assert measures.direction_error(skill, made, smoothing=1.0) == pytest.approx(whole, rel=0.2)
    backwards = lt.Trajectory(made.times, made.positions[::-1])
    assert measures.direction_error(skill, backwards) > 1.0

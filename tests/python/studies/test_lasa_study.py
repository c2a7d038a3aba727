"""The handwriting study's protocols and figures, against cases made by hand."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest

import leadthrough as lt
from leadthrough_studies.lasa import study
from leadthrough_studies.lasa.methods import (
    METHODS,
    SYSTEMS,
    nearest_shifted,
    paper_setting,
    system,
)
from leadthrough_studies.lasa.report import ranking
from leadthrough_studies.study import run, selected

TIMES = np.linspace(0.0, 1.0, 5)


def line(offset, name=""):
    positions = np.column_stack([np.linspace(-4.0, 0.0, 5), np.full(5, offset)])
    return lt.Demonstration(lt.Trajectory(TIMES, positions), name=name)


def splits(count, shown, seed=0):
    demonstrations = [line(float(i), name=str(i)) for i in range(count)]
    sets = study.splits(demonstrations, shown, np.random.default_rng(seed))
    return [([each.name for each in chosen], tested) for chosen, tested in sets]


def test_all_demonstrations_are_learned_when_the_tested_one_is_left_in():
    for names, _ in splits(7, 7):
        assert names == list("0123456")


def test_six_others_are_learned_when_one_is_left_out():
    for i, (names, tested) in enumerate(splits(7, 6)):
        assert names == [str(j) for j in range(7) if j != i]
        assert tested.positions[0, 1] == i


@pytest.mark.parametrize("shown", [1, 3])
def test_the_seed_chooses_a_few_of_the_others(shown):
    drawn = [names for names, _ in splits(7, shown, seed=3)]
    for i, names in enumerate(drawn):
        assert len(set(names)) == shown
        assert str(i) not in names
        assert names == sorted(names)
    assert drawn == [names for names, _ in splits(7, shown, seed=3)]
    assert drawn != [names for names, _ in splits(7, shown, seed=4)]


def test_nearest_demonstration_is_shifted_to_the_start_and_keeps_its_end():
    start = np.array([-4.0, 1.25])
    made = nearest_shifted([line(0.0), line(1.0), line(3.0)], start)
    np.testing.assert_allclose(made.positions[:, 1], 1.0 + 0.25 * np.linspace(1.0, 0.0, 5))
    np.testing.assert_array_equal(made.times, TIMES)


def test_error_columns_of_a_line_beside_a_line():
    row = study.error_columns(line(0.0).motion, line(1.0).motion)
    assert row["SEA_mm2"] == pytest.approx(4.0)
    assert row["V_rmse_mm_s"] == pytest.approx(0.0, abs=1e-12)
    assert row["DTWD_per_N_mm"] == pytest.approx(1.0)
    assert row["Frechet_mm"] == pytest.approx(1.0)
    assert row["end_error_mm"] == 1.0
    assert (row["length_mm"], row["duration_s"]) == (4.0, 1.0)


def test_paper_setting_is_in_pixels():
    model = paper_setting()
    assert model.area_of_influence / model.resolution == pytest.approx(25.0)
    assert model.saturation == 0.1


def test_travel_time_is_the_length_over_the_speed():
    skill = lt.FastMarching(saturation=1.0).fit([line(0.0)])
    path = np.array([[-4.0, 0.0], [-1.0, 0.0], [0.0, 0.0], [100.0, 0.0]])
    assert study.travel_time(skill, path, 0.5) == pytest.approx(4.0 + 200.0)


@pytest.fixture(scope="module")
def outcome(tmp_path_factory):
    config = study.LasaConfig(
        ("Line", "Worm"),
        methods=("FML", "nearest demonstration, shifted"),
        protocols=("IN", "LOO"),
        saturations=(0.1, 1.0),
        systems=("FSM-DM", "Modified DS"),
        settings=("FML",),
    )
    out = tmp_path_factory.mktemp("lasa")
    return config, run(study.STUDY, config, out=out), out


def test_every_motion_is_tested_seven_times_a_method_and_protocol(outcome):
    _, found, _ = outcome
    assert not found.failures
    counts = [row["n"] for row in found.report.table if row["protocol"] in ("IN", "LOO")]
    assert counts == [14] * 6


def test_systems_learn_from_all_demonstrations_and_are_told_beside_the_paper(outcome):
    table = outcome[1].report.table
    for name in ("FSM-DM", "Modified DS"):
        (line,) = selected(table, protocol="IN", method=name)
        own = selected(outcome[1].rows, study="systems", method=name)
        assert line["SEA_mm2"] == pytest.approx(np.mean([row["SEA_mm2"] for row in own]))
        assert line["end_error_mm"] < 1.0
        assert selected(table, protocol="Table 2, quoted", method=name)


def test_characteristics_of_systems_are_measured(outcome):
    for row in outcome[1].report.tables["characteristics"]:
        assert row["arrived"] == row["starts"] == 500
        assert row["violations"] == 0
        assert row["in_space"] == 1
        assert 0 <= row["from_one"] <= row["drawings"] == 4
    (_, modified) = outcome[1].report.tables["characteristics"]
    assert modified["from_one"] >= 3


@pytest.mark.parametrize("name", SYSTEMS)
def test_every_system_of_the_papers_table_is_known(name):
    assert callable(system(name).fit)


def test_table_holds_means_and_the_papers_convention(outcome):
    _, found, out = outcome
    with (out / "table.csv").open() as file:
        table = list(csv.DictReader(file))
    first = table[0]
    rows = selected(found.rows, protocol="IN", method="FML")
    area = np.mean([row["SEA_mm2"] for row in rows])
    assert float(first["SEA_mm2"]) == pytest.approx(area)
    assert float(first["SEA_sum_px2"]) == pytest.approx(area * 7 * 8.3**2)
    quoted = {row["method"]: row for row in table if row["protocol"] == "Table 2, quoted"}
    assert float(quoted["FML"]["SEA_sum_px2"]) == 1.23e5
    assert quoted["FML with auto-learning"]["SEA_sum_px2"] == ""


def test_shapes_are_ranked_by_their_error_and_saturations_swept(outcome):
    config, found, out = outcome
    ranked = ranking(config, found.rows, "FML")
    errors = [row["SEA_mm2"] for row in ranked]
    assert errors == sorted(errors, reverse=True)
    assert {row["motion"] for row in ranked} == set(config.motions)
    summary = json.loads((out / "results.json").read_text())["summary"]
    assert [row["saturation"] for row in summary["saturation"]] == [0.1, 1.0]
    (learned,) = found.report.tables["auto_learning"]
    assert learned["paths"] == 14
    assert "not compared" in summary["remark"]


def test_figures_are_written(outcome):
    _, _, out = outcome
    for name in ("methods", "ranking", "shapes", "saturation"):
        assert (Path(out) / f"{name}.png").read_bytes().startswith(b"\x89PNG")


def test_a_quick_study_tests_the_first_demonstrations_of_the_full_one():
    arguments = {"motion": "Line", "protocol": "LOO from 3", "method": "ProMP", "seed": 0}
    few, all_of_them = study.compare(**arguments, count=3), study.compare(**arguments)
    assert len(all_of_them) == 7
    assert few == all_of_them[:3]
    quick = [task.arguments for task in study.tasks(study.configure(True, 0))]
    assert {each["count"] for each in quick} == {3}
    full = [task.arguments for task in study.tasks(study.configure(False, 0))]
    assert {each.get("count") for each in full} == {None}


def test_full_study_covers_thirty_motions_and_quick_four():
    assert len(study.configure(False, 0).motions) == 30
    assert len(study.configure(True, 5).motions) == 4
    assert study.configure(True, 5).seed == 5
    assert set(study.configure(False, 0).methods) == set(METHODS)

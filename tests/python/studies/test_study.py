"""The engine of the studies: known rows are not computed again; a failing task stops no other."""

import csv
import json
from dataclasses import dataclass, replace

import pytest
from matplotlib.figure import Figure
from refusals import refused

from leadthrough.errors import FitError
from leadthrough_studies import study
from leadthrough_studies.lasa.study import STUDY, LasaConfig
from leadthrough_studies.study import Report, Study, Task

CALLS = []


@dataclass(frozen=True)
class Config:
    numbers: tuple[int, ...] = (1, 2, 3)
    seed: int = 0


def square(*, number):
    CALLS.append(number)
    if number < 0:
        raise FitError(f"{number} is negative")
    return [{"number": number, "square": number**2}, {"number": number, "square": 0.1 + 0.2}]


def not_finite(*, number):
    return [{"number": number, "square": float("nan")}]


def report(config, rows):
    return Report([{"sum": sum(row["square"] for row in rows), "seed": config.seed}],
                  figures={"empty": Figure()}, summary={"count": len(rows)})  # fmt: skip


def configure(quick, seed):
    return Config((1,) if quick else (1, 2, 3), seed)


def squares(function=square):
    def tasks(config):
        return [Task(function, {"number": number}) for number in config.numbers]

    return Study(configure, tasks, report)


@pytest.fixture(autouse=True)
def no_calls():
    CALLS.clear()


def document(out):
    def refuse(value):
        raise ValueError(f"{value} is no JSON")

    return json.loads((out / "results.json").read_text(), parse_constant=refuse)


def test_results_hold_configuration_versions_rows_and_table(tmp_path):
    outcome = study.run(squares(), Config(seed=7), out=tmp_path / "new" / "folder")
    written = document(tmp_path / "new" / "folder")
    assert written["configuration"] == {"numbers": [1, 2, 3], "seed": 7}
    assert {"leadthrough", "numpy", "python", "code"} <= set(written["versions"])
    assert written["rows"] == outcome.rows
    assert [row["square"] for row in outcome.rows[::2]] == [1, 4, 9]
    assert written["failures"] == []
    assert written["summary"] == {"count": 6}
    with (tmp_path / "new" / "folder" / "table.csv").open() as file:
        assert [row["seed"] for row in csv.DictReader(file)] == ["7"]
    assert (tmp_path / "new" / "folder" / "empty.png").read_bytes().startswith(b"\x89PNG")


def test_known_rows_are_not_computed_again(tmp_path):
    first = study.run(squares(), Config(), out=tmp_path)
    CALLS.clear()
    again = study.run(squares(), Config(numbers=(3, 4, 1)), out=tmp_path)
    assert CALLS == [4]
    assert [row["number"] for row in again.rows] == [3, 3, 4, 4, 1, 1]
    assert again.rows[:2] == first.rows[4:]


def test_a_study_that_was_stopped_goes_on_where_it_was(tmp_path):
    def stop_at_three(*, number):
        if number == 3:
            raise KeyboardInterrupt
        return square(number=number)

    stop_at_three.__qualname__ = square.__qualname__  # the same task, stopped from outside
    with pytest.raises(KeyboardInterrupt):
        study.run(squares(stop_at_three), Config(), out=tmp_path)
    assert CALLS == [1, 2]
    outcome = study.run(squares(), Config(), out=tmp_path)
    assert CALLS == [1, 2, 3]
    assert len(outcome.rows) == 6


def test_rows_are_computed_again_when_the_code_changes(tmp_path, monkeypatch):
    study.run(squares(), Config(), out=tmp_path)
    monkeypatch.setattr("leadthrough.tasks.code.digest", lambda _: "other")
    study.run(squares(), Config(), out=tmp_path)
    assert CALLS == [1, 2, 3, 1, 2, 3]


def test_a_damaged_file_of_the_store_is_computed_again(tmp_path):
    study.run(squares(), Config(), out=tmp_path)
    for path in (tmp_path / "cache").rglob("*.json"):
        path.write_text('[{"number": 1')
    assert study.run(squares(), Config(), out=tmp_path).rows[0]["square"] == 1
    assert CALLS == [1, 2, 3, 1, 2, 3]


def test_a_task_that_fails_is_reported_and_tried_again(tmp_path):
    config = Config(numbers=(1, -2, 3))
    outcome = study.run(squares(), config, out=tmp_path)
    assert [row["number"] for row in outcome.rows] == [1, 1, 3, 3]
    (failure,) = outcome.failures
    traceback = failure.pop("traceback")
    assert failure == {"task": {"number": -2}, "error": "FitError", "message": "-2 is negative"}
    assert "in square" in traceback
    failure["traceback"] = traceback
    assert document(tmp_path)["failures"] == [failure]
    CALLS.clear()
    study.run(squares(), config, out=tmp_path)
    assert CALLS == [-2]


def test_rows_that_are_not_finite_are_failures(tmp_path):
    outcome = study.run(squares(not_finite), Config(), out=tmp_path)
    assert outcome.rows == []
    assert {failure["error"] for failure in outcome.failures} == {"ValueError"}
    assert document(tmp_path)["rows"] == []


def test_rows_do_not_depend_on_where_tasks_run(tmp_path):
    config = LasaConfig(
        ("Line", "Worm"),
        methods=("nearest demonstration, shifted",),
        protocols=("IN", "LOO from 3"),
        systems=(),
        saturations=(),
        settings=(),
    )
    one, two = (
        study.run(STUDY, config, out=tmp_path / name, on=on).rows
        for name, on in (("one", None), ("two", "local:2"))
    )
    assert one == two
    assert len(one) == 28


@pytest.mark.parametrize("on", ["local:0", "local:-1", "local:1.5", "somewhere", "none.json"])
def test_a_wrong_place_is_refused(tmp_path, on):
    refused("on: ", study.run, squares(), Config(), out=tmp_path, on=on)


def test_a_folder_that_cannot_be_made_is_an_expected_error(tmp_path):
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(OSError, match="file"):
        study.run(squares(), Config(), out=tmp_path / "file" / "x")


def test_key_changes_with_every_argument():
    task = Task(square, {"number": 1})
    assert task.key == Task(square, {"number": 1}).key
    assert task.key != replace(task, arguments={"number": 2}).key
    assert task.key != replace(task, function=not_finite).key


def test_mean_and_selection_skip_missing_columns():
    rows = [{"a": 1, "b": 2.0}, {"a": 1, "b": 4.0}, {"a": 2}]
    assert study.mean(study.selected(rows, a=1), "b") == 3.0
    assert study.mean(study.selected(rows, a=2), "b") is None

"""The demo and the studies from the command line, and how errors end."""

import csv
import functools
import json
import re
import sys
from dataclasses import replace

import pytest
from cli.command_line import RUNNER, run
from refusals import raised

from leadthrough import cli, errors
from leadthrough_studies import catalogue, study
from leadthrough_studies.demo import harvesting, report, scenes
from leadthrough_studies.ur3.study import STUDY, Setting, Ur3Config

harvested = functools.cache(harvesting.run)


@pytest.fixture(scope="module")
def shown(tmp_path_factory):
    """Output and files of the demo with one motion of handwriting, without recordings."""
    out = tmp_path_factory.mktemp("demo") / "results"
    with pytest.MonkeyPatch.context() as patched:
        patched.delenv("LEADTHROUGH_DATA", raising=False)
        return run("demo", "--out", out, "--motion", "GShape").output, out


def test_demo_writes_figures_errors_and_trajectories(shown):
    printed, out = shown
    assert "GShape" in printed
    for name in ("overview.png", "GShape/learning.png", "GShape/joints.png", "pouring/joints.png"):
        assert (out / name).read_bytes().startswith(b"\x89PNG")
    with (out / "errors.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["motion"] for row in rows] == ["GShape", "mean"]
    assert 0 < float(rows[0]["SEA_mm2"]) < 500
    for name, joints in (("GShape", 6), ("pouring", 7), ("harvesting", 7)):
        message = json.loads((out / name / "trajectory.json").read_text())
        assert message["points"][-1]["velocities"] == pytest.approx([0.0] * joints, abs=1e-9)
        assert (out / name / "trajectory.csv").is_file()
    assert [event["name"] for event in message["events"]] == ["closed", "opened"]
    assert (out / "simulated.html").is_file()


def test_demo_names_the_extra_that_is_missing(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    monkeypatch.setattr(scenes, "other", lambda *_: harvested())
    out = tmp_path / "one[1]"
    said = run("demo", "--out", out, "--scene", "harvesting").output
    assert "pip install 'leadthrough[simulation]'" in said
    assert f"{out}/" in said.replace("\n", "")


def test_page_of_the_demo_shows_three_arms_and_explains_every_measure(shown):
    report = (shown[1] / "report.html").read_text()
    assert report.count('<figure class="scene">') == 3
    assert report.count("<svg") == 1
    for arm in ("ur3", "panda", "tiago"):
        assert f"<td>{arm}</td>" in report
    assert report.count("<td>kept</td>") == report.count("<td>clear</td>") == 3
    explained = " ".join(re.findall("<dt>(.*?)</dt>", report))
    for measured in ("SEA", "V_rmse", "DTWD/N", "Fréchet", "to itself", "acceleration"):
        assert measured in explained
    assert set(re.findall('href="#(.*?)"', report)) <= set(re.findall('id="(.*?)"', report))


def test_demo_does_without_the_handwriting_set(tmp_path, monkeypatch):
    monkeypatch.setattr("leadthrough.io.lasa.find_spec", lambda _: None)
    monkeypatch.setattr(scenes, "other", lambda *_: harvested())
    monkeypatch.setattr(report, "write_simulation", lambda *_: "simulated.html")
    assert "leadthrough[lasa]" in run("demo", "--out", tmp_path).output
    assert (tmp_path / "report.html").read_text().count('<figure class="scene">') == 2
    asked = run("demo", "--out", tmp_path, "--scene", "handwriting", code=2)
    assert "leadthrough[lasa]" in asked.output


def test_experiment_writes_results_and_goes_on_where_it_was(tmp_path, monkeypatch):
    config = Ur3Config((1,), (), Setting(resolution=0.025), saturations=(), seed=3)
    asked = []
    small = replace(STUDY, configure=lambda quick, seed: asked.append((quick, seed)) or config)
    monkeypatch.setitem(catalogue.STUDIES, "ur3", small)
    words = ["experiment", "ur3", "--quick", "--seed", "3", "--out", tmp_path]
    first = run(*words)
    assert asked == [(True, 3)]
    assert "kappa paper" in first.output
    written = (tmp_path / "results.json").read_bytes()
    assert json.loads(written)["configuration"]["seed"] == 3
    assert "Under gravity and a controller: fit to run" in " ".join(first.output.split())
    page = (tmp_path / "simulated.html").read_text()
    assert "The arm as simulated; transparent, as planned." in page
    run(*words)
    assert (tmp_path / "results.json").read_bytes() == written
    monkeypatch.setitem(sys.modules, "mujoco", None)
    without = run(*words)
    assert "pip install 'leadthrough[simulation]'" in " ".join(without.output.split())
    assert "simulated.html" not in without.output


def fail(*, setup, **_):
    raise ValueError(f"setup {setup} is out of paper")


def test_experiment_with_a_failure_says_so_and_ends_with_one(tmp_path, monkeypatch):
    broken = replace(
        STUDY,
        tasks=lambda config: [study.Task(fail, {"setup": n}) for n in config.setups],
        report=lambda *_: study.Report([]),
    )
    monkeypatch.setitem(catalogue.STUDIES, "ur3", broken)
    result = run("experiment", "ur3", "--out", tmp_path, code=1)
    assert "setup 4 is out of paper" in " ".join(result.output.split())


def test_a_study_that_is_stopped_says_how_to_go_on(tmp_path, monkeypatch):
    def stop(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(study, "run", stop)
    result = run("experiment", "ur3", "--quick", "--out", tmp_path, code=130)
    assert "rerun the command to resume" in result.stderr


@pytest.mark.parametrize(
    "wrong",
    [
        ["experiment", "nothing"],
        ["experiment", "lasa", "--seed", "-1"],
        ["experiment", "ur3", "--jobs", "0"],
        ["demo", "--out", "made", "--motion", "Scribble"],
        ["demo", "--motion", "Snake", "--out", "file/x"],
    ],
)
def test_wrong_arguments_are_an_error_of_one_line(wrong, empty_folder, monkeypatch, capsys):
    (empty_folder / "file").write_text("in the way")
    monkeypatch.setattr("sys.argv", ["leadthrough", *wrong])
    assert raised(SystemExit, cli.main).code == 2
    assert wrong[-1] in capsys.readouterr().err.replace("\n", "")
    assert [path.name for path in empty_folder.iterdir()] == ["file"]


def test_experiment_without_a_name_lists_the_studies():
    assert run("experiment").output.split() == list(catalogue.STUDIES)


def test_traceback_comes_with_debug_only():
    wrong = ["experiment", "nothing"]
    assert "Traceback" not in run(*wrong, code=2).output
    assert isinstance(RUNNER.invoke(cli.app, ["--debug", *wrong]).exception, errors.InvalidInput)


def test_help_names_the_commands():
    assert {"demo", "experiment"} <= set(run("--help").output.split())

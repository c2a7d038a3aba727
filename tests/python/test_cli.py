"""The command line."""

import csv
import json

import pytest
from typer.testing import CliRunner

from leadthrough import cli

runner = CliRunner()


def test_demo_writes_figures_errors_and_trajectories(tmp_path):
    out = tmp_path / "results"
    result = runner.invoke(cli.app, ["demo", "--out", str(out), "--motion", "GShape"])
    assert result.exit_code == 0, result.output
    assert "GShape" in result.output
    for name in ("overview.png", "GShape/learning.png", "GShape/joints.png"):
        assert (out / name).read_bytes().startswith(b"\x89PNG")
    with (out / "errors.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["motion"] for row in rows] == ["GShape", "mean"]
    assert 0 < float(rows[0]["SEA_mm2"]) < 500
    message = json.loads((out / "GShape" / "trajectory.json").read_text())
    assert message["points"][-1]["velocities"] == [0.0] * 6
    assert (out / "GShape" / "trajectory.csv").is_file()


def test_unknown_motion_is_an_error_of_one_line(tmp_path, monkeypatch, capsys):
    arguments = ["leadthrough", "demo", "--out", str(tmp_path), "--motion", "Scribble"]
    monkeypatch.setattr("sys.argv", arguments)
    with pytest.raises(SystemExit) as error:
        cli.main()
    assert error.value.code == 2
    assert "Scribble" in capsys.readouterr().err


def test_output_folder_that_cannot_be_made_is_an_error_of_one_line(tmp_path, monkeypatch, capsys):
    (tmp_path / "file").write_text("in the way")
    arguments = ["leadthrough", "demo", "--out", str(tmp_path / "file" / "x"), "--motion", "Snake"]
    monkeypatch.setattr("sys.argv", arguments)
    with pytest.raises(SystemExit) as error:
        cli.main()
    assert error.value.code == 2
    assert str(tmp_path / "file") in capsys.readouterr().err.replace("\n", "")


def test_help_names_the_commands():
    result = runner.invoke(cli.app, ["--help"])
    assert result.exit_code == 0
    assert "demo" in result.output

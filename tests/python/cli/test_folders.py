"""Folders where files are taken: their recordings, by their names."""

import json
from pathlib import Path

import pytest
from cli.command_line import facts, run
from motions import with_derivatives

import leadthrough as lt

REACHES = ["reach1", "reach2", "reach3"]


@pytest.fixture(autouse=True)
def _others(folder):
    """Files beside the recordings that are none."""
    Path("recorded/notes.md").write_text("not a recording")
    Path("recorded/.hidden.csv").write_text("not one either")
    Path("recorded/README.txt").write_text("Three reaches.\n\n1. By hand, 2 kg held.\n")
    Path("recorded/camera.json").write_text('{"fx": 612.0, "offset": [0, 1]}')
    Path("recorded/robot.yaml").write_text("robot: ur3\npath_xyz_offset: [0.0, 0.5, 0.8]\n")


def test_a_folder_stands_for_its_recordings(folder):
    assert facts("learn", "recorded", "-o", "s.npz")["demonstrations"] == REACHES
    files = sorted(Path("recorded").glob("reach*.csv"))
    learned = facts("learn", *files, "-o", "t.npz")
    assert learned["demonstrations"] == REACHES
    assert Path("s.npz").read_bytes() == Path("t.npz").read_bytes()


def test_every_command_that_takes_recordings_takes_a_folder(folder):
    told = facts("info", "recorded", "ur3.urdf")
    assert [Path(each["path"]).stem for each in told] == [*REACHES, "ur3"]
    assert {each["kind"] for each in facts("info", ".")} == {"robot"}
    assert len(facts("clean", "recorded", "-o", "clean.csv")) == 3
    run("learn", "recorded", "-o", "s.npz")
    run("plan", "s.npz", "-o", "m.json")
    run("view", "m.json", "--demonstrations", "recorded", "--html", "page.html")


def test_a_folder_that_is_a_recording_stays_one(folder):
    pytest.importorskip("rosbags")
    shown = lt.read_motion("recorded/reach1.csv")
    Path("bags").mkdir()
    lt.write_motion(with_derivatives(shown), "bags/one", format="rosbag")
    assert [each["path"] for each in facts("info", "bags/one")] == ["bags/one"]
    assert [each["path"] for each in facts("info", "bags")] == ["bags/one"]


@pytest.mark.parametrize("words", [["learn", "-o", "s.npz"], ["info"], ["clean", "-o", "c.csv"]])
def test_a_folder_without_recordings_is_an_error(folder, words):
    Path("empty").mkdir()
    Path("empty/notes.md").write_text("nothing")
    result = run(words[0], "empty", *words[1:], code=2)
    assert "empty: nothing to read in this folder" in result.stderr


@pytest.mark.parametrize("form", ["json", "yaml", "txt"])
def test_in_a_folder_text_with_a_motion_is_never_left_out(folder, form):
    shown = lt.read_motion("recorded/reach1.csv")
    Path("texts").mkdir()
    if form == "txt":
        Path("recorded/reach1.csv").rename("texts/one.txt")
    else:
        lt.write_motion(with_derivatives(shown), f"texts/one.{form}")
    assert [each["path"] for each in facts("info", "texts")] == [f"texts/one.{form}"]
    if form == "txt":
        text = Path("texts/one.txt").read_text()
        Path("texts/one.txt").write_text(text, encoding="utf-16")
        assert [each["path"] for each in facts("info", "texts")] == ["texts/one.txt"]
    Path(f"texts/broken.{form}").write_text("time,x\n0,a\n1,2\n" if form == "txt" else "points: 3")
    assert f"broken.{form}" in run("learn", "texts", "-o", "s.npz", code=2).stderr


def test_files_whose_names_look_like_options_are_told_and_taken(folder):
    odd = ("-out.csv", "--reach.csv")  # of the first, -o would take "ut.csv"
    for name, shown in zip(odd, sorted(Path("recorded").glob("reach*.csv")), strict=False):
        Path(name).write_bytes(shown.read_bytes())
        said = run("learn", "recorded", name, "-o", "s.npz", code=2).stderr
        assert f"{name}: looks like an option" in said
        assert f"./{name}" in said
    result = run("learn", "-o", "s.npz", "--json", "--", *odd)
    assert json.loads(result.stdout)["demonstrations"] == ["-out", "--reach"]
    named = [f"./{name}" for name in odd]
    assert facts("learn", *named, "-o", "s.npz")["demonstrations"] == ["-out", "--reach"]

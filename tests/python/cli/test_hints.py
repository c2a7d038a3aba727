"""Every ending of a command leads on, by a command line that can be typed as it stands."""

import os
import shlex
from pathlib import Path

import pytest
from cli.command_line import run
from rich.console import Console

from leadthrough.cli.tables import table

WIDTH = 80


def next_of(result):
    """The words of the next command line; of a change of folder, after making it."""
    (hint,) = (line for line in result.stdout.splitlines() if line.startswith("next: "))
    words = shlex.split(hint.removeprefix("next: "))
    if words[0] == "cd":
        os.chdir(words[1])
        words = words[3:]
    assert words[0] == "leadthrough", hint
    return words[1:]


def assert_fits(result):
    lines = [line for line in result.output.splitlines() if not line.startswith("next: ")]
    assert max(map(len, lines)) <= WIDTH, max(lines, key=len)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with the example, as the working directory."""
    monkeypatch.chdir(tmp_path)
    run("example", "reach", ".")
    return tmp_path


def test_the_hints_lead_from_the_example_to_the_view(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words, typed = ["example", "reach", "a folder"], []
    while words[0] != "view":
        result = run(*words)
        assert_fits(result)
        typed.append(words[0])
        words = next_of(result)
    assert typed == ["example", "info", "learn", "plan", "retime", "check"]
    assert_fits(run(*words))
    assert Path("motion-timed.html").stat().st_size > 1000


def test_the_hints_repeat_the_arm_that_was_typed(folder):
    arm = ["--robot", "ur3.urdf", "--tip", "tool0", "--limits", "ur3.toml"]
    Path("leadthrough.toml").unlink()
    words = ["learn", "shown", *arm, "-o", "reach.npz"]
    for command in ("plan", "retime", "check", "view"):
        words = next_of(run(*words))
        assert words[0] == command
        assert " ".join(arm) == " ".join(words[2 : 2 + len(arm)])


def test_a_urdf_leads_to_a_limits_file_and_that_to_learning(folder):
    Path("leadthrough.toml").unlink()
    result = run("info", "ur3.urdf", "--tip", "tool0")
    assert_fits(result)
    words = next_of(result)
    assert words == ["info", "ur3.urdf", "--tip", "tool0", "--write-limits", "ur3.toml"]
    Path("ur3.toml").unlink()
    words = next_of(run(*words))
    arm = ["--robot", "ur3.urdf", "--tip", "tool0", "--limits", "ur3.toml"]
    assert words == ["learn", "RECORDINGS", *arm, "-o", "skill.npz"]
    run("learn", "shown", *words[2:])


def test_faulty_recordings_are_cleaned_while_they_are_learned(folder):
    lines = Path("shown/reach1.csv").read_text().splitlines()
    lines[50] = ",".join(["nan"] * 7)
    Path("shown/reach1.csv").write_text("\n".join(lines))
    words = next_of(run("info", "shown/reach1.csv"))
    assert words == ["learn", "shown/reach1.csv", "--clean", "-o", "skill.npz"]
    run(*words)
    words = next_of(run("clean", "shown", "-o", "clean.csv"))
    assert words[:2] == ["learn", "clean_1.csv"]


def test_a_skill_leads_to_a_plan_and_poses_to_an_arm(folder):
    run("learn", "shown", "-o", "skill.npz")
    words = next_of(run("info", "skill.npz"))
    assert words[:2] == ["plan", "skill.npz"]
    hint = next_of(run("--no-profile", *words))
    assert hint == ["plan", "skill.npz", "--robot", "ROBOT", "-o", "motion.json"]


def test_a_motion_that_fails_the_check_leads_to_what_mends_it(folder):
    assert next_of(run("check", "shown/reach1.csv", code=1))[0] == "retime"
    run("retime", "shown/reach1.csv", "--path-tolerance", "0.01", "-o", "timed.json")
    hit = run("check", "timed.json", "--obstacle", "sphere:0.1@0.24,0.24,0.25", code=1)
    assert "next: plan with a larger --obstacle or another --posture" in hit.stdout
    assert_fits(hit)


def test_a_program_for_the_controller_leads_to_the_robot(folder):
    result = run("retime", "shown/reach1.csv", "--path-tolerance", "0.01", "-o", "timed.script")
    assert "next: run timed.script on the robot" in result.stdout


def test_json_has_no_hints(folder):
    assert "next:" not in run("learn", "shown", "-o", "reach.npz", "--json").output


def test_joints_that_no_arm_was_named_for_are_written_for_a_controller(folder):
    run("--no-profile", "learn", "shown", "-o", "joints.npz")
    run("--no-profile", "plan", "joints.npz", "-o", "joints.json")


@pytest.mark.parametrize("count", [1, 3, 12])
def test_the_tables_of_the_studies_fit_and_show_every_value(count):
    rows = [{f"quantity {i} m": f"{row}-{i}-of-the-rows" for i in range(8)} for row in range(count)]
    console = Console(width=WIDTH, record=True)
    console.print(table(rows))
    text = console.export_text()
    assert max(map(len, text.splitlines())) <= WIDTH
    assert all(f"{row}-{i}-of-the-rows" in text for row in range(count) for i in range(8))

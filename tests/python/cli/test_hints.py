"""Every ending of a command leads on, by a command line that can be typed as it stands."""

import os
import shlex
from pathlib import Path

import numpy as np
import pytest
from cli.command_line import run, write_table
from rich.console import Console

import leadthrough as lt
from leadthrough.cli.output import table

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


def test_the_hints_lead_from_the_example_to_the_view(empty_folder):
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
    words = ["learn", "recorded", *arm, "-o", "reach.npz"]
    for command in ("plan", "retime", "check", "view"):
        words = next_of(run(*words))
        assert words[0] == command
        assert " ".join(arm) == " ".join(words[2 : 2 + len(arm)])


def chained(*words):
    """Types a command and each next one, up to the view: the commands before it."""
    typed = []
    while "view" not in words:
        typed.append(words)
        words = next_of(run(*words))
    run(*words)
    return typed


def test_the_hints_run_as_printed_with_what_says_how_recordings_are_read(folder):
    rows = np.loadtxt("recorded/reach1.csv", delimiter=",", skiprows=1)
    turned = np.degrees(rows[:, 1:])
    write_table("logged.csv", "a,b,c,d,e,f", turned)
    reading = ["--column", "joints=a,b,c,d,e,f", "--rate", "125.0", "--angles", "degrees"]
    typed = chained("info", "logged.csv", *reading)
    assert [words[0] for words in typed] == ["info", "learn", "plan", "retime", "check"]
    assert typed[1] == ["learn", "logged.csv", *reading, "-o", "skill.npz"]
    assert np.abs(lt.read_motion("motion.json").positions[0] - rows[0, 1:]).max() < 0.05


def test_the_hints_run_as_printed_in_a_folder_whose_profile_is_ignored(folder):
    arm = ["--robot", "ur3.urdf", "--tip", "tool0", "--limits", "ur3.toml"]
    Path("leadthrough.toml").write_text('robot = "panda"\n')
    typed = chained("--no-profile", "learn", "recorded", *arm, "-o", "reach.npz")
    assert [words[:2] for words in typed[1:]] == [
        ["--no-profile", command] for command in ("plan", "retime", "check")
    ]


def test_a_path_leads_to_the_same_motion_of_an_arm(folder):
    run("learn", "recorded", "-o", "reach.npz")
    asked = ["--move-start", "0.0,0.01,0.0", "--move-goal=-0.02,0.03,0", "--dt", "0.02"]
    asked += ["--obstacle", "sphere:0.01@0,0,1", "--duration", "4.0"]
    path = run("--no-profile", "plan", "reach.npz", *asked, "-o", "path.csv")
    assert "does not keep" not in path.stderr
    words = next_of(path)
    assert words[-4:] == ["--robot", "ROBOT", "-o", "path.json"]
    words[words.index("ROBOT")] = "ur3"
    result = run(*words)
    assert "does not keep" not in result.stderr
    tip, joints = lt.read_motion("path.csv"), lt.read_motion("path.json")
    reached = lt.Arm.load("ur3").poses(joints).positions
    assert np.abs(reached - tip.positions).max() < 1e-4
    assert len(joints) == len(tip) == 201
    later = lt.Arm.load("ur3").follow(tip)  # in the posture that the path keeps
    assert np.abs(later.positions - joints.positions).max() < 1e-4
    bag = run("--no-profile", "plan", "reach.npz", "-o", "path.mcap").stderr
    assert "note: path.mcap does not keep the demonstrated joints" in bag


def test_a_plan_in_a_format_that_cannot_be_read_leads_to_one_that_can(folder):
    run("learn", "recorded", "-o", "reach.npz")
    asked = ["--obstacle", "sphere:0.02@0,0,1", "--tolerance", "0.0001,0.0001", "--tip-only"]
    words = next_of(run("plan", "reach.npz", *asked, "-o", "m.script"))
    assert words == ["plan", "reach.npz", *asked, "-o", "m.json"]
    assert [typed[0] for typed in chained(*words)] == ["plan", "retime", "check"]


@pytest.mark.parametrize("profile", [False, True])
def test_an_arm_without_known_accelerations_leads_to_a_limits_file_first(folder, profile):
    arm = ["--robot", "ur3.urdf", "--tip", "tool0"]
    Path("leadthrough.toml").unlink()
    if profile:
        Path("leadthrough.toml").write_text('robot = "ur3.urdf"\ntip = "tool0"\n')
        arm = []
    run("learn", "recorded", *arm, "-o", "reach.npz")
    result = run("plan", "reach.npz", *arm, "-o", "m.json")
    (hint,) = (line for line in result.stdout.splitlines() if line.startswith("next: "))
    first, second = (shlex.split(part) for part in hint.removeprefix("next: ").split(" && "))
    assert first[-2:] == ["--write-limits", "ur3-limits.toml"]  # ur3.toml is there
    run(*first[1:])
    assert [typed[0] for typed in chained(*second[1:])] == ["retime", "check"]


def test_files_whose_names_look_like_options_are_led_on_with_their_folder(folder):
    typed = chained("learn", "recorded", "-o", "-odd.npz")
    assert typed[1][1] == "./-odd.npz"
    Path("recorded/reach1.csv").rename("--reach.csv")
    words = next_of(run("info", "--", "--reach.csv"))
    assert words[:2] == ["learn", "./--reach.csv"]
    run(*words)


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
    run("learn", "recorded", *words[2:])


def test_faulty_recordings_are_cleaned_while_they_are_learned(folder):
    lines = Path("recorded/reach1.csv").read_text().splitlines()
    lines[50] = ",".join(["nan"] * 7)
    Path("recorded/reach1.csv").write_text("\n".join(lines))
    words = next_of(run("info", "recorded/reach1.csv"))
    assert words == ["learn", "recorded/reach1.csv", "--clean", "-o", "skill.npz"]
    run(*words)
    words = next_of(run("clean", "recorded", "-o", "clean.csv"))
    assert words[:2] == ["learn", "clean_1.csv"]


def test_a_skill_leads_to_a_plan_and_poses_to_an_arm(folder):
    run("learn", "recorded", "-o", "skill.npz")
    words = next_of(run("info", "skill.npz"))
    assert words[:2] == ["plan", "skill.npz"]
    hint = next_of(run("--no-profile", *words))
    assert hint == ["--no-profile", "plan", "skill.npz", "--robot", "ROBOT", "-o", "motion.json"]


def test_a_motion_that_fails_the_check_leads_to_what_mends_it(folder):
    assert next_of(run("check", "recorded/reach1.csv", code=1))[0] == "retime"
    run("retime", "recorded/reach1.csv", "--path-tolerance", "0.01", "-o", "timed.json")
    hit = run("check", "timed.json", "--obstacle", "sphere:0.1@0.24,0.24,0.25", code=1)
    assert "next: replan with a larger --margin or another --posture" in hit.stdout
    assert_fits(hit)


def test_a_program_for_the_controller_leads_to_the_robot(folder):
    result = run("retime", "recorded/reach1.csv", "--path-tolerance", "0.01", "-o", "timed.script")
    assert "next: run timed.script on the robot" in result.stdout


def test_json_has_no_hints(folder):
    assert "next:" not in run("learn", "recorded", "-o", "reach.npz", "--json").output


def test_joints_that_no_arm_was_named_for_are_written_for_a_controller(folder):
    run("--no-profile", "learn", "recorded", "-o", "joints.npz")
    run("--no-profile", "plan", "joints.npz", "-o", "joints.json")


@pytest.mark.parametrize("count", [1, 3, 12])
def test_the_tables_of_the_studies_fit_and_show_every_value(count):
    rows = [{f"quantity {i} m": f"{row}-{i}-of-the-rows" for i in range(8)} for row in range(count)]
    console = Console(width=WIDTH, record=True)
    console.print(table(rows))
    text = console.export_text()
    assert max(map(len, text.splitlines())) <= WIDTH
    assert all(f"{row}-{i}-of-the-rows" in text for row in range(count) for i in range(8))

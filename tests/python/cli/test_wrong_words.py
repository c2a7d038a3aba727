"""Wrong words, values and units of the command line."""

import re
import shutil
from pathlib import Path

import numpy as np
import pytest
import typer
from cli.command_line import run

import leadthrough as lt
from leadthrough import cli

COMMANDS = typer.main.get_command(cli.app).commands
ENOUGH = {
    "demo": [],
    "start": ["ur3.urdf", "recorded", "--yes"],
    "example": ["reach", "elsewhere"],
    "info": ["recorded"],
    "clean": ["recorded/reach1.csv", "-o", "out.csv"],
    "judge": ["recorded", "recorded"],
    "learn": ["recorded/reach1.csv", "-o", "out.npz"],
    "plan": ["skill.npz", "-o", "out.json"],
    "retime": ["recorded/reach1.csv", "-o", "out.json"],
    "check": ["recorded/reach1.csv"],
    "guard": ["recorded/reach1.csv", "-o", "out.json"],
    "simulate": ["recorded/reach1.csv"],
    "reach": ["-o", "out.npz"],
    ("reach", "yaws"): ["--skill", "skill.npz", "--area", "0,0,0:0,0,0", "-o", "out.npz"],
    ("reach", "skill"): ["--area", "0,0,0:0,0,0", "-o", "out.npz"],
    ("reach", "area"): ["--skill", "skill.npz", "-o", "out.npz"],
    ("reach", "folder"): ["--volume", "0,0,0:0,0,0", "-o", "out.npz"],
    "validate": ["skill.npz", "--runs", "1", "--out", "found"],
    "augment": ["skill.npz", "--episodes", "1", "--goals", "0,0,0", "-o", "found"],
    ("augment", "goals"): ["skill.npz", "--episodes", "1", "-o", "found"],
    "view": ["recorded/reach1.csv", "--html", "out.html"],
    "teach": [],
    "experiment": ["ur3"],
    **{("info", name): ["ur3.urdf"] for name in ("base", "limits", "mesh_folder", "tip")},
    ("info", "write_limits"): ["ur3.urdf"],
    ("info", "topic"): ["shown.mcap"],
    ("clean", "topic"): ["shown.mcap", "-o", "out.csv"],
    ("learn", "samples"): ["recorded/reach1.csv", "--table", "out.csv", "-o", "out.npz"],
    ("judge", "topic"): ["shown.mcap"],
    ("start", "topic"): ["ur3.urdf", "shown.mcap", "--yes"],
    ("learn", "topic"): ["shown.mcap", "-o", "out.npz"],
    ("simulate", "skill"): ["recorded/reach1.csv", "--controller", "cartesian-impedance"],
    ("retime", "obstacle"): ["recorded/reach1.csv", "-o", "out.json", "--start", "0,0,0,0,0,0"],
    ("plan", "margin"): ["skill.npz", "-o", "out.json", "--obstacle", "sphere:0.1@1,1,1"],
}
# Options that take no negative number, and those that take no 0 either.
NOT_NEGATIVE = (
    "damping", "duration", "encoder", "frequency", "friction", "longest_gap",
    "longest_pause", "margin", "mass", "path_tolerance", "port", "pause", "payload", "rest",
    "rotor_inertia", "seed", "smoothing", "speed", "angular_speed", "stiffness", "tip_tolerance",
)  # fmt: skip
POSITIVE = (
    "density", "dt", "episodes", "jobs", "new_rate", "orientations", "rate", "runs", "spacing",
    "task_timeout", "tip_speed", "yaws",
)  # fmt: skip
# What is wrong for an option in any command, and in one of them.
WRONG = {
    **dict.fromkeys(NOT_NEGATIVE, "-1"),
    **dict.fromkeys(POSITIVE, "0"),
    "angles": "grad",
    "area": "1,2:3",
    "base": "nose",
    "column": "joints",
    "controller": "magic",
    "delay": "9",
    "drop": "reach9",
    "demonstrations": "none.csv",
    "format": "pdf",
    "folder": "ur3.toml/out",
    "free_axis": "spin",
    "goal": "a,b,c",
    "certify": "out.pdf",
    "goals": "1,2",
    "html": "nowhere/out.html",
    "limits": "none.toml",
    "mesh_folder": "none",
    "model": "magic",
    "move_goal": "1,2",
    "move_start": "1,2",
    "number": "7",
    "on": "local:0",
    "obstacle": "cube:1@0,0,0",
    "out": "out.pdf",
    "parameter": "magic=3",
    "posture": "1,2",
    "push": "1,2",
    "quaternions": "zyxw",
    "robot": "r2d2",
    "required": "1",
    "scene": "dancing",
    "skill": "none.npz",
    "samples": "1",
    "tolerance": "1",
    "start": "a,b,c",
    "starts": "1,2:3",
    "table": "out.pdf",
    "tip": "nose",
    "topic": "/none",
    "volume": "1,2,3",
    "width": "2",
    "random_obstacle": "sphere:0.1@0,0,0",
    "write_limits": "ur3.toml",
    ("demo", "motion"): "Scribble",
    ("demo", "out"): "ur3.toml/out",
    ("experiment", "out"): "ur3.toml/out",
    ("experiment", "recordings"): "nowhere",
    ("judge", "out"): "ur3.toml/out",
    ("validate", "out"): "ur3.toml/out",
    ("augment", "out"): "ur3.toml/out",
    ("teach", "out"): "ur3.toml/out",
    ("learn", "out"): "nowhere/out.npz",
}
# Without a wrong value; and files, which the error names instead.
ANY = {
    "help",
    "align",
    "as_joints",
    "as_json",
    "clean",
    "cut",
    "ideal",
    "keep_timing",
    "torques",
    "physics",
    "tip_only",
    "quick",
    "yes",
}
NAMED_BY_THEIR_VALUE = {
    ("view", "demonstrations"),
    ("view", "skill"),
    ("simulate", "skill"),
    ("demo", "out"),
    ("experiment", "out"),
    ("judge", "out"),
    ("reach", "folder"),
    ("reach", "skill"),
    ("validate", "out"),
    ("augment", "folder"),
    ("augment", "out"),
}
# Words of Python: keywords with values, calls, names in modules.
PYTHON = re.compile(
    r"(?<![\w./:-])[a-z_]+=\S|\w\(\)|\b(lt|io|timing|preprocess|arm|Arm|skill)\.[a-z]|in Python"
)
CASES = [
    (name, parameter)
    for name, command in COMMANDS.items()
    for parameter in command.params
    if parameter.param_type_name == "option" and parameter.name not in ANY
]


@pytest.fixture(scope="module")
def example(learned):
    """A folder with the example, a skill and a bag."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(learned)
        run("retime", "recorded/reach1.csv", "--path-tolerance", "0.01", "-o", "shown.mcap")
    return learned


@pytest.fixture
def folder(example, tmp_path, monkeypatch):
    shutil.copytree(example, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    ("name", "parameter"), CASES, ids=[f"{name} {each.opts[0]}" for name, each in CASES]
)
def test_an_error_names_the_option(folder, name, parameter):
    wrong = WRONG.get((name, parameter.name), WRONG.get(parameter.name))
    assert wrong is not None, f"{name} {parameter.opts[0]}: add a wrong value to WRONG"
    words = [name, *ENOUGH.get((name, parameter.name), ENOUGH[name])]
    code = 1 if (name, parameter.name) == ("info", "topic") else 2  # the bag cannot be read
    result = run(*words, f"{parameter.opts[0]}={wrong}", code=code)
    said = " ".join(re.sub("[│╭╮╰╯─]", " ", result.output).split())
    by_value = (name, parameter.name) in NAMED_BY_THEIR_VALUE
    assert (wrong if by_value else parameter.opts[0]) in said
    assert not PYTHON.search(said), said
    assert not list(Path().glob("out.*"))


@pytest.mark.parametrize("name", COMMANDS)
def test_help_fits_and_begins_with_a_sentence(name, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    text = run(name, "--help").stdout
    assert max(map(len, text.splitlines())) <= 80
    assert COMMANDS[name].help.split("\n\n")[0].endswith(".")
    for parameter in COMMANDS[name].params:
        assert parameter.help, f"{name} {parameter.opts[0]}"
        assert parameter.help.endswith("."), f"{name} {parameter.opts[0]}: {parameter.help}"


def test_a_goal_in_millimetres_is_refused(folder):
    told = run("plan", "skill.npz", "--goal", "300,200,250", "-o", "x.json", code=2).stderr
    assert "--goal: (300, 200, 250) lies" in told
    assert "m, not mm" in told


def test_a_goal_out_of_reach_says_by_how_much(folder):
    told = run("plan", "skill.npz", "--goal", "0.9,0.5,0.4", "-o", "x.json", code=1).stderr
    assert "beyond the arm's reach of" in told


def test_an_obstacle_in_millimetres_is_warned_of(folder):
    told = run("plan", "skill.npz", "--obstacle", "sphere:50@300,0,400", "-o", "x.json").stderr
    assert "warning: --obstacle[0]: lies at" in told or "warning: --obstacle: lies at" in told


def test_a_step_in_milliseconds_is_refused(folder):
    told = run("plan", "skill.npz", "--dt", "10", "-o", "x.json", code=2).stderr
    assert "--dt: expected at most the motion's duration" in told


def test_degrees_are_refused_with_the_option_that_cures_it(folder):
    arm = lt.Arm.load("ur3")
    q = np.degrees(np.outer(np.linspace(0.0, 1.0, 100), np.full(6, 0.19)))
    lt.write_motion(
        lt.JointTrajectory(np.arange(100) / 50, q, joint_names=arm.joint_names), "d.csv"
    )
    told = run("learn", "d.csv", "-o", "x.npz", code=2).stderr
    assert "--angles degrees" in told
    run("learn", "d.csv", "--angles", "degrees", "-o", "x.npz")


def test_another_tip_than_the_one_shown_is_warned_of(folder):
    urdf = (folder / "ur3.urdf").read_text()
    moved = urdf.replace('<link name="tool0"/>', '<link name="tool0"/><link name="far"/>').replace(
        "</robot>",
        '<joint name="to_far" type="fixed"><parent link="tool0"/><child link="far"/>'
        '<origin xyz="0 0 0.15"/></joint></robot>',
    )
    (folder / "longer.urdf").write_text(moved)
    words = ("--robot", "longer.urdf", "--tip", "far", "--limits", "ur3.toml", "-o", "x.json")
    told = run("plan", "skill.npz", *words).stderr
    assert "warning: --robot: with the demonstrated joints" in told
    assert "warning" not in run("plan", "skill.npz", "-o", "x.json").stderr

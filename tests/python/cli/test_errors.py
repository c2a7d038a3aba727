"""How errors end: in words of the command line, or as JSON.

Advice for those who program comes last in a message, after "in Python".
"""

import ast
import json
import re
from pathlib import Path

import pytest
from cli.command_line import run

import leadthrough as lt
from leadthrough.cli.output import in_words

WORDS = {
    "rate": "--rate",
    "angles": "--angles",
    "columns": "--column",
    "format": "--format",
    "limits": "leadthrough.toml: limits",
    "orientation": "--set orientation",
    "longest_gap": "--longest-gap",
}


@pytest.mark.parametrize(
    ("message", "said"),
    [
        ("rate: needed", "--rate: needed"),
        ("day.csv: rate: needed", "day.csv: --rate: needed"),
        ("angles: two turns; set angles='degrees'", "--angles: two turns; set --angles degrees"),
        ("columns['joints']: no column 'q7'", "--column joints: no column 'q7'"),
        ("limits: cannot be read", "leadthrough.toml: limits: cannot be read"),
        ("change it or set format", "change it or set --format"),
        ('use orientation="log" or rate=20.5', "use --set orientation=log or --rate 20.5"),
        ("a corporate: rate", "a corporate: rate"),
        ("accelerate: the rate is 3", "accelerate: the rate is 3"),
        ("--rate: needed", "--rate: needed"),
        (
            "no velocities; `leadthrough retime` adds them, in Python retime",
            "no velocities; `leadthrough retime` adds them",
        ),
        ("limits: none; in Python, from a file:\n[joints]", "leadthrough.toml: limits: none"),
        (
            "recording: a gap; allow it with a longest_gap above 3 s",
            "recording: a gap; allow it with a --longest-gap above 3 s",
        ),
    ],
)
def test_arguments_of_the_library_become_options(message, said):
    assert in_words(message, WORDS) == said


@pytest.mark.parametrize(
    ("words", "code", "kind", "argument"),
    [
        (["learn", "none.csv", "-o", "s.npz"], 2, "InvalidInput", None),
        (["learn", "recorded/reach1.csv", "--rate", "9", "-o", "s.npz"], 2, "InvalidInput",
         "--rate"),
        (["learn", "recorded/reach1.csv", "--column", "joints=a", "-o", "s.npz"], 2, "InvalidInput",
         "--column"),
        (["learn", "recorded/reach1.csv", "--rate", "x", "-o", "s.npz"], 2, "UsageError", "--rate"),
        (["learn", "recorded/reach1.csv"], 2, "UsageError", "--out"),
        (["learn", "recorded/reach1.csv", "--no-such"], 2, "UsageError", "--no-such"),
        (["nonsense"], 2, "UsageError", None),
        (["check", "recorded/reach1.csv", "--obstacle", "box:1@0,0,0"], 2, "InvalidInput",
         "--obstacle"),
        (["plan", "s.npz", "--move-goal=3,0,0", "-o", "m.json"], 1, "IkFailure", None),
    ],
)  # fmt: skip
def test_errors_are_one_json_object_where_json_is_asked_for(folder, words, code, kind, argument):
    if "s.npz" in words[1:2]:
        run("learn", "recorded/reach1.csv", "-o", "s.npz")
    result = run(*words, "--json", code=code)
    error = json.loads(result.stdout)["error"]
    assert (error["type"], error["argument"]) == (kind, argument)
    assert error["message"]
    assert "leadthrough:" not in result.stderr


def test_without_json_an_error_is_a_line_on_stderr(folder):
    result = run("learn", "none.csv", "-o", "s.npz", code=2)
    assert result.stdout == ""
    assert result.stderr.startswith("leadthrough: none.csv: ")
    assert result.stderr.count("\n") == 1


def test_the_version_is_told():
    assert run("--version").stdout == f"leadthrough {lt.__version__}\n"


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["learn", "skill.npz", "-o", "s.npz"], "skill.npz: expected recordings or a motion, got"),
        (["retime", "skill.npz", "-o", "m.json"], "`leadthrough plan skill.npz` makes a motion"),
        (["plan", "recorded/reach1.csv", "-o", "m.json"], "reach1.csv: expected a skill, a .npz"),
        (
            ["learn", "recorded", "-o", "skill"],
            "--out: expected a name that ends in .npz, got skill",
        ),
        (
            ["--no-profile", "plan", "skill.npz", "-o", "m.script"],
            "with --robot, plan writes joints",
        ),
    ],
)
def test_a_file_of_the_wrong_kind_is_told_with_the_command_that_takes_it(folder, words, says):
    run("learn", "recorded/reach1.csv", "-o", "skill.npz")
    result = run(*words, code=2)
    assert says in result.stderr
    assert result.stdout == ""


PACKAGE = Path(lt.__file__).parent
FUNCTIONS = re.compile(
    r"\b(?:lt|io|timing|preprocess|Arm|arm|skill)\.[a-z]\w*|[A-Za-z_]\w*\((?:\)|\.\.\.)"
)
# Nothing that a command calls raises these.
OF_PYTHON_ONLY = {"models/unfitted.py", "arm/task_stack.py"}
MESSAGES = [
    pytest.param(message, id=f"{path.relative_to(PACKAGE)}:{node.lineno}")
    for path in sorted(PACKAGE.rglob("*.py"))
    if str(path.relative_to(PACKAGE)) not in OF_PYTHON_ONLY
    for node in ast.walk(ast.parse(path.read_text()))
    if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call) and node.exc.args
    if FUNCTIONS.search(message := "".join(
        part.value
        for part in ast.walk(node.exc)
        if isinstance(part, ast.Constant) and isinstance(part.value, str)
    ))
]  # fmt: skip


def test_there_are_such_messages():
    assert len(MESSAGES) >= 5


@pytest.mark.parametrize("message", MESSAGES)
def test_no_function_is_left_for_a_user_of_commands(message):
    assert not FUNCTIONS.search(in_words(message, {})), message

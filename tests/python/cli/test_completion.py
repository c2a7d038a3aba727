"""Values of options that bash, zsh and fish complete."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from cli.command_line import RUNNER

from leadthrough import cli
from leadthrough.cli import options, parse
from leadthrough.io import points
from leadthrough_studies.catalogue import STUDIES

PROGRAM = """#!{python}
import sys
from leadthrough.cli import main
sys.argv[0] = "leadthrough"
main()
"""


@pytest.fixture(scope="module")
def folder(learned):
    """A folder with the example, a skill, a page, and a program `leadthrough` in bin."""
    (learned / "notes.md").touch()
    (learned / "page.html").touch()
    (learned / "bin").mkdir()
    program = learned / "bin" / "leadthrough"
    program.write_text(PROGRAM.format(python=sys.executable))
    program.chmod(0o755)
    return learned


@pytest.fixture
def inside(folder, monkeypatch):
    monkeypatch.chdir(folder)


def answer(**variables):
    """The program's answer to a shell."""
    environment = {"_LEADTHROUGH_COMPLETE": "complete_bash", **variables}
    result = RUNNER.invoke(cli.app, [], prog_name="leadthrough", env=environment)
    return [line for line in result.stdout.splitlines() if line]


def offered(line):
    """The completions of the last word of a line."""
    words = line.split(" ")
    return answer(COMP_WORDS="\n".join(words), COMP_CWORD=str(len(words) - 1))


REACHES = [f"recorded/reach{i}.csv" for i in (1, 2, 3)]


@pytest.mark.parametrize(
    ("line", "values"),
    [
        ("leadthrough le", ["learn"]),
        ("leadthrough learn recorded --mod", ["--model"]),
        ("leadthrough learn recorded --model p", ["promp"]),
        ("leadthrough learn recorded --angles ", ["radians", "degrees", "percent"]),
        ("leadthrough learn recorded --model promp --set w", ["weights=None", "width=1.0"]),
        ("leadthrough learn rec", REACHES),
        ("leadthrough learn recorded/reach2", ["recorded/reach2.csv"]),
        ("leadthrough plan ", ["bin/", "recorded/", "skill.npz"]),
        ("leadthrough check x.json --robot u", ["ur3", "ur3.urdf"]),
        ("leadthrough check x.json --robot p", ["panda"]),
        ("leadthrough check x.json --limits ur", ["ur3.toml"]),
        ("leadthrough check x.json --robot panda --tip panda_hand_", ["panda_hand_tcp"]),
        ("leadthrough check x.json --tip wrist", [f"wrist_{i}_link" for i in (1, 2, 3)]),
        ("leadthrough info ur3.urdf --tip too", ["tool0"]),
        ("leadthrough retime x.json --format f", ["franka"]),
        ("leadthrough check x.json --obstacle sph", ["sphere:0.1@0.5,0,0.2"]),
        ("leadthrough check x.json --obstacle me", ["mesh:"]),
        ("leadthrough check x.json --obstacle cloud:rec", [f"cloud:{each}" for each in REACHES]),
        ("leadthrough view x.json --html p", ["page.html"]),
        ("leadthrough experiment a", ["agriculture", "augmentation"]),
        ("leadthrough example ", ["reach"]),
    ],
)  # fmt: skip
def test_names_and_files_are_offered(inside, line, values):
    assert sorted(offered(line)) == sorted(values)


@pytest.mark.parametrize("shell", ["zsh", "fish"])
def test_other_shells_are_answered_in_their_own_form(inside, shell):
    words = "leadthrough learn recorded --model p"
    said = answer(
        _LEADTHROUGH_COMPLETE=f"complete_{shell}",
        _TYPER_COMPLETE_ARGS=words,
        _TYPER_COMPLETE_FISH_ACTION="get-args",
    )
    assert {"promp"} <= set(" ".join(said).replace('"', " ").split())


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_script_for_a_shell_is_shown(inside, shell):
    said = "\n".join(answer(_LEADTHROUGH_COMPLETE=f"source_{shell}"))
    assert "leadthrough" in said
    assert f"complete_{shell}" in said


@pytest.mark.skipif(shutil.which("bash") is None, reason="there is no bash")
def test_bash_completes_a_word(folder):
    script = """
    eval "$(_LEADTHROUGH_COMPLETE=source_bash leadthrough)"
    COMP_WORDS=(leadthrough learn recorded --model fa); COMP_CWORD=4
    $(complete -p leadthrough | sed 's/.*-F \\([^ ]*\\) .*/\\1/') leadthrough
    echo "${COMPREPLY[@]}"
    """
    path = f"{folder / 'bin'}:{os.environ['PATH']}"
    result = subprocess.run(
        ["bash", "-c", script],
        cwd=folder,
        check=False,
        env={**os.environ, "PATH": path},
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert result.stdout.strip() == "fast-marching", result.stderr


def test_a_faulty_profile_does_not_disturb(empty_folder):
    Path("leadthrough.toml").write_text("nonsense")
    assert offered("leadthrough check x.json --tip a") == []
    assert offered("leadthrough check x.json --mar") == ["--margin"]


def test_the_names_are_those_that_there_are():
    assert set(options.STUDIES) == set(STUDIES)
    for shape in options.SHAPES:
        assert parse.obstacle(shape)
    assert options.OBSTACLE_FILES["cloud"] == points.SUFFIXES
    assert {form.partition(":")[0] for form in parse.FORMS} == {
        *(shape.partition(":")[0] for shape in options.SHAPES),
        *options.OBSTACLE_FILES,
    }

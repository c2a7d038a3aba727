"""What README and the documentation show, run as it stands, page by page and in its order."""

import importlib.metadata
import re
import shlex
from pathlib import Path

import numpy as np
import pytest
import typer
from typer.testing import CliRunner

import leadthrough as lt
from leadthrough import cli

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
BLOCK = re.compile(r"^```(python|sh|toml)\n(.*?)^```", re.DOTALL | re.MULTILINE)
COMMANDS = typer.main.get_command(cli.app)
RUNNER = CliRunner()
LONG = ("demo", "experiment")
HOME = np.array([0.3, -1.4, 1.6, -1.8, -1.5, 0.2])
TURN = np.array([0.8, -0.4, 0.5, -0.3, 0.4, 0.6])


def blocks(page):
    return BLOCK.findall(page.read_text())


@pytest.fixture(scope="session")
def ur5(tmp_path_factory):
    """A folder as the pages have it: a URDF with its meshes, limits, and three recordings."""
    folder = tmp_path_factory.mktemp("ur5")
    (urdf,) = (
        entry.locate()
        for entry in importlib.metadata.distribution("example-robot-data").files
        if entry.name == "ur5_robot.urdf"
    )
    (folder / "ur5.urdf").write_text(urdf.read_text())
    data = next(each for each in urdf.resolve().parents if each.name == "example-robot-data")
    (folder / data.name).symlink_to(data)
    (limits,) = (text for kind, text in blocks(ROOT / "README.md") if kind == "toml")
    (folder / "ur5.toml").write_text(limits)
    (folder / "shown").mkdir()
    arm = lt.Arm.from_urdf(folder / "ur5.urdf", tip="tool0")
    rng = np.random.default_rng(0)
    share = np.linspace(0.0, 1.0, 200)
    way = 10 * share**3 - 15 * share**4 + 6 * share**5
    for number in (1, 2, 3):
        q = HOME + np.outer(way, TURN + rng.normal(0.0, 0.02, 6))
        table = np.column_stack([1.99 * share, q])
        header = ",".join(["time", *arm.joint_names])
        file = folder / "shown" / f"reach{number}.csv"
        np.savetxt(file, table, fmt="%.6f", delimiter=",", header=header, comments="")
    return folder


@pytest.fixture
def folder(ur5, tmp_path, monkeypatch):
    for each in ur5.iterdir():
        (tmp_path / each.name).symlink_to(each)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run_commands(text, variables):
    for line in text.replace("\\\n", "").splitlines():
        words = shlex.split(line, comments=True)
        if not words or words[0] == "./do":
            assert not words or f"    {words[1]})" in (ROOT / "do").read_text()
        elif assigned := re.fullmatch(r"([A-Z]+)=(.*)", words[0]):
            variables[assigned[1]] = assigned[2]
        elif words[0] == "leadthrough":
            run_command(expanded(words[1:], variables), line)
        else:
            pytest.fail(f"neither ./do nor leadthrough: {line}")


def expanded(words, variables):
    """As a shell takes them: $NAME and file names with stars."""
    for word in words:
        if word.startswith("$"):
            yield from variables[word[1:]].split()
        elif "*" in word:
            yield from sorted(map(str, Path().glob(word)))
        else:
            yield word


def run_command(words, line):
    name, *rest = words
    if name in LONG or (name == "view" and "--html" not in rest):
        # Too long, or a server: only what the words mean is looked at.
        command = COMMANDS.get_command(typer.Context(COMMANDS), name)
        command.make_context(name, rest)
        return
    result = RUNNER.invoke(cli.app, [name, *rest])
    assert result.exit_code == 0, f"{line}\n{result.output}"


@pytest.mark.parametrize(
    "page",
    [page for page in PAGES if blocks(page)],
    ids=lambda page: str(page.relative_to(ROOT)),
)
def test_page_runs_as_it_stands(page, folder):
    names, variables = {}, {}
    for kind, text in blocks(page):
        if kind == "python":
            exec(compile(text, str(page), "exec"), names)
        elif kind == "sh":
            run_commands(text, variables)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_commands_in_the_text_exist(page):
    for text in re.findall(r"`leadthrough ([^`]+)`", page.read_text()):
        words = text.split()
        command = COMMANDS.commands.get(words[0], COMMANDS)
        known = {each for parameter in command.params for each in parameter.opts} | {"--help"}
        assert command is not COMMANDS or words[0] in known, text
        assert {word for word in words if word.startswith("-")} <= known, text


def test_every_page_is_in_the_navigation():
    navigation = (ROOT / "mkdocs.yml").read_text()
    for page in PAGES[1:]:
        assert str(page.relative_to(ROOT / "docs")) in navigation


@pytest.mark.parametrize(
    "stage", ["", "arm", "models", "planning", "preprocess", "rotations", "timing", "trajectories"]
)
def test_public_names_are_in_the_reference(stage):
    reference = "".join(page.read_text() for page in (ROOT / "docs" / "api").glob("*.md"))
    package = getattr(lt, stage) if stage else lt
    for name in package.__all__:
        if callable(getattr(package, name)):
            found = re.search(rf"^::: leadthrough\.(\w+\.)?{name}$", reference, re.MULTILINE)
            assert found, name

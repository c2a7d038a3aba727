"""README, documentation and notebooks, run as they stand and type-checked, page by page."""

import ast
import importlib
import importlib.util
import json
import os
import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

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


def blocks(page):
    return BLOCK.findall(page.read_text())


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run_commands(text, variables):
    for line in text.replace("\\\n", "").splitlines():
        words = shlex.split(line, comments=True)
        if not words or words[0] == "./do":
            assert not words or f"    {words[1]})" in (ROOT / "do").read_text()
        elif assigned := re.fullmatch(r"([A-Z]+)=(.*)", words[0]):
            variables[assigned[1]] = assigned[2]
        elif words[0] == "cd":
            os.chdir(words[1])
        elif words[0] == "leadthrough":
            run_command([*expanded(words[1:], variables)], line)
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
    name, *rest = words[1:] if words[0].startswith("-") else words
    if name in LONG or (name == "view" and "--html" not in rest):
        # Too long, or a server: only what the words mean is looked at.
        command = COMMANDS.get_command(typer.Context(COMMANDS), name)
        command.make_context(name, rest)
        return
    result = RUNNER.invoke(cli.app, words)
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


@pytest.mark.parametrize("page", ["README.md", "docs/guide/index.md"])
def test_the_profile_on_a_page_is_that_of_the_example(page, folder):
    (shown,) = (text for kind, text in blocks(ROOT / page) if kind == "toml")
    assert RUNNER.invoke(cli.app, ["example", "reach", "."]).exit_code == 0
    assert tomllib.loads(shown) == tomllib.loads(Path("leadthrough.toml").read_text())


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_commands_in_the_text_exist(page):
    for text in re.findall(r"`leadthrough ([^`]+)`", page.read_text()):
        words = text.split()
        command = COMMANDS.commands.get(words[0], COMMANDS)
        known = {each for parameter in command.params for each in parameter.opts} | {"--help"}
        assert command is not COMMANDS or words[0] in known, text
        assert {word for word in words if word.startswith("-")} <= known, text


LINK = re.compile(r"(?<!\\)\]\(([^)\s]+)\)")
TEXTS = [*PAGES, *(ROOT / f"{name}.md" for name in ("CONTRIBUTING", "CHANGELOG", "SECURITY"))]

# Pages that are made when the documentation is built.
MADE = {
    *(ROOT / "docs" / "demos" / f"{demo.stem}.md" for demo in (ROOT / "python/demos").glob("*.py")),
    *(ROOT / "docs" / "notebooks" / f"{each.stem}.md"
      for each in (ROOT / "python/notebooks").glob("*.ipynb")),
}  # fmt: skip


def anchors(page):
    """Where links into a page lead: its headings, and the names that an API page documents."""
    text = page.read_text()
    for heading in re.findall(r"^#+ (.+)$", text, re.MULTILINE):
        yield (
            re.sub(r"[^\w\- ]", "", re.sub(r"[`*]", "", heading.lower())).strip().replace(" ", "-")
        )
    yield from re.findall(r"^::: ([\w.]+)$", text, re.MULTILINE)


@pytest.mark.parametrize("page", TEXTS, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_and_pictures_lead_somewhere(page):
    for link in LINK.findall(re.sub(r"```.*?```", "", page.read_text(), flags=re.DOTALL)):
        target, _, anchor = link.partition("#")
        if "://" in link:
            continue
        found = page.parent / target if target else page
        assert found.exists() or found.resolve() in MADE, link
        if anchor and found.suffix == ".md" and found.exists():
            there = set(anchors(found))
            assert any(anchor == each or anchor.startswith(f"{each}.") for each in there), link


def test_version_is_the_same_everywhere():
    version = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
    assert lt.__version__ == version
    assert f"\nversion: {version}\n" in (ROOT / "CITATION.cff").read_text()
    changelog = (ROOT / "CHANGELOG.md").read_text()
    (first,) = re.findall(r"\A# Changelog.*?^## (\S+)", changelog, re.DOTALL | re.MULTILINE)
    assert first in ("Unreleased", version)
    assert first == version or f"This will be {version}" in changelog


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
    for name in dir(package):
        if callable(getattr(package, name)) and not name.startswith("_"):
            found = re.search(rf"^::: leadthrough\.(\w+\.)?{name}$", reference, re.MULTILINE)
            assert found, name


def messages():
    """All texts in the package's code; … stands for what is put in."""
    for path in (ROOT / "python" / "leadthrough").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.JoinedStr):
                parts = (p.value if isinstance(p, ast.Constant) else "…" for p in node.values)
                yield "".join(parts)
            elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                yield node.value


def test_messages_in_the_troubleshooting_are_those_of_the_code():
    page = (ROOT / "docs" / "guide" / "troubleshooting.md").read_text()
    quoted = re.findall(r"^### `(.+?)`(?:$| )", page, re.MULTILINE)
    known = "\n".join(messages())
    assert len(quoted) > 15
    for message in quoted:
        assert message in known, message


@pytest.fixture
def benchmarks(monkeypatch):
    """The modules `printed` and `frame` of the benchmarks."""
    monkeypatch.setattr(sys, "path", [str(ROOT / "python" / "benchmarks"), *sys.path])
    yield importlib.import_module("printed"), importlib.import_module("frame")
    for name in ("printed", "frame"):
        sys.modules.pop(name)


def measured(printed, frame, ratio, error):
    """A row for every pattern of the table."""
    rows = []
    for line in printed._LINES:
        for pattern in line["of"]:
            name, _, peer = pattern.partition("@")
            answer = (name.replace("*", "x"), peer or "peer", error, 1.0, True)
            rows.append(frame.Row(*answer, ratio=ratio))
    return rows


def test_a_printed_table_holds_until_a_figure_is_over_15_percent_better_than_measured(benchmarks):
    printed, frame = benchmarks
    page = f"text\n\n{printed.table(measured(printed, frame, 10.0, 0.5))}<!-- end -->\n"
    assert printed.too_good(page, measured(printed, frame, 8.8, 0.57)) == []
    slower = printed.too_good(page, measured(printed, frame, 8.6, 0.5))
    assert len(slower) == sum(len(line["of"]) for line in printed._LINES)
    assert "10 is printed, 8.6 measured" in slower[0]
    worse = printed.too_good(page, measured(printed, frame, 10.0, 0.6))
    assert len(worse) == sum("{error}" in line["problem"] for line in printed._LINES)
    cut = printed.too_good(re.sub(r"\| slerp.*\n", "", page), measured(printed, frame, 10.0, 0.5))
    assert "rows are printed" in cut[0]


def test_the_page_on_speed_has_the_rows_of_the_table(benchmarks):
    printed, frame = benchmarks
    faults = printed.too_good(
        (ROOT / "docs" / "speed.md").read_text(), measured(printed, frame, 1e6, 0.0)
    )
    assert faults == []


NOTEBOOKS = sorted((ROOT / "python" / "notebooks").glob("*.ipynb"))


@pytest.fixture(scope="module")
def shown():
    file = ROOT / "docs" / "hooks" / "notebooks.py"
    spec = importlib.util.spec_from_file_location("notebooks", file)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.shown


def test_there_are_three():
    assert len(NOTEBOOKS) == 3


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_runs_and_shows_skills_and_scenes_inline(notebook, shown):
    page = "\n".join(shown(notebook))
    assert page.count("<svg") >= 2
    assert page.count("<iframe") == (0 if "which_model" in notebook.name else 1)


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_is_kept_without_results(notebook):
    cells = json.loads(notebook.read_text())["cells"]
    assert all(not cell.get("outputs") for cell in cells)


PACKAGE = Path(lt.__file__).parent
TYPED_PAGES = [ROOT / "README.md", *sorted((ROOT / "docs" / "guide").glob("*.md"))]
PYTHON = re.compile(r"^```python\n(.*?)^```", re.DOTALL | re.MULTILINE)


def scripts(folder):
    """A script of each page's examples, in their order and on the page's own lines."""
    for page in TYPED_PAGES:
        text = page.read_text()
        if PYTHON.search(text):
            script = folder / f"{page.stem}.py"
            script.write_text(python_of(text))
            yield script


def python_of(text):
    """The text with its Python blocks alone; all other lines are blank."""
    kept, end = "", 0
    for block in PYTHON.finditer(text):
        kept += "\n" * text.count("\n", end, block.start(1)) + block[1]
        end = block.end(1)
    return kept


def test_examples_pass_mypy_strict(tmp_path):
    paths = [str(path) for path in scripts(tmp_path)]
    assert len(paths) > 3
    # As in a project of a user's: without our configuration, the package's types as they are.
    options = ["--strict", "--config-file=", "--follow-imports=silent", "--cache-dir"]
    result = subprocess.run(
        [sys.executable, "-m", "mypy", *options, str(ROOT / "build" / "mypy-examples"), *paths],
        cwd=tmp_path,
        env=os.environ | {"MYPYPATH": str(PACKAGE.parent)},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert result.returncode == 0, result.stdout + result.stderr
    assert (PACKAGE / "py.typed").is_file()

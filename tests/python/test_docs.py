"""What README and the documentation show, run as it stands, page by page and in its order."""

import ast
import os
import re
import shlex
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
    for name in package.__all__:
        if callable(getattr(package, name)):
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

"""The tree in CONTRIBUTING.md against the repository, and the length of every file."""

import pytest
from stages import ROOT, TREE

# Every folder and module in these is shown, but for what a package needs and what is built.
COMPLETE = ("cpp", "python", "python/leadthrough", "python/leadthrough/models", "tests")
OF_EVERY_PACKAGE = {"__init__.py", "__init__.pyi", "_core.pyi", "__pycache__", "robots"}
CODE = (".py", ".js", ".css", ".cpp", ".hpp", ".sh")
LONGEST = 600  # lines
FILES = [
    path
    for folder in ("cpp", "docs", "python", "tests")
    for path in sorted((ROOT / folder).rglob("*"))
    if path.suffix in CODE
]


def test_everything_in_the_tree_exists():
    for path in TREE:
        found = ROOT / path
        assert found.is_dir() if path.endswith("/") else found.is_file(), path


@pytest.mark.parametrize("folder", COMPLETE)
def test_every_folder_and_module_is_in_the_tree(folder):
    drawn = {path.rstrip("/") for path in TREE}
    for path in (ROOT / folder).iterdir():
        if path.name in OF_EVERY_PACKAGE or path.name.startswith("."):
            continue
        is_module = folder == "python/leadthrough" and path.suffix == ".py"
        if path.is_dir() or is_module:
            assert str(path.relative_to(ROOT)) in drawn, f"{path} is not in CONTRIBUTING.md"


def test_no_file_is_too_long_to_be_read_at_once():
    assert len(FILES) > 300
    lengths = {
        str(path.relative_to(ROOT)): len(path.read_text(encoding="utf-8").splitlines())
        for path in FILES
    }
    assert {path: lines for path, lines in lengths.items() if lines > LONGEST} == {}

"""The tree in CONTRIBUTING.md against the repository; length and imports of every file."""

import re
import tomllib

import pytest
from stages import ROOT, TREE
from test_imports import FILES as MODULES
from test_imports import PACKAGE, modules_imported

# Every folder and module in these is shown, but for what a package needs and what is built.
COMPLETE = ("cpp", "python", "python/leadthrough", "python/leadthrough/models", "tests")
OF_EVERY_PACKAGE = {"__init__.py", "__init__.pyi", "_core.pyi", "__pycache__", "robots"}
CODE = (".py", ".js", ".css", ".cpp", ".hpp", ".sh")
MAX_LINES = 600
# Own modules that a file imports, for types and inside functions too. The files that still import
# more shrink in number and in what they import, until there are none.
MAX_IMPORTS, MAX_EXCEPTIONS, MAX_IMPORTS_OF_EXCEPTIONS = 10, 25, 18
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
    assert {path: lines for path, lines in lengths.items() if lines > MAX_LINES} == {}


def own_modules_imported(path):
    """The modules of the package that a file imports, by their dotted names."""
    package = ["leadthrough", *path.relative_to(PACKAGE).parts[:-1]]
    names = {each.relative_to(PACKAGE.parent).with_suffix("") for each in MODULES}
    known = {".".join(name.parts).removesuffix(".__init__") for name in names}
    own = set()
    for parts in modules_imported(path.read_text(encoding="utf-8"), package):
        whole, outer = ".".join(parts), ".".join(parts[:-1])
        own |= {whole} & known or {outer} & known
    return own - {"leadthrough"}


def test_few_files_import_more_than_ten_modules_of_our_own():
    counts = {
        str(path.relative_to(PACKAGE)): len(own_modules_imported(path))
        for path in MODULES
        if path.stem != "__init__"
    }
    many = {path: count for path, count in counts.items() if count > MAX_IMPORTS}
    assert len(many) <= MAX_EXCEPTIONS, many
    assert max(many.values(), default=0) <= MAX_IMPORTS_OF_EXCEPTIONS, many


def test_parts_to_mutate_name_files_that_exist():
    parts = tomllib.loads((ROOT / "tests" / "mutants" / "parts.toml").read_text(encoding="utf-8"))
    for part, named in parts.items():
        for pattern in (*named["sources"], *named["tests"]):
            assert any(ROOT.glob(pattern)), f"{part}: {pattern}"


# Names in the sources of the examples of "How to add".
EXAMPLES = {
    "A shape": r"\bk?Cylinder\b",
    "A model": r"ModifiedDS|modified_ds",
    "A file format": r"\brobomimic\b",
    "An arm": r"\btiago\b",
}


@pytest.mark.parametrize(("title", "example"), EXAMPLES.items())
def test_how_to_add_lists_the_files_that_mention_its_example(title, example):
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    section = re.search(rf"^### {title}\n(.*?)^##", text, re.DOTALL | re.MULTILINE)[1]
    listed = set(re.findall(r"`([\w/.-]+/[\w.-]+)`", section))
    for path in listed:
        assert (ROOT / path).exists(), path
    sources = [*(ROOT / "cpp").rglob("*.?pp"), *PACKAGE.rglob("*.py"), *PACKAGE.rglob("*.pyi")]
    sources += (ROOT / "robots").rglob("*.*")
    mentioning = {
        str(path.relative_to(ROOT))
        for path in sources
        if re.search(example, path.read_text(encoding="utf-8"))
    }
    assert (
        mentioning - {"python/leadthrough/cli/showing.py"} <= listed
    )  # that has arms in a sentence

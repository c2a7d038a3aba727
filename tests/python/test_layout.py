"""The tree in CONTRIBUTING.md against the repository; length and imports of every file."""

import re
import tomllib
from graphlib import TopologicalSorter
from itertools import chain
from pathlib import Path

import pytest
from stages import ROOT, TREE
from test_imports import FILES as MODULES, PACKAGE, modules_imported

# Every folder and module in these is shown, but for what a package needs and what is built.
COMPLETE = (
    "cpp",
    "cpp/leadthrough",
    "python",
    "python/leadthrough",
    "python/leadthrough/models",
    "tests",
)
OF_EVERY_PACKAGE = {"__init__.py", "__init__.pyi", "_core.pyi", "__pycache__", "robots"}
CODE = (".py", ".js", ".css", ".cpp", ".hpp", ".sh")
MAX_LINES = 600
# Own modules that a file imports, for types and inside functions too. The files that still import
# more shrink in number and in what they import, until there are none.
MAX_IMPORTS, MAX_EXCEPTIONS, MAX_IMPORTS_OF_EXCEPTIONS = 10, 14, 14
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
    sources += (path for path in (ROOT / "robots").rglob("*.*") if path.suffix != ".stl")
    mentioning = {
        str(path.relative_to(ROOT))
        for path in sources
        if re.search(example, path.read_text(encoding="utf-8"))
    }
    assert (
        mentioning - {"python/leadthrough/cli/showing.py"} <= listed
    )  # that has arms in a sentence


ROOT = Path(__file__).parents[2]
ROW = re.compile(r"^\| `(\w+)/` \|.*\| ([^|]*) \|$", re.MULTILINE)
INCLUDE = re.compile(r'^#include "(?:leadthrough/)?(\w+)/\w+\.hpp"$', re.MULTILINE)
ANY_INCLUDE = re.compile(r'^#include "', re.MULTILINE)


def allowed() -> dict[str, set[str]]:
    """Folders that each folder may include besides itself."""
    rows = dict(ROW.findall((ROOT / "cpp/README.md").read_text()))
    return {
        folder: set(rows) if names == "all" else set(re.findall(r"`(\w+)`", names))
        for folder, names in rows.items()
    }


def sources(root: str) -> list[Path]:
    within = ROOT / root / "leadthrough"  # its own files use all folders
    found = chain((ROOT / root).glob("*/*.[ch]pp"), within.glob("*/*.[ch]pp"))
    return sorted(path for path in found if path.parent != within)


def test_the_table_names_every_folder() -> None:
    assert set(allowed()) == {path.parent.name for path in sources("cpp")}
    assert {path.parent.name for path in sources("tests/cpp")} <= set(allowed())


def test_the_table_has_no_circle() -> None:
    graph = {folder: names - {folder} for folder, names in allowed().items()}
    TopologicalSorter(graph).prepare()


@pytest.mark.parametrize("root", ["cpp", "tests/cpp"])
def test_includes_are_written_from_the_root(root: str) -> None:
    for path in sources(root):
        text = path.read_text()
        assert len(ANY_INCLUDE.findall(text)) == len(INCLUDE.findall(text)), path


def test_folders_include_what_the_table_allows() -> None:
    table = allowed()
    for path in sources("cpp"):
        folder = path.parent.name
        used = set(INCLUDE.findall(path.read_text())) - {folder}
        assert used <= table[folder], f"{path}: {sorted(used - table[folder])} not allowed"


def test_every_source_is_listed_for_the_build() -> None:
    for root in ("cpp", "tests/cpp"):
        for path in sources(root):
            if path.suffix == ".cpp":
                list_file = next(
                    parent / "CMakeLists.txt"
                    for parent in path.parents
                    if (parent / "CMakeLists.txt").is_file()
                )
                name = path.relative_to(list_file.parent).as_posix()
                assert re.search(rf"\b{re.escape(name)}\b", list_file.read_text()), path


def test_public_headers_include_public_headers_alone() -> None:
    folder = ROOT / "cpp/leadthrough"
    public = set(folder.glob("*.hpp"))
    for list_file in folder.glob("*/CMakeLists.txt"):
        headers = list_file.read_text().partition("SOURCES")[0]
        public |= {list_file.parent / name for name in re.findall(r"\w+\.hpp", headers)}
    for path in public:
        for name in re.findall(r'#include "leadthrough/(.*)"', path.read_text()):
            assert folder / name in public, f"{path} includes {name}"


def test_other_libraries_stay_where_they_are_read() -> None:
    homes = {
        "kdl/": {"leadthrough/arm/dynamics.cpp"},
        "urdf_parser/": {"leadthrough/arm/urdf.cpp"},
        "pybind11/": {
            f"bind/{path.name}" for path in (ROOT / "cpp/bind").iterdir() if path.suffix != ".txt"
        },
    }
    for path in sources("cpp"):
        name = path.relative_to(ROOT / "cpp").as_posix()
        for library, home in homes.items():
            assert f"#include <{library}" not in path.read_text() or name in home, path


def test_the_docs_show_the_example_of_the_package() -> None:
    page = (ROOT / "docs/guide/cpp.md").read_text()
    example = ROOT / "cpp/package/example"
    assert (example / "CMakeLists.txt").read_text() in page
    shown = re.findall(r"```cpp\n(.*?)```", page, re.DOTALL)
    assert len(shown) == 2
    lines = [line.strip() for each in shown for line in each.splitlines()]
    program = (example / "reach.cpp").read_text()
    assert all(line in program for line in lines)


def test_a_wheel_is_tried_with_the_machines_mirror_and_no_host_is_named():
    for file in ("python/wheel/try_in", ".github/workflows/release.yml"):
        assert not re.findall(r"https?://\S+", (ROOT / file).read_text(encoding="utf-8")), file

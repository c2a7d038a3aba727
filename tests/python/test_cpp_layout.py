"""The folders of the C++ core include each other in one direction, as cpp/README.md says."""

import re
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
ROW = re.compile(r"^\| `(\w+)/` \|.*\| ([^|]*) \|$", re.MULTILINE)
INCLUDE = re.compile(r'^#include "(\w+)/\w+\.hpp"$', re.MULTILINE)
ANY_INCLUDE = re.compile(r'^#include "', re.MULTILINE)


def allowed() -> dict[str, set[str]]:
    """Folders that each folder may include besides itself."""
    rows = dict(ROW.findall((ROOT / "cpp/README.md").read_text()))
    return {
        folder: set(rows) if names == "all" else set(re.findall(r"`(\w+)`", names))
        for folder, names in rows.items()
    }


def sources(root: str) -> list[Path]:
    return sorted((ROOT / root).glob("*/*.[ch]pp"))


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


def test_other_libraries_stay_where_they_are_read() -> None:
    homes = {
        "kdl/": {"arm/dynamics.cpp"},
        "urdf_parser/": {"arm/urdf.cpp"},
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
    shown = re.search(r"```cpp\n(.*?)```", page, re.DOTALL)
    assert shown
    lines = [line.strip() for line in shown.group(1).splitlines()]
    program = (example / "reach.cpp").read_text()
    assert all(line in program for line in lines)

"""Data flow one way, and walls: a stage imports only what stands left of it, no family another."""

import ast
import re
from pathlib import Path

import pytest
from stages import FAMILIES, STAGES

import leadthrough
import leadthrough_studies

ROOT = Path(__file__).parents[2]
PACKAGE = Path(leadthrough.__file__).parent
STUDIES = Path(leadthrough_studies.__file__).parent
# Files of the hall of models/ that know every family: what skills there are, and who holds them.
OVER_FAMILIES = {"__init__", "skills", "library"}
FREE = {"_core"}  # the compiled kernels know nothing of Python's stages
# Users of the package, which see what is on the pages of the reference.
USERS = [
    *STUDIES.rglob("*.py"),
    *(ROOT / "python" / "benchmarks").glob("*.py"),
    *(ROOT / "python" / "demos").glob("[0-9]*.py"),
]
REFERENCE = {
    name
    for page in (ROOT / "docs" / "api").glob("*.md")
    for name in re.findall(r"^::: (leadthrough\S+)$", page.read_text(), re.MULTILINE)
}
TESTS = sorted((ROOT / "tests" / "python").rglob("*.py"))
# Test files that import names without a public path outside of internal/, which shrink in number,
# and those in folders internal/.
MAX_PRIVATE, MAX_INTERNAL = 38, 30
TYPES = ("check", "errors", "motion", "shapes")
FILES = sorted(path for path in PACKAGE.rglob("*.py") if path != PACKAGE / "__init__.py")


def modules_imported(source, package):
    """Names of modules, as tuples, that a module imports, anywhere in it; `package`: its own."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (tuple(alias.name.split(".")) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else []
            base = [*base, *(node.module or "").split(".")] if node.module else base
            yield from ((*base, alias.name) for alias in node.names)


def stage_of(path):
    first = path.relative_to(PACKAGE).parts[0]
    return first.removesuffix(".py")


def imported_stages(source, package):
    """Stages that a module imports, anywhere in it; `package` is the one it lies in, by names."""
    for module in modules_imported(source, package):
        if module[0] == "leadthrough":
            yield module[1] if len(module) > 1 else "the whole package"
        elif module[0] == "leadthrough_studies":
            yield module[0]


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_a_stage_imports_nothing_to_its_right(path):
    stage = stage_of(path)
    assert stage in STAGES, f"{stage} is no stage; put the file where the design has a room for it"
    package = ["leadthrough", *path.relative_to(PACKAGE).parts[:-1]]
    allowed = {*STAGES[: STAGES.index(stage)], stage, *FREE}
    if stage == "cli":
        allowed |= {"leadthrough_studies", "the whole package"}  # its public names
    wrong = set(imported_stages(path.read_text(), package)) - allowed
    assert not wrong, f"{stage} imports {wrong}"


@pytest.mark.parametrize("path", sorted((PACKAGE / "models").rglob("*.py")), ids=lambda p: p.stem)
def test_no_family_of_models_imports_another(path):
    own = path.relative_to(PACKAGE / "models").parts[:-1]
    if not own and path.stem in OVER_FAMILIES:
        return
    package = ["leadthrough", "models", *own]
    imported = {
        module[2]
        for module in modules_imported(path.read_text(), package)
        if module[:2] == ("leadthrough", "models") and len(module) > 2
    }
    above = OVER_FAMILIES - {"__init__"}
    wrong = imported & ({*FAMILIES, *above} - set(own))
    assert not wrong, f"{path.name} imports {wrong}"


@pytest.mark.parametrize("path", USERS, ids=lambda path: path.name)
def test_studies_benchmarks_and_demos_use_public_names_only(path):
    # Kernels that only a study calls are in the core, like all kernels.
    core = ("leadthrough", "_core") if path.is_relative_to(STUDIES) else None
    private = {
        module
        for module in modules_imported(path.read_text(), ["leadthrough_studies", path.parent.name])
        if module[0] == "leadthrough" and not is_public(module) and module != core
    }
    assert not private, f"{path.name} imports {private}"


def test_tests_of_private_names_are_in_folders_named_internal():
    private = [
        path
        for path in TESTS
        for module in modules_imported(path.read_text(), ["tests"])
        if module[0] == "leadthrough" and not is_public(module)
    ]
    outside = {path for path in private if "internal" not in path.parts}
    assert len(outside) <= MAX_PRIVATE, sorted(outside)
    assert sum(path.parent.name == "internal" for path in TESTS) <= MAX_INTERNAL


def is_public(module):
    """Whether a name of the package, as a tuple, is on a page of the reference or a plain type."""
    if len(module) == 1 or module[1] in TYPES or (len(module) == 2 and module[1] in STAGES):
        return True
    return any(".".join(module[:count]) in REFERENCE for count in range(2, len(module) + 1))


def test_every_way_to_import_is_seen():
    source = """
import leadthrough.cli
import leadthrough
from leadthrough import io
from leadthrough.arm import limits
from .. import models
from ..planning.grid import Grid
from leadthrough_studies import study
from . import resample
def lazy():
    from leadthrough.show import plot
"""
    found = sorted(set(imported_stages(source, ["leadthrough", "preprocess"])))
    stages = "arm cli io leadthrough_studies models planning preprocess show the whole package"
    assert " ".join(found) == stages

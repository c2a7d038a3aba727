"""Data flow one way, and walls: a stage imports only what stands left of it, no family another."""

import ast
from pathlib import Path

import pytest

import leadthrough
import leadthrough_studies

PACKAGE = Path(leadthrough.__file__).parent
STUDIES = Path(leadthrough_studies.__file__).parent
STAGES = (
    "errors",
    "optional",
    "check",
    "events",
    "rotations",
    "motion",
    "shapes",
    "io",
    "preprocess",
    "trajectories",
    "planning",
    "models",
    "arm",
    "timing",
    "show",
    "cli",
)
FAMILIES = ("dmp", "promp", "mixtures", "marching")
# Files of the hall of models/ that know every family: what skills there are, and who holds them.
OVER_FAMILIES = {"__init__", "skills", "library"}
FREE = {"_core"}  # the compiled kernels know nothing of Python's stages
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
        allowed.add("leadthrough_studies")
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


def test_studies_import_only_public_names_of_the_package():
    for path in STUDIES.rglob("*.py"):
        package = ["leadthrough_studies", *path.relative_to(STUDIES).parts[:-1]]
        private = [
            module
            for module in modules_imported(path.read_text(), package)
            if module[0] == "leadthrough" and any(name.startswith("_") for name in module[1:])
        ]
        assert private in ([], [("leadthrough", "_core")]), f"{path.name} imports {private}"


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
    assert set(imported_stages(source, ["leadthrough", "preprocess"])) == {
        "cli",
        "leadthrough_studies",
        "the whole package",
        "io",
        "arm",
        "models",
        "planning",
        "preprocess",
        "show",
    }

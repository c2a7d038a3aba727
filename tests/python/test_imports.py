"""Data flow one way: a stage imports only what stands left of it."""

import ast
from pathlib import Path

import pytest

import leadthrough

PACKAGE = Path(leadthrough.__file__).parent
STAGES = (
    "errors",
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
    "experiments",
    "cli",
)
FREE = {"_core"}  # the compiled kernels know nothing of Python's stages
FILES = sorted(path for path in PACKAGE.rglob("*.py") if path != PACKAGE / "__init__.py")


def stage_of(path):
    first = path.relative_to(PACKAGE).parts[0]
    return first.removesuffix(".py")


def imported_stages(source, package):
    """Stages that a module imports, anywhere in it; `package` is the one it lies in, by names."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            modules = [alias.name.split(".") for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else []
            base = [*base, *(node.module or "").split(".")] if node.module else base
            modules = [[*base, alias.name] for alias in node.names]
        else:
            continue
        for module in modules:
            if module[0] == "leadthrough":
                yield module[1] if len(module) > 1 else "the whole package"


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_a_stage_imports_nothing_to_its_right(path):
    stage = stage_of(path)
    assert stage in STAGES, f"{stage} is no stage; put the file where the design has a room for it"
    package = ["leadthrough", *path.relative_to(PACKAGE).parts[:-1]]
    allowed = {*STAGES[: STAGES.index(stage)], stage, *FREE}
    wrong = set(imported_stages(path.read_text(), package)) - allowed
    assert not wrong, f"{stage} imports {wrong}"


def test_every_way_to_import_is_seen():
    source = """
import leadthrough.cli
import leadthrough
from leadthrough import io
from leadthrough.arm import limits
from .. import models
from ..planning.grid import Grid
from . import resample
def lazy():
    from leadthrough.show import plot
"""
    assert set(imported_stages(source, ["leadthrough", "preprocess"])) == {
        "cli",
        "the whole package",
        "io",
        "arm",
        "models",
        "planning",
        "preprocess",
        "show",
    }

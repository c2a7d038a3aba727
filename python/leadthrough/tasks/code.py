"""Source files that a function depends on, read off their imports, and a digest of them.

An edit of any other file leaves the digest as it is. Packages that load their names lazily from a
stub are followed name by name. Display of results is left out, and so is this engine.
"""

from __future__ import annotations

import ast
import hashlib
import platform
import sys
import sysconfig
from collections.abc import Iterator
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path

_OWN = ("leadthrough", "leadthrough_studies")
# Code that only displays rows, or hands them on; of the studies also every module `report`.
_WITHOUT_INFLUENCE = (
    *(f"leadthrough.{name}" for name in ("cli", "drawing", "show", "tasks")),
    *(f"leadthrough_studies.{name}" for name in ("results", "study")),
)
# The module that reads the robots' descriptions.
_READS_ROBOTS = "leadthrough.arm.robot_files"
_CORE = "_core"
# Fields of statements inside a statement; expressions, most of a source, import nothing.
_BLOCKS = ("body", "handlers", "orelse", "finalbody", "cases")


@cache
def digest(module: str) -> str:
    """A text that changes with the code that a module imports, directly or not.

    The code is that of leadthrough and of every module outside the installed packages, with the
    compiled core, the robots' files, and the versions of Python, NumPy and SciPy.

    Args:
        module: full name of the module.
    """
    versions = " ".join(f"{name} {_version(name)}" for name in ("numpy", "scipy"))
    total = hashlib.sha256(f"{platform.python_version()} {versions}".encode())
    for name, path in sorted(sources(module).items()):
        total.update(name.encode())
        total.update(path.read_bytes())
    return total.hexdigest()[:16]


@cache
def sources(module: str) -> dict[str, Path]:
    """The files that a module depends on, by the names of their modules."""
    found: dict[str, Path] = {}
    waiting = [module]
    own = {*_OWN, module.partition(".")[0]}
    while waiting:
        name = waiting.pop()
        if name in found or _only_displays(name):
            continue
        path = _file_of(name)
        if path is None or not _is_own(name, path, own):
            continue
        found[name] = path
        waiting += [name.rpartition(".")[0]] if "." in name else []
        waiting += _dependencies(name, path) if path.suffix == ".py" else []
    if _READS_ROBOTS in found:
        found |= _robots()
    return found


def _only_displays(name: str) -> bool:
    own, _, last = name.rpartition(".")
    report = own.startswith("leadthrough_studies.") and last == "report"
    return report or any(name == each or name.startswith(f"{each}.") for each in _WITHOUT_INFLUENCE)


def _is_own(name: str, path: Path, own: set[str]) -> bool:
    return name.partition(".")[0] in own or not any(
        path.is_relative_to(folder) for folder in _installed()
    )


@cache
def _installed() -> tuple[Path, ...]:
    names = ("stdlib", "platstdlib", "purelib", "platlib")
    given = (Path(sysconfig.get_path(name)) for name in names)
    # Those that an installer was told to put elsewhere, such as `pip install --target`.
    other = (Path(each) for each in sys.path if any(Path(each).glob("*.dist-info")))
    return (*given, *other)


def _robots() -> dict[str, Path]:
    # An editable install has two places: the sources, and the folder of the built module.
    package = find_spec("leadthrough")
    places = package.submodule_search_locations if package else None
    return {
        path.relative_to(place).as_posix(): path
        for place in map(Path, places or ())
        for path in (place / "robots").rglob("*")
        if path.is_file()
    }


@cache
def _file_of(module: str) -> Path | None:
    """The file of a module; None for what is built in, a plain folder or not there."""
    top, *rest = module.split(".")
    loaded = getattr(sys.modules.get(module), "__file__", None)
    if loaded:
        return Path(loaded)
    try:
        spec = find_spec(top)
    except (ImportError, ValueError):
        return None
    if spec is None:
        return None
    origin = spec.origin if spec.has_location else None
    folders = [Path(each) for each in spec.submodule_search_locations or ()]
    for part in rest:
        origin, folders = _inside(folders, part)
    return Path(origin) if origin else None


def _inside(folders: list[Path], name: str) -> tuple[str | None, list[Path]]:
    """The file of a module in one of several folders, and the folders of its own modules."""
    for folder in folders:
        if (package := folder / name / "__init__.py").is_file():
            return str(package), [package.parent]
        if (file := folder / f"{name}.py").is_file():
            return str(file), []
        if name == _CORE and (compiled := sorted(folder.glob(f"{_CORE}.*.so"))):
            return str(compiled[0]), []
    return None, [folder / name for folder in folders if (folder / name).is_dir()]


def _dependencies(module: str, path: Path) -> list[str]:
    """Names of the modules that a file imports; many of them may be no own ones."""
    package = module if path.name == "__init__.py" else module.rpartition(".")[0]
    found: list[str] = []
    for target, names in _imports(path, package):
        found.append(target)
        for name in names:
            found += _behind(target, name.split("."))
    return found


def _behind(module: str, names: list[str]) -> list[str]:
    """The modules that `names`, taken one after the other from a module, lead to."""
    if not names:
        return list(_stub(module).values())
    first, *rest = names
    inside = f"{module}.{first}"
    if _file_of(inside) is not None:
        return [inside, *_behind(inside, rest)]
    if (target := _stub(module).get(first)) is None:
        return []
    behind = [target]
    if target != inside:
        behind += _behind(target, [first, *rest])
    return behind


@cache
def _stub(package: str) -> dict[str, str]:
    """By the names of a package that loads them lazily: the modules that define them."""
    path = _file_of(package)
    if path is None or path.name != "__init__.py":
        return {}
    if "attach_stub" not in path.read_text(encoding="utf-8"):
        return {}
    return {
        name: target if _file_of(f"{target}.{name}") is None else f"{target}.{name}"
        for target, names in _imports(path.with_suffix(".pyi"), package)
        for name in names
    }


@cache
def _imports(path: Path, package: str) -> list[tuple[str, list[str]]]:
    """Modules that a source imports, anywhere in it, and which names it takes from them."""
    return list(_imported_by(ast.parse(path.read_bytes()), package))


def _imported_by(tree: ast.Module, package: str) -> Iterator[tuple[str, list[str]]]:
    for node in _running(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                bound = alias.name if alias.asname else alias.name.partition(".")[0]
                yield alias.name, []
                if bound.partition(".")[0] in _OWN:
                    yield bound, _taken(tree, alias.asname or bound)
        elif isinstance(node, ast.ImportFrom):
            parts = package.split(".")
            base = parts[: len(parts) - node.level + 1] if node.level else []
            target = ".".join([*base, *([node.module] if node.module else [])])
            yield target, [alias.name for alias in node.names]


def _running(block: ast.AST) -> Iterator[ast.AST]:
    """All statements in a block but those that only type checkers see."""
    for part in _BLOCKS:
        for inside in getattr(block, part, ()):
            test = inside.test if isinstance(inside, ast.If) else None
            if not (isinstance(test, ast.Name) and test.id == "TYPE_CHECKING"):
                yield inside
                yield from _running(inside)


def _taken(tree: ast.Module, alias: str) -> list[str]:
    """Names that a source takes from a module by dots, such as "models.DMP" of `lt.models.DMP`."""
    chains = (_chain(node) for node in ast.walk(tree) if isinstance(node, ast.Attribute))
    return sorted({".".join(chain[1:]) for chain in chains if chain[:1] == [alias]})


def _chain(node: ast.AST) -> list[str]:
    names: list[str] = []
    while isinstance(node, ast.Attribute):
        names.insert(0, node.attr)
        node = node.value
    return [node.id, *names] if isinstance(node, ast.Name) else []


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"

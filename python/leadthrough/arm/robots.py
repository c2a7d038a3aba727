"""Robots by their names: those that come with the package, and those of packages of robots."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from importlib import import_module, metadata
from importlib.util import find_spec
from pathlib import Path

from leadthrough.errors import InvalidInput

_PACKAGES = "example-robot-data or robot_descriptions"


@dataclass(frozen=True)
class RobotFiles:
    """Where a robot's files are."""

    urdf: Path  # the robot description
    limits: Path | None = None  # the limits file; None if there is none
    mesh_folders: tuple[Path, ...] = ()  # where its meshes are looked for besides


def find_robot(name: str) -> RobotFiles:
    """The files of a robot."""
    if isinstance(name, str):
        _refuse_path(name)
        for search in (_own, _of_example_robot_data, _of_robot_descriptions):
            if found := search(name):
                return found
    names = ", ".join(map(repr, own_names())) or "none"
    raise InvalidInput(
        f"name: expected one of the robots {names}, or of {_PACKAGES} where these are installed, "
        f"got {name!r}"
    )


def own_names() -> list[str]:
    """The names of the robots that come with the package."""
    return [folder.name for folder in _folders()]


def _refuse_path(name: str) -> None:
    if name.lower().endswith((".urdf", ".xml", ".xacro")) or "/" in name or "\\" in name:
        names = ", ".join(map(repr, own_names()))
        raise InvalidInput(
            f"name: expected the name of a robot such as {names}, got {name!r}; in Python, read a "
            f"file with Arm.from_urdf({name!r})"
        )


def _own(name: str) -> RobotFiles | None:
    for folder in _folders():
        if folder.name == name:
            return RobotFiles(folder / f"{name}.urdf", folder / "limits.toml")
    return None


def _folders() -> list[Path]:
    # An editable install has two places: the sources, and the folder of the built module.
    package = find_spec("leadthrough")
    places = package.submodule_search_locations if package else None
    return [
        folder
        for place in places or ()
        for folder in sorted((Path(place) / "robots").glob("*"))
        if (folder / f"{folder.name}.urdf").is_file()
    ]


def _of_example_robot_data(name: str) -> RobotFiles | None:
    """Its files are named after the robot, some with "_robot" added: ur5_robot.urdf."""
    found = sorted(set(_urdfs(name)))
    if len(found) > 1:
        listed = ", ".join(map(str, found))
        raise InvalidInput(
            f"name: example-robot-data has several robots {name!r}; name one of their files: "
            f"{listed}; in Python, read it with Arm.from_urdf"
        )
    return RobotFiles(found[0]) if found else None


def _urdfs(name: str) -> Iterator[Path]:
    try:
        files = metadata.files("example-robot-data") or []
    except metadata.PackageNotFoundError:
        return
    for file in files:
        if file.name in (f"{name}.urdf", f"{name}_robot.urdf"):
            yield Path(str(file.locate())).resolve()


def _of_robot_descriptions(name: str) -> RobotFiles | None:
    """Its modules are named after the robot; one downloads its files when first imported."""
    if not name.isidentifier() or find_spec("robot_descriptions") is None:
        return None
    module = f"robot_descriptions.{name.removesuffix('_description')}_description"
    if find_spec(module) is None:
        return None
    described = import_module(module)
    if not hasattr(described, "URDF_PATH"):
        raise InvalidInput(f"name: {module} has no URDF, got {name!r}")
    folder = Path(getattr(described, "PACKAGE_PATH", Path(described.URDF_PATH).parent))
    return RobotFiles(Path(described.URDF_PATH), mesh_folders=(folder, folder.parent))

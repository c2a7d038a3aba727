"""The robots that come with the package."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

from leadthrough.errors import InvalidInput


def find_robot(name: str) -> Path:
    """The folder of a robot, with <name>.urdf and limits.toml.

    Args:
        name: of the robot, such as "panda".

    Raises:
        InvalidInput: if there is no such robot.
    """
    folders = _folders()
    for folder in folders:
        if folder.name == name:
            return folder
    names = ", ".join(repr(folder.name) for folder in folders) or "none"
    raise InvalidInput(f"name: expected one of the robots {names}, got {name!r}")


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

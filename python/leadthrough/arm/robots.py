"""The robots that come with the package."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import Any

from leadthrough.errors import InvalidInput


def find_robot(name: Any) -> Path:
    """The folder of a robot, with <name>.urdf and limits.toml. Raises InvalidInput."""
    folders = _folders()
    for folder in folders:
        if folder.name == name:
            return folder
    names = ", ".join(repr(folder.name) for folder in folders) or "none"
    raise InvalidInput(f"name: expected one of the robots {names}, got {name!r}")


def _folders() -> list[Path]:
    # An editable install has two places: the sources, and what the build put beside the module.
    package = find_spec("leadthrough")
    places = package.submodule_search_locations if package else None
    return [
        folder
        for place in places or ()
        for folder in sorted((Path(place) / "robots").glob("*"))
        if (folder / f"{folder.name}.urdf").is_file()
    ]

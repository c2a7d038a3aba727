"""The robots that come with the package."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import leadthrough
from leadthrough.errors import InvalidInput


def find_robot(name: Any) -> Path:
    """The folder of a robot, with <name>.urdf and limits.toml. Raises InvalidInput."""
    folders = [
        folder
        for package in leadthrough.__path__
        for folder in sorted((Path(package) / "robots").glob("*"))
        if (folder / f"{folder.name}.urdf").is_file()
    ]
    for folder in folders:
        if folder.name == name:
            return folder
    names = ", ".join(repr(folder.name) for folder in folders) or "none"
    raise InvalidInput(f"name: expected one of the robots {names}, got {name!r}")

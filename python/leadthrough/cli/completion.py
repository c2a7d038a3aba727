"""Shell completion of options' values: names, and files of the right type.

Nothing here computes, so that the shell answers at once. Whatever goes wrong offers nothing.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path

import typer

import leadthrough as lt
from leadthrough.cli.command import read_profile

STUDIES = (
    "agriculture",
    "augmentation",
    "chunks",
    "comparison",
    "connection",
    "elbow",
    "human",
    "lasa",
    "robotasks",
    "simulation",
    "singularity",
    "trajectories",
    "ur3",
)
SHAPES = (
    "box:0.1,0.1,0.4@0.5,0,0.2",
    "sphere:0.1@0.5,0,0.2",
    "capsule:0.05,0.3@0.5,0,0.2",
    "cylinder:0.05,0.3@0.5,0,0.2",
)
# As `leadthrough.io` reads them.
OBSTACLE_FILES = {
    "mesh": (".stl", ".obj", ".dae"),
    "cloud": (".pcd", ".ply", ".npy", ".csv", ".txt", ".xyz"),
}
_URDF = (".urdf", ".xml", ".xacro")
_LINK = re.compile(r"<link\s[^>]*?name\s*=\s*[\"']([^\"']+)")

Complete = Callable[[str], list[str]]


def one_of(*values: str) -> Complete:
    return lambda incomplete: _beginning(values, incomplete)


def files(*suffixes: str) -> Complete:
    """Completion of files with these suffixes, and of folders, on the way to them."""
    return lambda incomplete: _files(incomplete, suffixes)


def obstacles(incomplete: str) -> list[str]:
    """Examples of obstacles, and files of meshes and points after mesh: and cloud:."""
    kind, colon, start = incomplete.partition(":")
    if colon and kind in OBSTACLE_FILES:
        return [f"{kind}:{file}" for file in _files(start, OBSTACLE_FILES[kind])]
    return _beginning((*SHAPES, *(f"{each}:" for each in OBSTACLE_FILES)), incomplete)


def recordings(incomplete: str) -> list[str]:
    """Files of recordings or motions in any format that can be read, and folders."""
    return _files(incomplete, _readable())


def anything(incomplete: str) -> list[str]:
    """Inputs of `leadthrough info`: files of recordings, skills and URDFs, and folders."""
    return _files(incomplete, (*_readable(), *_URDF))


def formats(incomplete: str) -> list[str]:
    known = lt.io.formats.FORMATS
    return _beginning((each.name for each in known if each.write is not None), incomplete)


def robots(incomplete: str) -> list[str]:
    """The robots that come with the package, and URDFs."""
    from leadthrough.arm.robot_files import own_names

    return [*_beginning(own_names(), incomplete), *_files(incomplete, _URDF)]


def links(ctx: typer.Context, incomplete: str) -> list[str]:
    """The links of the robot that the command line or the profile names."""
    from leadthrough.arm.robot_files import find_robot

    with suppress(lt.errors.LeadthroughError, OSError, UnicodeDecodeError):
        files_named = (str(file) for file in ctx.params.get("files") or ())
        robot = ctx.params.get("robot") or next(files_named, None) or read_profile().get("robot")
        path = Path(robot or "")
        text = (path if path.is_file() else find_robot(str(robot)).urdf).read_text("utf-8")
        return _beginning(_LINK.findall(text), incomplete)
    return []


def models(incomplete: str) -> list[str]:
    return _beginning(lt.models.model_names(), incomplete)


def parameters(ctx: typer.Context, incomplete: str) -> list[str]:
    """The parameters of the model that --model names, with their defaults."""
    from dataclasses import fields

    with suppress(lt.errors.LeadthroughError):
        known = fields(lt.models.model_entry(ctx.params.get("model") or "").load())
        return _beginning((f"{field.name}={field.default}" for field in known), incomplete)
    return []


def _beginning(values: Iterable[str], incomplete: str) -> list[str]:
    return [value for value in values if value.startswith(incomplete)]


def _readable() -> tuple[str, ...]:
    readable = (each for each in lt.io.formats.FORMATS if each.read is not None)
    return tuple(suffix for each in readable for suffix in each.suffixes)


def _files(incomplete: str, suffixes: tuple[str, ...]) -> list[str]:
    folder, _, start = incomplete.rpartition("/")
    prefix = f"{folder}/" if "/" in incomplete else ""
    found = []
    with suppress(OSError):
        for path in sorted(Path(prefix or ".").expanduser().iterdir()):
            if path.name.startswith(start) and not (path.name.startswith(".") and not start):
                if path.is_dir():
                    found.append(f"{prefix}{path.name}/")
                elif path.suffix.lower() in suffixes:
                    found.append(prefix + path.name)
    # A shell ends a word that is complete with a blank; a folder is only half the way.
    if len(found) == 1 and found[0].endswith("/"):
        return _files(found[0], suffixes) or found
    return found

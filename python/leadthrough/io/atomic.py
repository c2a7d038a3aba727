"""Files and folders that appear whole or not at all, whatever happens to the program or the disk.

Everything that is written goes to a new name in the same folder first, is brought onto the disk and
then takes the place of what was there. A link stays one, and what it points to is written; a file
keeps its mode; devices, pipes and sockets are refused.
"""

from __future__ import annotations

import os
import shutil
import sqlite3
import stat
import uuid
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from leadthrough.check import InvalidInput

StrPath = str | os.PathLike[str]


@contextmanager
def replacing(path: StrPath) -> Iterator[Path]:
    """A temporary file in the same folder that becomes `path` when the block succeeds.

    Args:
        path: file to write; one that is there is replaced. The temporary name has its suffix.

    Raises:
        InvalidInput: if the path cannot be written or is something other than a file.
    """
    target, temporary = _names(path)
    with _writing(target):
        mode = _mode(target)
        try:
            yield temporary
            if mode is not None:
                temporary.chmod(mode)
            _sync(temporary)
            temporary.replace(target)
            _sync(target.parent)
        finally:
            with suppress(OSError):
                temporary.unlink(missing_ok=True)


@contextmanager
def making_folder(path: StrPath) -> Iterator[Path]:
    """The name of a folder for the block to make, which becomes `path` when the block succeeds."""
    target, temporary = _names(path)
    try:
        with _writing(target):
            yield temporary
            for made in (*temporary.rglob("*"), temporary):
                _sync(made)
            temporary.rename(target)
            _sync(target.parent)
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


@contextmanager
def _writing(target: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise InvalidInput(
            f"path: {target} cannot be written ({error.strerror or error})"
        ) from error
    except sqlite3.Error as error:  # of a bag: a full disk comes as one of these
        raise InvalidInput(f"path: {target} cannot be written ({error})") from error


def _names(path: StrPath) -> tuple[Path, Path]:
    """The path's target behind any links, and an unused name in the same folder."""
    if not isinstance(path, str | os.PathLike):
        raise InvalidInput(f"path: expected a path, got {path!r}")
    try:
        target = Path(os.path.realpath(path))
        exists = target.parent.is_dir()
    except (OSError, ValueError) as error:  # a zero byte, or a name that is too long
        raise InvalidInput(f"path: expected a path, got {path!r} ({error})") from None
    if not exists:
        raise InvalidInput(f"path: no such folder: {target.parent}; make it first")
    return target, target.with_name(f".{uuid.uuid4().hex}{Path(path).suffix}")


def _mode(target: Path) -> int | None:
    """The permissions of the file that is there, None if there is none."""
    try:
        mode = target.stat().st_mode
    except FileNotFoundError:
        return None
    if not stat.S_ISREG(mode):
        kind = "a folder" if stat.S_ISDIR(mode) else "a device, pipe or socket"
        raise InvalidInput(f"path: {target} cannot be written: it is {kind}; name a file")
    return stat.S_IMODE(mode)


def _sync(path: Path) -> None:
    """Brings a file, or the list of what is in a folder, onto the disk."""
    if os.name == "nt" and path.is_dir():
        return  # Windows cannot and need not
    number = os.open(path, os.O_RDONLY)
    try:
        os.fsync(number)
    finally:
        os.close(number)

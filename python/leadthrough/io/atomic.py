"""Files and folders that appear whole or not at all."""

from __future__ import annotations

import os
import shutil
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from leadthrough.errors import InvalidInput

StrPath = str | os.PathLike[str]


@contextmanager
def replacing(path: StrPath) -> Iterator[Path]:
    """A temporary file in the same folder that becomes `path` when the block succeeds.

    Args:
        path: file to write; one that is there is replaced. The temporary name has its suffix.

    Raises:
        InvalidInput: if the path cannot be written.
    """
    target, temporary = _names(path)
    try:
        with _writing(target):
            yield temporary
            temporary.replace(target)
    finally:
        temporary.unlink(missing_ok=True)


@contextmanager
def making_folder(path: StrPath) -> Iterator[Path]:
    """The name of a folder for the block to make, which becomes `path` when the block succeeds.

    Args:
        path: folder to write.

    Raises:
        InvalidInput: if the path cannot be written, or is a file or a folder that is not empty.
    """
    target, temporary = _names(path)
    try:
        with _writing(target):
            yield temporary
            temporary.rename(target)
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


@contextmanager
def _writing(target: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise InvalidInput(f"path: {target} cannot be written ({error.strerror})") from error


def _names(path: StrPath) -> tuple[Path, Path]:
    """The path, and an unused name in the same folder."""
    if not isinstance(path, str | os.PathLike):
        raise InvalidInput(f"path: expected a path, got {path!r}")
    target = Path(path)
    if not target.parent.is_dir():
        raise InvalidInput(f"path: no such folder: {target.parent}; make it first")
    return target, target.with_name(f".{uuid.uuid4().hex}{target.suffix}")

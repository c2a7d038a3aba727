"""Files that appear whole or not at all."""

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
    """A file of another name in the same folder, which becomes `path` when the block succeeds.

    It has the suffix of `path`. Raises InvalidInput where it cannot be written.
    """
    target, temporary = _names(path)
    try:
        yield temporary
        temporary.replace(target)
    except OSError as error:
        raise InvalidInput(f"path: {target} cannot be written ({error.strerror})") from error
    finally:
        temporary.unlink(missing_ok=True)


@contextmanager
def making_folder(path: StrPath) -> Iterator[Path]:
    """A folder that the block makes beside `path`, which becomes `path` when the block succeeds.

    Raises InvalidInput where it cannot be written, also where a folder that is not empty, or a
    file, has the name already.
    """
    target, temporary = _names(path)
    try:
        yield temporary
        temporary.rename(target)
    except OSError as error:
        raise InvalidInput(f"path: {target} cannot be written ({error.strerror})") from error
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


def _names(path: StrPath) -> tuple[Path, Path]:
    """The path, and one that nothing has in the same folder."""
    if not isinstance(path, str | os.PathLike):
        raise InvalidInput(f"path: expected a path, got {path!r}")
    target = Path(path)
    if not target.parent.is_dir():
        raise InvalidInput(f"path: no such folder: {target.parent}")
    return target, target.with_name(f".{uuid.uuid4().hex}{target.suffix}")

"""Files written whole or not at all, and read within limits, so that none exhausts the memory.

Everything that is written goes to a new name in the same folder first, is brought onto the disk and
then replaces what was there. A link stays one, and what it points to is written; a file
keeps its mode; devices, pipes and sockets are refused.

Each reader makes a `ReadLimits` and asks it before it takes memory: the size of the inflated data
counts, not that on the disk. With these limits reading one file takes at most 1.5 GiB of memory and
20 s. Libraries that inflate without asking run in `leadthrough.io.reader_process`.
"""

from __future__ import annotations

import os
import platform
import re
import shutil
import sqlite3
import stat
import uuid
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from itertools import accumulate
from pathlib import Path
from typing import Any

import numpy as np

import leadthrough._core as core
from leadthrough.check import Float64Array, InvalidInput, LeadthroughError

StrPath = str | os.PathLike[str]
_ROWS = 10_000  # in a block of text that is written
# How names of temporaries begin: those of another computer in a shared folder are not ours.
_TEMPORARY = f".leadthrough-{uuid.uuid5(uuid.NAMESPACE_DNS, platform.node()).hex[:12]}-"


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


def written_blocks(rows: Float64Array, layout: core.RecordLayout) -> Iterator[str]:
    """The text of rows (n, k), in blocks."""
    for first in range(0, len(rows), _ROWS):
        yield core.write_records(np.ascontiguousarray(rows[first : first + _ROWS]), layout).decode()


def checked_path(path: object) -> Path:
    if not isinstance(path, str | os.PathLike):
        raise InvalidInput(f"path: expected a path, got {path!r}")
    return Path(path)


def _names(path: StrPath) -> tuple[Path, Path]:
    """The path's target behind any links, and an unused name in the same folder."""
    checked_path(path)
    try:
        target = Path(os.path.realpath(path))
        exists = target.parent.is_dir()
    except (OSError, ValueError) as error:  # a zero byte, or a name that is too long
        raise InvalidInput(f"path: expected a path, got {path!r} ({error})") from None
    if not exists:
        raise InvalidInput(f"path: no such folder: {target.parent}; make it first")
    _clear_left_over(target.parent)
    own = f"{_TEMPORARY}{os.getpid()}-{uuid.uuid4().hex}"
    return target, target.with_name(f"{own}{Path(path).suffix}")


def _clear_left_over(folder: Path) -> None:
    """Removes temporary files and folders of this computer's processes that were killed."""
    for path in folder.glob(f"{_TEMPORARY}*"):
        number = path.name.removeprefix(_TEMPORARY).partition("-")[0]
        if not number.isdecimal() or _runs(int(number)):
            continue
        with suppress(OSError):
            shutil.rmtree(path) if path.is_dir() else path.unlink()


def _runs(process: int) -> bool:
    """Whether a process of this computer runs, as far as can be told."""
    if os.name == "nt":
        return True  # asking would end it
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (OSError, OverflowError):
        return True
    return True


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


MAX_BYTES = 2**28  # of a file, once all of it is inflated
_MAX_STREAMED = 2**30  # bytes of a text that is read in blocks, of which only numbers stay
_MAX_TEXT = 2**27  # bytes of a text that is read whole
MAX_NUMBERS = 2**25  # eleven hours of seven joints at 100 Hz; several copies are made of them
MAX_ITEMS = 2**23  # lines, lists or fields: each becomes an object of some hundred bytes
MAX_COLUMNS = 10_000
MAX_LINE = 2**20  # characters in a line of a table
MAX_DEPTH = 32  # levels of nesting; no recording nests so deep
MAX_WIDTH = 256  # numbers per sample; more is a picture

_CURE = "cut the recording into shorter files"
_MAX_YAML_DEPTH = 16  # levels of nesting; PyYAML's compiled loader crashes on deep ones
_MAX_YAML_BYTES = 2**25  # bytes
# The loader takes up to 450 bytes and 15 microseconds for each mark that begins a value.
_MAX_MARKS = 2**20
_MARKS = ("[", "{", ",", ":", "\n", "- ", "? ")
# YAML 1.1 reads 1:59:59 in base 60, which takes for ever where it goes on for a million parts.
_LONG_BASE_60 = re.compile(r"\d(:\d{1,2}){8}")
_DEEP_BLOCK = re.compile(r"^[ ?:-]{64}", re.MULTILINE)
# A list that mentions itself a few times over can stand for billions of numbers.
_ANCHOR_AND_ALIAS = [
    re.compile(rf"(?:^|[\s\[{{,:-]){mark}\S", re.MULTILINE) for mark in ("&", r"\*")
]


class ReadLimits:
    """Remaining allowance of one file; each method counts further claims or refuses them."""

    def __init__(self) -> None:
        self._taken = {"bytes": 0, "numbers": 0, "items": 0}

    def bytes(self, count: int, what: str) -> None:
        """Counts bytes that are read or inflated."""
        self._take("bytes", count, MAX_BYTES, what)

    def streamed(self, path: Path) -> None:
        """Checks the size of a text that is read in blocks."""
        _refuse_more("bytes", path.stat().st_size, _MAX_STREAMED, "the file")

    def numbers(self, count: int, what: str) -> None:
        """Counts numbers, of whatever size they are in the file: here each takes eight bytes."""
        self._take("numbers", count, MAX_NUMBERS, what)

    def items(self, count: int, what: str) -> None:
        """Counts lines, lists, fields and other parts that become an object each."""
        self._take("items", count, MAX_ITEMS, what)

    def columns(self, count: int, what: str) -> None:
        """Checks the number of columns."""
        _refuse_more("columns", count, MAX_COLUMNS, what)

    def depth(self, levels: int, what: str) -> None:
        """Checks how deep a part is nested."""
        _refuse_more("levels of nesting", levels, MAX_DEPTH, what)

    def _take(self, unit: str, count: int, bound: int, what: str) -> None:
        if count < 0:
            raise InvalidInput(f"{what}: expected a number of {unit} >= 0, it claims {count:,}")
        self._taken[unit] += count
        _refuse_more(unit, self._taken[unit], bound, what)


def read_bytes(path: Path, limits: ReadLimits) -> bytes:
    limits.bytes(path.stat().st_size, "the file")
    with path.open("rb") as file:
        found = file.read(MAX_BYTES + 1)  # a file may grow
    _refuse_more("bytes", len(found), MAX_BYTES, "the file")
    return found


def read_text(path: Path, limits: ReadLimits, *, most: int = _MAX_TEXT) -> str:
    """The text of a file, without a byte order mark."""
    found = read_bytes(path, limits)
    _refuse_more("bytes of text", len(found), most if found.isascii() else most // 4, "the file")
    try:
        return found.decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
    except UnicodeDecodeError:
        raise not_text() from None


def not_text() -> InvalidInput:
    return InvalidInput("expected UTF-8 text, got other bytes")


@contextmanager
def refusing_damage(
    what: str, *, damage: type[Exception] | tuple[type[Exception], ...] = Exception
) -> Iterator[None]:
    """Turns the errors that a damaged file leads to into InvalidInput."""
    try:
        yield
    except LeadthroughError:
        raise
    except MemoryError:
        raise InvalidInput(f"expected a {what} that fits into memory; {_CURE}") from None
    except damage as error:
        reason = " ".join(str(error).split())[:200] or type(error).__name__
        raise InvalidInput(f"not a readable {what} ({reason})") from None


def _refuse_more(unit: str, count: int, bound: int, what: str) -> None:
    if count > bound:
        raise InvalidInput(
            f"{what}: expected at most {bound:,} {unit} in one file, it claims {count:,}; {_CURE}"
        )


def load_yaml(path: Path) -> object:
    return parsed_yaml(read_text(path, ReadLimits(), most=_MAX_YAML_BYTES))


def parsed_yaml(text: str) -> Any:  # Any: whatever it holds; its reader checks
    """The plain values in a YAML document."""
    import yaml

    _check_harmless(text)
    try:
        return yaml.load(text, Loader=_loader())
    except yaml.YAMLError as error:
        raise ValueError(str(error)) from None


@cache
def _loader() -> Any:  # Any: the type of a class that depends on how PyYAML was built
    """PyYAML's safe loader, for mappings whose keys are text: others can be chosen to collide."""
    import yaml

    class Loader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):  # type: ignore[misc]
        def construct_mapping(self, node: Any, deep: bool = False) -> Any:
            for key, _ in node.value:
                if key.tag != "tag:yaml.org,2002:str":
                    raise InvalidInput(f"expected keys of text, got {str(key.value)[:60]!r}")
            return super().construct_mapping(node, deep=deep)

    return Loader


def _check_harmless(text: str) -> None:
    if all(mark.search(text) for mark in _ANCHOR_AND_ALIAS):
        raise InvalidInput("expected YAML without aliases; write the values out")
    marks = sum(map(text.count, _MARKS))
    if marks > _MAX_MARKS:
        raise InvalidInput(
            f"expected YAML of at most {_MAX_MARKS:,} values, got some {marks:,}; "
            "write it as JSON or .npz"
        )
    if _LONG_BASE_60.search(text):
        raise InvalidInput("expected plain numbers, got one in base 60")
    steps = [1 if bracket[0] in "[{" else -1 for bracket in re.finditer(r"[\[\]{}]", text)]
    if _DEEP_BLOCK.search(text) or max(accumulate(steps), default=0) > _MAX_YAML_DEPTH:
        raise InvalidInput(f"expected YAML that nests at most {_MAX_YAML_DEPTH} deep")

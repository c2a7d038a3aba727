"""The gate before every reader: how much one file may take, and how damage is reported.

Each reader makes a `Gate` and asks it before it takes memory, so that what counts is what a file
inflates to and not its size on the disk. With these bounds reading one file takes at most 1.5 GiB
of memory and 20 s. Libraries that inflate without asking work apart, see `leadthrough.io.apart`.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from leadthrough.errors import InvalidInput, LeadthroughError

MOST_BYTES = 2**28  # of a file, once all of it is inflated
MOST_NUMBERS = 2**25  # eleven hours of seven joints at 100 Hz; several copies are made of them
MOST_ITEMS = 2**23  # lines, lists or fields: each becomes an object of some hundred bytes
MOST_COLUMNS = 10_000
MOST_LINE = 2**20  # characters in a line of a table
DEEPEST = 32  # levels of nesting; no recording nests so deep
WIDEST = 256  # numbers per sample; more is a picture

_CURE = "cut the recording into shorter files"


class Gate:
    """What one file may still take. Each method counts further claims, or refuses them."""

    def __init__(self) -> None:
        self._taken = {"bytes": 0, "numbers": 0, "items": 0}

    def bytes(self, count: int, what: str) -> None:
        """Counts bytes that are read or inflated."""
        self._take("bytes", count, MOST_BYTES, what)

    def numbers(self, count: int, what: str) -> None:
        """Counts numbers, of whatever size they are in the file: here each takes eight bytes."""
        self._take("numbers", count, MOST_NUMBERS, what)

    def items(self, count: int, what: str) -> None:
        """Counts lines, lists, fields and other parts that become an object each."""
        self._take("items", count, MOST_ITEMS, what)

    def columns(self, count: int, what: str) -> None:
        """Checks the number of columns."""
        _refuse_more("columns", count, MOST_COLUMNS, what)

    def depth(self, levels: int, what: str) -> None:
        """Checks how deep a part is nested."""
        _refuse_more("levels of nesting", levels, DEEPEST, what)

    def _take(self, unit: str, count: int, bound: int, what: str) -> None:
        if count < 0:
            raise InvalidInput(f"{what}: expected a number of {unit} >= 0, it claims {count:,}")
        self._taken[unit] += count
        _refuse_more(unit, self._taken[unit], bound, what)


def content(path: Path, gate: Gate) -> bytes:
    """All bytes of a file."""
    gate.bytes(path.stat().st_size, "the file")
    with path.open("rb") as file:
        found = file.read(MOST_BYTES + 1)  # a file may grow
    _refuse_more("bytes", len(found), MOST_BYTES, "the file")
    return found


def text(path: Path, gate: Gate, *, most: int = MOST_BYTES // 2) -> str:
    """The text of a file, without a byte order mark."""
    found = content(path, gate)
    _refuse_more("bytes of text", len(found), most if found.isascii() else most // 4, "the file")
    try:
        return found.decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
    except UnicodeDecodeError:
        raise not_text() from None


def not_text() -> InvalidInput:
    """The error for a file that should be text and is none."""
    return InvalidInput("expected UTF-8 text, got other bytes")


@contextmanager
def reading(
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

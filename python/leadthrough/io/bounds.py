"""The gate before every reader: how much a file may claim, and how damage is reported."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from leadthrough.errors import InvalidInput, LeadthroughError

LARGEST = 2**30  # bytes of numbers in one file: two days of seven joints at 100 Hz
LARGEST_TEXT = 2**28  # bytes of text, which takes some ten times as much once it is split
WIDEST = 256  # numbers per sample; more is a picture


def check_claim(size: int, what: str) -> None:
    """Refuses numbers that would take more than a GiB.

    Args:
        size: bytes.
        what: part of the file that claims them, for the message.

    Raises:
        InvalidInput: if there are too many.
    """
    if size > LARGEST:
        raise InvalidInput(
            f"{what}: expected at most {LARGEST:,} bytes of numbers, it claims {size:,}; "
            "cut the recording into shorter files"
        )


def text(path: Path) -> str:
    """The text of a file, without a byte order mark.

    Raises:
        InvalidInput: if the file is too long or not UTF-8.
        OSError: if it cannot be read.
    """
    size = path.stat().st_size
    if size > LARGEST_TEXT:
        raise InvalidInput(
            f"expected at most {LARGEST_TEXT:,} bytes of text, got {size:,}; "
            "cut the recording into shorter files"
        )
    try:
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise InvalidInput("expected UTF-8 text, got other bytes") from None


@contextmanager
def reading(
    what: str, *, damage: type[Exception] | tuple[type[Exception], ...] = Exception
) -> Iterator[None]:
    """Turns the errors that a damaged file leads to into InvalidInput.

    Args:
        what: the format, for the message.
        damage: errors that a damaged file can lead to. Compiled third-party readers raise
            whatever the damage happens to hit, so that for them it is any exception.

    Raises:
        InvalidInput: in place of such an error.
    """
    try:
        yield
    except LeadthroughError:
        raise
    except damage as error:
        reason = " ".join(str(error).split())[:200] or type(error).__name__
        raise InvalidInput(f"not a readable {what} ({reason})") from None

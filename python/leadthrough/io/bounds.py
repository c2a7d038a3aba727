"""How much a file may claim, so that one that lies cannot fill the memory."""

from __future__ import annotations

from pathlib import Path

from leadthrough.errors import InvalidInput

LARGEST = 2**30  # bytes of numbers in one file: two days of seven joints at 100 Hz
LARGEST_TEXT = 2**28  # bytes of text, which takes some ten times as much once it is split


def check_claim(size: int, what: str) -> None:
    """Refuses numbers that would take more than a GiB. size: bytes. Raises InvalidInput."""
    if size > LARGEST:
        raise InvalidInput(
            f"{what}: expected at most {LARGEST:,} bytes of numbers, it claims {size:,}; "
            "cut the recording"
        )


def text(path: Path) -> str:
    """The text of a file, without a byte order mark. Raises InvalidInput, OSError."""
    size = path.stat().st_size
    if size > LARGEST_TEXT:
        raise InvalidInput(f"expected at most {LARGEST_TEXT:,} bytes of text, got {size:,}")
    try:
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise InvalidInput("expected UTF-8 text") from None

"""Which tasks a run had, and where and how they were done: manifest.json, one task a line."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from pathlib import Path

from leadthrough.io.atomic import replacing
from leadthrough.tasks.engine import Outcome

NAME = "manifest.json"


def listed(outcomes: Iterable[Outcome], folder: Path) -> Iterator[Outcome]:
    """The same outcomes; manifest.json is written when they end, however they end.

    Args:
        outcomes: of a run.
        folder: where to write it, made if missing.

    Raises:
        InvalidInput: if it cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    stopped: BaseException | None = None
    with replacing(folder / NAME) as temporary, temporary.open("w", encoding="utf-8") as file:
        file.write("[")
        try:
            for number, each in enumerate(outcomes):
                file.write(("," if number else "") + "\n" + json.dumps(_entry(each)))
                yield each
        except BaseException as error:  # also where the caller stops
            stopped = error
        file.write("\n]\n")
    if stopped is not None:
        raise stopped


def _entry(outcome: Outcome) -> dict[str, object]:
    return {
        "key": outcome.key,
        "state": "failed" if outcome.failure else "known" if outcome.known else "done",
        "attempts": outcome.attempts,
        "host": outcome.host,
        "seconds": outcome.seconds,
    }

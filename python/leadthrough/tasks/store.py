"""Finished tasks in a folder: a file for each, which is complete or absent."""

from __future__ import annotations

import json
import uuid
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from leadthrough.io.atomic import replacing
from leadthrough.tasks.task import Report, Row

_NAME = "store"


@dataclass(frozen=True)
class Store:
    """Rows and failures by key, with where and how long they were computed.

    Attributes:
        folder: made when first written to.
    """

    folder: Path

    def identity(self) -> str:
        """A text in a file of the folder, by which others see that they have the same folder."""
        path = self.folder / _NAME
        self.folder.mkdir(parents=True, exist_ok=True)
        if not path.exists():
            with replacing(path) as temporary:
                temporary.write_text(uuid.uuid4().hex, encoding="utf-8")
        return path.read_text(encoding="utf-8")

    def is_here(self, identity: str) -> bool:
        """Whether this process sees the folder that has this identity."""
        try:
            return (self.folder / _NAME).read_text(encoding="utf-8") == identity
        except OSError:
            return False

    def report(self, key: str) -> Report | None:
        """How the rows of a key were computed, or None if there are none."""
        head, whole = self._parts(self._path(key))
        return None if not whole else Report(key, **head)

    def rows(self, key: str) -> list[Row] | None:
        """The rows of a key, or None if there are none or the file is damaged."""
        _, rows = self._parts(self._path(key))
        return json.loads(rows) if rows else None

    def attempts(self, key: str) -> int:
        """How often a task was begun that failed each time."""
        head, _ = self._parts(self._failed(key))
        return int(head.get("attempts", 0))

    def write(self, report: Report) -> None:
        """Keep what a report says; rows replace an earlier failure.

        Args:
            report: with rows or a failure.

        Raises:
            InvalidInput: if the file cannot be written.
        """
        head = {name: getattr(report, name) for name in ("host", "seconds", "attempts")}
        failed = report.failure is not None
        path = (self._failed if failed else self._path)(report.key)
        body = json.dumps(report.failure) if failed else report.rows
        path.parent.mkdir(parents=True, exist_ok=True)
        with replacing(path) as temporary:
            temporary.write_text(f"{json.dumps(head)}\n{body}\n", encoding="utf-8")
        if not failed:
            self._failed(report.key).unlink(missing_ok=True)

    def _path(self, key: str) -> Path:
        return self.folder / key[:2] / f"{key}.json"

    def _failed(self, key: str) -> Path:
        return self.folder / key[:2] / f"{key}.failed.json"

    @staticmethod
    def _parts(path: Path) -> tuple[dict[str, Any], str]:
        """The first line of a file, and the rest; both empty if it is missing or damaged."""
        try:
            first, _, rest = path.read_text(encoding="utf-8").partition("\n")
            head = json.loads(first)
        except (OSError, ValueError):
            return {}, ""
        return (head, rest) if isinstance(head, dict) and rest.endswith("\n") else ({}, "")

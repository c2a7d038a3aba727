"""Tasks, the jobs that are sent to workers, and the store of finished ones.

The store is a folder with a file for each task, which is complete or absent.
"""

from __future__ import annotations

import hashlib
import json
import marshal
import sys
import uuid
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from leadthrough.check import InvalidInput
from leadthrough.io.files import replacing
from leadthrough.tasks import code

_PROMPT = "__main__"

Row = dict[str, Any]
"""Values by the names of columns: text and finite numbers."""

_NAME = "store"


@dataclass(frozen=True)
class Task:
    """A piece of work: `function(**arguments, **files)` returns rows of text and finite numbers.

    Columns whose names end in "_cpu_s" hold measured processor times; all others are the same in
    every run.

    Attributes:
        function: importable by its name.
        arguments: values that JSON can hold; they include the seed if the function uses random
            numbers.
        files: files that the function reads, by the names of its arguments. It gets the path of a
            file with this content and suffix, wherever it runs.
    """

    function: Callable[..., list[Row]]
    arguments: dict[str, Any]
    files: Mapping[str, Path] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """The function's full name."""
        return f"{self.function.__module__}.{self.function.__qualname__}"

    @property
    def key(self) -> str:
        """A text that changes with the arguments, the files' content and the function's code."""
        parts: list[Any] = [_code_of(self.function), self.name, self.arguments]
        if self.files:
            parts.append({name: content_of(path) for name, path in self.files.items()})
        text = json.dumps(parts, sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:32]


@dataclass(frozen=True)
class Job:
    """A task as it travels: its function by name."""

    key: str  # of the task
    module: str  # that has the function
    function: str  # its name in the module
    arguments: dict[str, Any]  # values that JSON can hold
    files: dict[str, str]  # paths by the names of further arguments
    contents: dict[str, str]  # a digest of each file's content, by the same names
    code: str  # the digest of the function's code
    store: tuple[str, str]  # folder of the store, and the text that tells it from others
    timeout: float | None  # s; None for no bound


@dataclass(frozen=True)
class Report:
    key: str  # of the task
    host: str  # the process that did it
    seconds: float  # that it took, from when the function was called
    attempts: int = 1  # how often it was begun
    rows: str | None = None  # as JSON; None if they are in the store already or there are none
    failure: dict[str, str] | None = None


def job(task: Task, store: tuple[str, str], timeout: float | None) -> Job:
    """A task in the form in which it travels."""
    function = task.function
    return Job(
        task.key,
        function.__module__ or _PROMPT,
        function.__qualname__,
        task.arguments,
        {name: str(Path(path).resolve()) for name, path in task.files.items()},
        {name: content_of(path) for name, path in task.files.items()},
        _code_of(function),
        store,
        timeout,
    )


def _code_of(function: Callable[..., Any]) -> str:
    """A digest of a function's code; at the prompt, where it has no file, of its own alone."""
    digest = code.digest(function.__module__ or _PROMPT)
    if function.__module__ and code.sources(function.__module__):
        return digest
    return hashlib.sha256(digest.encode() + marshal.dumps(function.__code__)).hexdigest()[:16]


def content_of(path: Path) -> str:
    try:
        changed = path.stat()
        return _content(path, changed.st_mtime_ns, changed.st_size)
    except OSError as error:
        raise InvalidInput(f"{path}: cannot be read ({error.strerror})") from None


@cache
def _content(path: Path, changed: int, size: int) -> str:  # noqa: ARG001  # a file may change
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()[:32]


def check_importable(function: Callable[..., Any]) -> None:
    """Refuses a function that another process cannot import by its name."""
    name = function.__module__ or _PROMPT
    module = sys.modules.get(name)
    if name == _PROMPT or (getattr(module, function.__qualname__, None) is not function):
        raise InvalidInput(
            f"function: expected one that another process can import by its name, got "
            f"{name}.{function.__qualname__}; put it into a module"
        )


@dataclass(frozen=True)
class Store:
    """Rows and failures by key, with host and seconds of their computation.

    Attributes:
        folder: made when first written to.
    """

    folder: Path

    def identity(self) -> str:
        """A text in a file of the folder, by which workers recognise the same folder."""
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
        """Stores a report; rows replace an earlier failure.

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

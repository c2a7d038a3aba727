"""Execution of tasks: workers, folder of results, time limit and progress."""

from __future__ import annotations

import pickle
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from leadthrough.io.files import replacing
from leadthrough.repr import ShortRepr
from leadthrough.tasks.engine import Outcome, Progress, run, with_manifest
from leadthrough.tasks.task import Store, Task


@dataclass(frozen=True, eq=False)
class Execution(ShortRepr):
    """Execution of tasks: workers, folder of results, time limit and progress.

    Attributes:
        on: processes or cluster, as `leadthrough.tasks.run` takes it; None for this process.
        out: folder that keeps finished results, made if missing; the same call resumes there. None
            keeps nothing.
        task_timeout: the longest that one task may take, s; None for no bound.
        progress: shows the tasks' outcomes and passes them on: `leadthrough.tasks.with_progress`.
    """

    on: str | None = None
    out: Path | None = None
    task_timeout: float | None = None
    progress: Progress | None = None

    @contextmanager
    def folder(self) -> Iterator[Path]:
        """The folder of the results; a temporary one if none is kept."""
        if self.out is not None:
            self.out.mkdir(parents=True, exist_ok=True)
            yield self.out
            return
        with tempfile.TemporaryDirectory() as temporary:
            yield Path(temporary)

    def outcomes(
        self, todo: Sequence[Task], store: Store, folder: Path, label: str
    ) -> Iterator[Outcome]:
        """Outcomes of tasks as they finish, listed in the folder, with progress under a label."""
        found = with_manifest(run(todo, store, on=self.on, timeout=self.task_timeout), folder)
        return found if self.progress is None else self.progress(found, len(todo), label)


def pickled(value: object, file: Path) -> Path:
    """The file, with a value that all tasks have in common."""
    with replacing(file) as temporary:
        temporary.write_bytes(pickle.dumps(value, protocol=5))
    return file

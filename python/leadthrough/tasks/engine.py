"""Tasks in, outcomes out as they come; what is in the store is not done again."""

from __future__ import annotations

import json
import pickle
import re
import tempfile
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from queue import SimpleQueue
from typing import Protocol

import rich.progress
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn

from leadthrough import check
from leadthrough.blas_threads import one_blas_thread
from leadthrough.check import InvalidInput, ShortRepr
from leadthrough.io.files import replacing
from leadthrough.tasks.process import Process, attempt_with
from leadthrough.tasks.task import Job, Report, Store, Task, check_importable, job

NAME = "manifest.json"
_LOCAL = re.compile(r"local:(?P<count>\d+)")
# A cluster, by its address or the file that its scheduler wrote.
_CLUSTER = re.compile(r"[a-z]+://.+|.+\.json")


@dataclass(frozen=True)
class Outcome:
    """Result of a task.

    Attributes:
        index: of the task, counted from 0.
        key: of the task; the store has its rows.
        known: whether the rows were in the store before.
        attempts: how often it was begun, with those of earlier runs that failed.
        host: the process or worker that did it.
        seconds: that it took.
        failure: "error", "message" and "traceback"; None if there are rows.
    """

    index: int
    key: str
    known: bool
    attempts: int
    host: str
    seconds: float
    failure: dict[str, str] | None = None


def run(
    tasks: Iterable[Task],
    store: Store,
    *,
    on: str | None = None,
    timeout: float | None = None,
) -> Iterator[Outcome]:
    """Do the tasks that have no rows in the store yet; the outcomes come in any order.

    Tasks are taken from the iterable only as workers have room, and no rows are kept in memory.
    If the caller stops early, running tasks are dropped.

    Args:
        store: takes the rows.
        on: "local:N" for N processes of this machine, the address of a Dask scheduler such as
            "tcp://host:8786" or the .json file that it wrote; None for this process, where a task
            can neither be bounded in time nor end its process alone.
        timeout: the longest that a task may take, s, > 0; None for no bound.

    Yields:
        An outcome for each task.

    Raises:
        InvalidInput: if the store cannot be written, a function cannot be imported by its name, or
            a worker of the cluster has other code.
        MissingDependency: for a cluster, if the extra `dask` is not installed.
        SchedulerUnreachable: if the scheduler does not answer any more.
    """
    bound = None if timeout is None else check.number(timeout, "task_timeout", above=0.0)
    workers = _workers(on)
    try:
        yield from _outcomes(tasks, store, workers, bound)
    finally:
        workers.close()


def _outcomes(
    tasks: Iterable[Task], store: Store, workers: Workers, timeout: float | None
) -> Iterator[Outcome]:
    identity = (str(store.folder.resolve()), store.identity())
    waiting: dict[str, list[int]] = {}
    for index, task in enumerate(tasks):
        key = task.key
        if key in waiting:
            waiting[key].append(index)
            continue
        if known := store.report(key):
            yield _outcome(index, known, known=True)
            continue
        waiting[key] = [index]
        workers.submit(task, job(task, identity, timeout))
        while len(waiting) >= workers.room:
            yield from _finished(waiting, store, workers)
    while waiting:
        yield from _finished(waiting, store, workers)


def _finished(waiting: dict[str, list[int]], store: Store, workers: Workers) -> Iterator[Outcome]:
    """Outcomes of the next finished task, stored before they are passed on."""
    report = workers.next()
    if report.failure:
        attempts = report.attempts + store.attempts(report.key)
        report = replace(report, attempts=attempts)
    if report.failure or report.rows is not None:
        store.write(report)
    for index in waiting.pop(report.key):
        yield _outcome(index, report, known=False)


def _outcome(index: int, report: Report, *, known: bool) -> Outcome:
    return Outcome(
        index,
        report.key,
        known,
        report.attempts,
        report.host,
        round(report.seconds, 6),
        report.failure,
    )


Progress = Callable[[Iterable[Outcome], int, str], Iterator[Outcome]]
"""Shows outcomes and passes them on: of the outcomes, their number and a label."""


def with_progress(outcomes: Iterable[Outcome], total: int, label: str) -> Iterator[Outcome]:
    """The same outcomes, with progress and estimated remaining time on stderr.

    Args:
        label: shown before the bar, such as "validating".
    """
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    console = Console(stderr=True)
    with rich.progress.Progress(*columns, TimeRemainingColumn(), console=console) as progress:
        bar = progress.add_task(label, total=total)
        known = failed = 0
        for each in outcomes:
            known, failed = known + each.known, failed + (each.failure is not None)
            # Known tasks took no time and say nothing of the rest.
            progress.update(bar, total=total - known, advance=0 if each.known else 1)
            progress.update(bar, description=_described(label, known, failed))
            yield each


def _described(label: str, known: int, failed: int) -> str:
    parts = [f"{known} known"] * bool(known) + [f"{failed} failed"] * bool(failed)
    return f"{label} ({', '.join(parts)})" if parts else label


def with_manifest(outcomes: Iterable[Outcome], folder: Path) -> Iterator[Outcome]:
    """The same outcomes; manifest.json is written when they end, however they end.

    Args:
        folder: folder of the manifest, made if missing.

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


class Workers(Protocol):
    """Jobs in, reports out as they come."""

    @property
    def room(self) -> int:
        """The number of jobs that it should have at a time."""

    def submit(self, task: Task, job: Job) -> None:
        """Takes a task."""

    def next(self) -> Report:
        """Waits for a report on any of the jobs."""

    def close(self) -> None:
        """Drops the jobs that are not finished."""


def _workers(on: str | None) -> Workers:
    if on is None:
        return _ThisProcess()
    if found := _LOCAL.fullmatch(on):
        return _Processes(check.integer(int(found["count"]), "on", at_least=1))
    if _CLUSTER.fullmatch(on):
        from leadthrough.tasks.cluster import Cluster  # noqa: PLC0415  # takes a second to import

        return Cluster(on)
    raise InvalidInput(
        f"on: expected local:N, the address of a Dask scheduler (tcp://host:8786) or the .json "
        f"file that it wrote, got {on!r}"
    )


class _ThisProcess:
    """This process, one job at a time."""

    room = 1

    def __init__(self) -> None:
        self._reports: list[Report] = []

    def submit(self, task: Task, job: Job) -> None:
        self._reports.append(one_blas_thread(attempt_with)(task.function, job, job.files))

    def next(self) -> Report:
        return self._reports.pop()

    def close(self) -> None:
        self._reports.clear()


class _Processes:
    """Processes of this machine, each led by a thread."""

    def __init__(self, count: int) -> None:
        self.room = count
        self._jobs: SimpleQueue[Job | None] = SimpleQueue()
        self._reports: SimpleQueue[Report] = SimpleQueue()
        self._processes = [Process() for _ in range(count)]
        self._threads = [
            threading.Thread(target=self._lead, args=(process,), daemon=True)
            for process in self._processes
        ]
        for thread in self._threads:
            thread.start()

    def submit(self, task: Task, job: Job) -> None:
        check_importable(task.function)
        self._jobs.put(job)

    def next(self) -> Report:
        return self._reports.get()

    def close(self) -> None:
        for _ in self._threads:
            self._jobs.put(None)
        for process in self._processes:
            process.close()

    def _lead(self, process: Process) -> None:
        while (job := self._jobs.get()) is not None:
            self._reports.put(process.do(job, job.files))


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

"""Where tasks run: in this process, in processes of this machine, or on a Dask cluster."""

from __future__ import annotations

import re
import threading
from queue import SimpleQueue
from typing import Protocol

from leadthrough import check
from leadthrough.blas_threads import one_blas_thread
from leadthrough.errors import InvalidInput
from leadthrough.tasks.attempt import attempt_with
from leadthrough.tasks.process import Process
from leadthrough.tasks.task import Job, Report, Task, check_importable

_LOCAL = re.compile(r"local:(?P<count>\d+)")
# A cluster, by its address or the file that its scheduler wrote.
_CLUSTER = re.compile(r"[a-z]+://.+|.+\.json")


class Place(Protocol):
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


def opened(on: str | None) -> Place:
    """The place with this name."""
    if on is None:
        return _Here()
    if found := _LOCAL.fullmatch(on):
        return Processes(check.integer(int(found["count"]), "on", at_least=1))
    if _CLUSTER.fullmatch(on):
        from leadthrough.tasks.cluster import Cluster  # noqa: PLC0415  # takes a second to import

        return Cluster(on)
    raise InvalidInput(
        f"on: expected local:N, the address of a Dask scheduler (tcp://host:8786) or the .json "
        f"file that it wrote, got {on!r}"
    )


class _Here:
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


class Processes:
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

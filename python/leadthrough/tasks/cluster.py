"""A Dask cluster: futures by key; each worker does jobs in processes of its own.

So a job that ends its process costs no worker, and one that takes too long can be ended.
"""

from __future__ import annotations

import logging
import time
import warnings
from collections import deque
from collections.abc import Iterator, Mapping
from concurrent.futures import CancelledError
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any
from weakref import WeakValueDictionary

from leadthrough import check
from leadthrough.check import CodeMismatch, InvalidInput, SchedulerUnreachable
from leadthrough.io.files import replacing
from leadthrough.tasks import code
from leadthrough.tasks.process import Process
from leadthrough.tasks.task import Job, Report, Task, check_importable

_PATIENCE = 10.0  # s without an answer of the scheduler
# Jobs go in batches of so many, or of one for each thread if that is more: a batch costs the
# scheduler less than its jobs one by one, and it keeps a record of each for as long as it runs.
_BATCH = 16
_AHEAD = 2  # batches, so that no thread waits for the client
_LOOK = 1.0  # s between looks at whether the scheduler is there
_COUNT = 10.0  # s between looks at how many threads there are
_SILENCE = 30.0  # s in which a busy scheduler answers
# Loggers that print tracebacks when the scheduler ends: `SchedulerUnreachable` says it.
_LOGGERS = ("distributed", "distributed.client", "tornado.application", "asyncio")
# By the threads of a worker: processes that wait for a job.
_IDLE: deque[Process] = deque()


class Cluster:
    """The workers of a Dask scheduler."""

    def __init__(self, where: str) -> None:
        distributed = check.package("distributed", extra="dask")
        named = {"scheduler_file": where} if where.endswith(".json") else {"address": where}
        if where.endswith(".json") and not Path(where).is_file():
            raise InvalidInput(f"on: no such file: {where}")
        try:
            self._client = distributed.Client(
                **named, timeout=_PATIENCE, set_as_default=False, name="leadthrough"
            )
        except (OSError, ValueError) as error:
            raise InvalidInput(f"on: no Dask scheduler at {where} ({error})") from None
        self._levels = {name: logging.getLogger(name).level for name in _LOGGERS}
        _set_levels(dict.fromkeys(_LOGGERS, logging.CRITICAL + 1))
        self._where = where
        self._held: list[tuple[Job, dict[str, Any]]] = []  # for the next batch
        self._futures: dict[str, Any] = {}
        self._reports: SimpleQueue[Any] = SimpleQueue()
        self._contents: WeakValueDictionary[str, Any] = WeakValueDictionary()
        self._same: set[str] = set()
        self._threads, self._counted = 0, -_COUNT
        self._is_lost = False

    @property
    def room(self) -> int:
        return _AHEAD * self._batch

    @property
    def _batch(self) -> int:
        self._check_there()
        return max(_BATCH, self._threads)

    def submit(self, task: Task, job: Job) -> None:
        check_importable(task.function)
        with self._answering():
            self._check_code(job)
            sent = {name: self._sent(path, job.contents[name]) for name, path in job.files.items()}
        self._held.append((job, sent))
        if len(self._held) >= self._batch:
            self._send()

    def _send(self) -> None:
        """Sends what is held as one batch."""
        held, self._held = self._held, []
        if not held:
            return
        keys = [f"leadthrough-{job.key}" for job, _ in held]
        # Not pure: its keys are known, and a digest of the arguments would cost as much again.
        futures = self._client.map(_do, *zip(*held, strict=True), key=keys, pure=False)
        for (job, files), future in zip(held, futures, strict=True):
            self._futures[job.key] = (future, files)
            future.add_done_callback(lambda done, key=job.key: self._reports.put((key, done)))

    def next(self) -> Report:
        if len(self._futures) < self._batch:
            self._send()  # no more come to fill it
        while True:
            try:
                key, future = self._reports.get(timeout=_LOOK)
            except Empty:
                self._check_there()
                continue
            if future.cancelled():
                raise self._lost()
            with self._answering():
                return self._reported(key, future)

    def close(self) -> None:
        if self._client.status == "running" and not self._is_lost:
            self._client.cancel([future for future, _ in self._futures.values()])
        self._held.clear()
        self._futures.clear()
        self._client.close(timeout=_LOOK)
        _set_levels(self._levels)

    def _reported(self, key: str, future: Any) -> Report:
        """The report of a future, which is released."""
        del self._futures[key]
        error = future.exception(timeout=_PATIENCE)
        if error is None:
            return future.result(timeout=_PATIENCE)  # type: ignore[no-any-return]
        if isinstance(error, CodeMismatch):
            raise error
        # A worker that was killed again and again, or a report that could not be sent.
        failure = {"error": type(error).__name__, "message": str(error), "traceback": ""}
        return Report(key, self._where, 0.0, failure=failure)

    def _sent(self, path: str, content: str) -> Any:
        """A future of a file's content, which each worker asks for once."""
        future = self._contents.get(content)
        if future is None:
            with warnings.catch_warnings():
                warnings.filterwarnings("ignore", "Sending large graph")  # once, and by content
                future = self._client.submit(
                    bytes, Path(path).read_bytes(), key=f"leadthrough-file-{content}"
                )
            self._contents[content] = future
        return future

    def _check_code(self, job: Job) -> None:
        if job.code in self._same:
            return
        digests = self._client.run(code.digest, job.module, on_error="return")
        for worker, other in digests.items():
            if other != job.code:
                raise CodeMismatch(_other_code(worker, job.module))
        self._same.add(job.code)

    def _check_there(self) -> None:
        """Counts the workers' threads from time to time; raises SchedulerUnreachable."""
        if self._client.status != "running":
            raise self._lost()
        if time.monotonic() - self._counted > _COUNT:
            with self._answering():
                self._threads = sum(self._client.nthreads(callback_timeout=_SILENCE).values())
            self._counted = time.monotonic()

    @contextmanager
    def _answering(self) -> Iterator[None]:
        """Raises SchedulerUnreachable where a connection breaks meanwhile, or none answers."""
        try:
            yield
        except (OSError, RuntimeError, CancelledError):
            raise self._lost() from None

    def _lost(self) -> SchedulerUnreachable:
        self._is_lost = True
        return SchedulerUnreachable(
            f"on: the Dask scheduler at {self._where} does not answer any more; run the same "
            "command again, with a cluster or without, to do what is missing"
        )


def _set_levels(levels: Mapping[str, int]) -> None:
    """Gives loggers, by their names, these levels."""
    for name, level in levels.items():
        logging.getLogger(name).setLevel(level)


def _other_code(worker: str, module: str) -> str:
    return (
        f"on: the worker {worker} has other code than this machine for {module}; install the same "
        "leadthrough, NumPy, SciPy and Python there, and the module with the tasks, or leave the "
        "worker out"
    )


def _do(job: Job, files: dict[str, bytes]) -> Report:
    """The report on a job, on a worker."""
    worker = check.package("distributed", extra="dask").get_worker()
    if code.digest(job.module) != job.code:
        raise CodeMismatch(_other_code(worker.address, job.module))
    folder = Path(worker.local_directory) / "leadthrough"
    folder.mkdir(exist_ok=True)
    paths = {
        name: _in_a_file(data, folder / (job.contents[name] + Path(job.files[name]).suffix))
        for name, data in files.items()
    }
    try:
        process = _IDLE.popleft()
    except IndexError:
        process = Process()
    report = process.do(job, paths)
    _IDLE.append(process)
    return replace(report, host=worker.address)


def _in_a_file(data: bytes, path: Path) -> str:
    if not path.exists():
        with replacing(path) as temporary:
            temporary.write_bytes(data)
    return str(path)

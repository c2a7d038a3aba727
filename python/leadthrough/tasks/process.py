"""Does jobs in processes that may be killed in the midst of one.

A job that fails or ends its process does not lose the work of the others.
"""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
import traceback
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
from importlib import import_module
from multiprocessing.connection import Connection, Pipe
from pathlib import Path
from queue import SimpleQueue
from typing import Any

from leadthrough.check import InvalidInput
from leadthrough.tasks.task import Job, Report, Row, Store

# A process that ends by itself, or is ended by the machine for want of memory, is not to blame the
# first time.
MAX_ATTEMPTS = 3
_START = 120.0  # s, to start a process and load a task's code
_CODE = "from leadthrough.tasks.process import serve; serve({number})"
# One thread for linear algebra, for equal bits and honest processor times.
_ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


class Process:
    """Does jobs in a process of its own, which is started again where a job ended it."""

    def __init__(self) -> None:
        self._child: subprocess.Popen[bytes] | None = None
        self._line: Connection | None = None
        self._closed = False

    def do(self, job: Job, files: Mapping[str, str]) -> Report:
        attempts, began, ended = 0, time.perf_counter(), ""
        while attempts < MAX_ATTEMPTS and not self._closed:
            attempts += 1
            line = self._started()
            with suppress(EOFError, OSError):
                line.send((job, dict(files)))
                if line.poll(_START):
                    line.recv()  # its code is loaded: from now on its time counts
                    if not line.poll(job.timeout):
                        return self._late(job, attempts)
                    report: Report = line.recv()
                    return replace(report, attempts=attempts)
            ended = self._ending()
        message = f"the task's process {ended} in each of {attempts} attempts"
        failure = {"error": "WorkerKilled", "message": message, "traceback": ""}
        return Report(job.key, here(), time.perf_counter() - began, attempts, failure=failure)

    def close(self) -> None:
        self._closed = True
        self._ending()

    def _late(self, job: Job, attempts: int) -> Report:
        self._ending()
        message = f"the task took longer than {job.timeout:g} s"
        failure = {"error": "Timeout", "message": message, "traceback": ""}
        return Report(job.key, here(), job.timeout or 0.0, attempts, failure=failure)

    def _started(self) -> Connection:
        if self._line is None:
            self._line, theirs = Pipe()
            folders = [folder or str(Path.cwd()) for folder in sys.path]
            environment = {**os.environ, **dict.fromkeys(_ONE_THREAD, "1")}
            with theirs:
                self._child = subprocess.Popen(
                    [sys.executable, "-c", _CODE.format(number=theirs.fileno())],
                    env=environment | {"PYTHONPATH": os.pathsep.join(folders)},
                    pass_fds=[theirs.fileno()],
                    stdin=subprocess.DEVNULL,
                    stdout=2,  # a task's prints must not get among a command's results
                )
        return self._line

    def _ending(self) -> str:
        """Ends the process if it has not ended, and says how it did."""
        child, line, self._child, self._line = self._child, self._line, None, None
        if line is not None:
            line.close()
        if child is None:
            return "ended"
        # A process that died by itself may take a moment to be gone.
        with suppress(subprocess.TimeoutExpired):
            child.wait(0.0 if self._closed else 0.2)
        if child.poll() is None:
            child.kill()
        code = child.wait()
        if code < 0:
            return f"was killed ({signal.Signals(-code).name})"
        return f"ended with exit code {code}"


def serve(number: int) -> None:
    """Does the jobs that come on a line, until the line is closed; then ends at once."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides
    line = Connection(number)
    waiting: SimpleQueue[tuple[Job, dict[str, str]]] = SimpleQueue()
    threading.Thread(target=_listen, args=(line, waiting), daemon=True).start()
    while True:
        job, files = waiting.get()
        with suppress(Exception):  # `attempt` reports it
            import_module(job.module)
        line.send(None)
        line.send(attempt(job, files))


def _listen(line: Connection, waiting: SimpleQueue[tuple[Job, dict[str, str]]]) -> None:
    try:
        while True:
            waiting.put(line.recv())
    except (EOFError, OSError):
        os._exit(0)  # nobody waits for what the other thread does


def attempt(job: Job, files: Mapping[str, str]) -> Report:
    """The report on a job whose function is imported by its name."""

    def named(**arguments: Any) -> list[Row]:
        rows: list[Row] = getattr(import_module(job.module), job.function)(**arguments)
        return rows

    return attempt_with(named, job, files)


def attempt_with(function: Callable[..., list[Row]], job: Job, files: Mapping[str, str]) -> Report:
    """The report on a job; where the store is within reach, the rows are in it."""
    began = time.perf_counter()
    failure = rows = None
    try:
        found = function(**job.arguments, **{name: Path(path) for name, path in files.items()})
        rows = json.dumps(found, allow_nan=False)
    except (Exception, SystemExit) as error:
        failure = _as_text(error)
    report = Report(job.key, here(), time.perf_counter() - began, rows=rows, failure=failure)
    return _stored(report, job)


def here() -> str:
    """This process, as the manifest names it."""
    return f"{socket.gethostname()}:{os.getpid()}"


def _stored(report: Report, job: Job) -> Report:
    """The report without its rows, which are in the store now, if this process sees the store."""
    folder, identity = job.store
    store = Store(Path(folder))
    if report.rows is None or not store.is_here(identity):
        return report
    try:
        store.write(report)
    except InvalidInput as error:  # the disk is full
        return replace(report, rows=None, failure=_as_text(error))
    return replace(report, rows=None)


def _as_text(error: BaseException) -> dict[str, str]:
    return {
        "error": type(error).__name__,
        "message": str(error),
        "traceback": "".join(traceback.format_exception(error)),
    }

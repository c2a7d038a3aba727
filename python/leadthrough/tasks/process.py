"""A process that does one job after another, and may be killed in the midst of one."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from importlib import import_module
from multiprocessing.connection import Connection, Pipe
from pathlib import Path
from queue import SimpleQueue

from leadthrough.tasks.attempt import attempt, here
from leadthrough.tasks.task import Job, Report

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
        """The report on a job, whatever becomes of the process."""
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
        """Ends the process, also in the midst of a job."""
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
                    stdout=2,  # what a task prints must not get among a command's results
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
        with suppress(Exception):  # `attempt` tells it
            import_module(job.module)
        line.send(None)
        line.send(attempt(job, files))


def _listen(line: Connection, waiting: SimpleQueue[tuple[Job, dict[str, str]]]) -> None:
    try:
        while True:
            waiting.put(line.recv())
    except (EOFError, OSError):
        os._exit(0)  # nobody waits for what the other thread does

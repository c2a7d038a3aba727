"""Does a job in this process: one that fails must not lose the work of the others."""

from __future__ import annotations

import json
import os
import socket
import time
import traceback
from collections.abc import Callable, Mapping
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any

from leadthrough.errors import InvalidInput
from leadthrough.tasks.store import Store
from leadthrough.tasks.task import Job, Report, Row


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
        failure = told(error)
    report = Report(job.key, here(), time.perf_counter() - began, rows=rows, failure=failure)
    return stored(report, job)


def here() -> str:
    """This process, as the manifest names it."""
    return f"{socket.gethostname()}:{os.getpid()}"


def stored(report: Report, job: Job) -> Report:
    """The report without its rows, which are in the store now, if this process sees the store."""
    folder, identity = job.store
    store = Store(Path(folder))
    if report.rows is None or not store.is_here(identity):
        return report
    try:
        store.write(report)
    except InvalidInput as error:  # the disk is full
        return replace(report, rows=None, failure=told(error))
    return replace(report, rows=None)


def told(error: BaseException) -> dict[str, str]:
    """An error as text."""
    return {
        "error": type(error).__name__,
        "message": str(error),
        "traceback": "".join(traceback.format_exception(error)),
    }

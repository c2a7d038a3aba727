"""Studies: a frozen configuration in; rows, a table and figures out.

A study consists of independent tasks. They run in processes of this machine or on a Dask cluster.
The folder of the results keeps the rows of each task until its arguments or the code that it
imports change, so that a study that was stopped resumes where it was.
"""

from __future__ import annotations

import platform
import time
import traceback
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from leadthrough import tasks
from leadthrough.drawing.figure import styled
from leadthrough.errors import CodeMismatch, SchedulerUnreachable
from leadthrough.tasks import Row, Task
from leadthrough.tasks.code import digest
from leadthrough_studies import results

__all__ = [
    "Outcome",
    "Report",
    "Row",
    "Study",
    "Task",
    "cpu_time",
    "mean",
    "run",
    "selected",
    "versions",
]

_STORE = "cache"
_LIBRARIES = ("leadthrough", "numpy", "scipy")


@dataclass(frozen=True, eq=False)
class Report:
    """A study's view of its rows.

    Attributes:
        table: the main numbers, with the same columns in every row.
        figures: figures by file stem.
        summary: further content of results.json.
        pages: parts of HTML pages by file stem.
        tables: further tables by file stem.
    """

    table: list[Row]
    figures: dict[str, Figure] = field(default_factory=dict)
    summary: dict[str, Any] = field(default_factory=dict)
    pages: dict[str, list[str]] = field(default_factory=dict)
    tables: dict[str, list[Row]] = field(default_factory=dict)


@dataclass(frozen=True)
class Study:
    """The three functions that make up a study.

    Attributes:
        configure: returns the configuration, a frozen dataclass, for (quick, seed).
        tasks: returns the tasks of a configuration, in a fixed order.
        report: returns the report of a configuration and its rows; rows of failed tasks are
            missing.
        of_recordings: returns a configuration with the recordings in a folder, for (configuration,
            folder); None for a study without any.
    """

    configure: Callable[[bool, int], Any]
    tasks: Callable[[Any], Sequence[Task]]
    report: Callable[[Any, list[Row]], Report]
    of_recordings: Callable[[Any, Path], Any] | None = None


@dataclass(frozen=True, eq=False)
class Outcome:
    """The result of a study.

    Attributes:
        rows: rows in the order of the tasks.
        failures: the arguments of each failed task, with its error.
        report: the report.
    """

    rows: list[Row]
    failures: list[Row]
    report: Report


def run(
    study: Study,
    config: Any,
    *,
    out: Path,
    on: str | None = None,
    task_timeout: float | None = None,
) -> Outcome:
    """Run the tasks that have no rows yet; write results.json, table.csv and the figures.

    results.json and manifest.json are written whatever becomes of the tasks.

    Args:
        study: the study to run.
        config: its configuration.
        out: folder for the results, made if missing.
        on: processes or cluster, as for `leadthrough.tasks.run`; None for this process.
        task_timeout: the longest that a task may take, s; None for no bound.

    Raises:
        InvalidInput: if an argument is wrong, a file cannot be written or a worker has other code.
        MissingDependency: for a Dask cluster, if the extra `dask` is not installed.
        SchedulerUnreachable: if its scheduler does not answer any more.
    """
    todo = study.tasks(config)
    store = tasks.Store(out / _STORE)
    failures: dict[int, Row] = {}
    stopped: BaseException | None = None
    try:
        outcomes = tasks.run(todo, store, on=on, timeout=task_timeout)
        for each in tasks.with_progress(tasks.with_manifest(outcomes, out), len(todo), "tasks"):
            if each.failure:
                failures[each.index] = {"task": todo[each.index].arguments, **each.failure}
    except (KeyboardInterrupt, SchedulerUnreachable, CodeMismatch) as error:
        stopped = error
    outcome = _written(study, config, out, todo, [failures[i] for i in sorted(failures)])
    if stopped is not None:
        raise stopped
    return outcome


def _written(
    study: Study, config: Any, out: Path, todo: Sequence[Task], failures: list[Row]
) -> Outcome:
    """The outcome, in files; where the report fails for want of rows, that is a failure too."""
    store = tasks.Store(out / _STORE)
    known = [store.rows(task.key) for task in todo]
    rows = [row for found in known for row in found or ()]
    missing = sum(found is None for found in known) - len(failures)
    try:
        with styled():
            report = study.report(config, rows)
    except Exception as error:
        if not missing and not failures:
            raise
        report = Report([])
        failures = [*failures, {"task": "report", **_told(error)}]
    results.write(
        out,
        document={
            "configuration": asdict(config),
            "versions": versions(todo),
            "summary": report.summary,
            "table": report.table,
            "unfinished": missing,
            "failures": failures,
        },
        rows=rows,
        tables={"table": report.table, **report.tables},
        figures=report.figures,
        pages=report.pages,
    )
    return Outcome(rows, failures, report)


def _told(error: Exception) -> Row:
    lines = "".join(traceback.format_exception(error))
    return {"error": type(error).__name__, "message": str(error), "traceback": lines}


def versions(todo: Sequence[Task]) -> dict[str, str]:
    """Versions of everything that the results depend on besides the configuration.

    Args:
        todo: the tasks that make them.
    """
    modules = sorted({task.function.__module__ for task in todo})
    return {
        **{name: version(name) for name in _LIBRARIES},
        "code": " ".join(digest(module) for module in modules),
        "python": platform.python_version(),
        "machine": f"{platform.system()} {platform.machine()}",
    }


def selected(rows: Sequence[Row], **values: Any) -> list[Row]:
    """The rows whose columns have the given values."""
    return [row for row in rows if all(row.get(name) == value for name, value in values.items())]


def mean(rows: Sequence[Row], column: str) -> float | None:
    """The mean of a column over the rows that have it, or None if none has."""
    values = [row[column] for row in rows if column in row]
    return sum(values) / len(values) if values else None


def cpu_time(work: Callable[[], object], *, runs: int = 3) -> float:
    """The smallest processor time of a few runs, s; longer runs were disturbed.

    Args:
        work: called without arguments.
        runs: number of runs.
    """
    times = []
    for _ in range(runs):
        before = time.process_time()
        work()
        times.append(time.process_time() - before)
    return min(times)

"""Studies: a frozen configuration in; rows, a table and figures out.

A study consists of independent tasks. They run in a number of processes, or wherever
`joblib.parallel_config` sends them. The folder of the results keeps the rows of each task until its
arguments or the package's code change, so that a study that was stopped resumes where it was.
"""

from __future__ import annotations

import hashlib
import json
import platform
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, field
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from joblib import Parallel, delayed, parallel_config
from matplotlib.figure import Figure
from rich.console import Console
from rich.progress import track

import leadthrough
from leadthrough import _core, check
from leadthrough.drawing import style
from leadthrough_studies import results

Row = dict[str, Any]

# The packages whose code determines the rows.
_PACKAGES = (Path(leadthrough.__file__).parent, Path(__file__).parent)
_LIBRARIES = ("leadthrough", "numpy", "scipy", "joblib")
# Code that only displays the rows.
_WITHOUT_INFLUENCE = ("show/*", "cli/*", "*/report.py")


@dataclass(frozen=True)
class Task:
    """A piece of work: `function(**arguments)` returns rows of text and finite numbers.

    Columns whose names end in "_cpu_s" hold measured processor times; all others are the same in
    every run.

    Attributes:
        function: importable by its name.
        arguments: values that JSON can hold; they include the seed if the function uses random
            numbers.
    """

    function: Callable[..., list[Row]]
    arguments: dict[str, Any]

    @property
    def key(self) -> str:
        """A text that changes with the arguments, the function and the package's code."""
        name = f"{self.function.__module__}.{self.function.__qualname__}"
        text = json.dumps([code_digest(), name, self.arguments], sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:32]


@dataclass(frozen=True, eq=False)
class Report:
    """What a study shows of its rows.

    Attributes:
        table: the main numbers, with the same columns in every row.
        figures: figures by file stem.
        summary: what else belongs in results.json.
    """

    table: list[Row]
    figures: dict[str, Figure] = field(default_factory=dict)
    summary: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Study:
    """The three functions that make up a study.

    Attributes:
        configure: returns the configuration, a frozen dataclass, for (quick, seed).
        tasks: returns the tasks of a configuration, in a fixed order.
        report: returns the report of a configuration and its rows; rows of failed tasks are
            missing.
    """

    configure: Callable[[bool, int], Any]
    tasks: Callable[[Any], Sequence[Task]]
    report: Callable[[Any, list[Row]], Report]


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


def run(study: Study, config: Any, *, out: Path, jobs: int | None = None) -> Outcome:
    """Run the tasks that have no rows yet; write results.json, table.csv and the figures.

    Args:
        study: the study to run.
        config: its configuration.
        out: folder for the results, made if missing.
        jobs: number of processes; None for the setting of `joblib.parallel_config`.

    Raises:
        InvalidInput: if jobs is not a positive integer or a file cannot be written.
    """
    tasks = study.tasks(config)
    rows, failures = _solve_all(tasks, out, jobs)
    with style.applied():
        report = study.report(config, rows)
    results.write(
        out,
        document={
            "configuration": asdict(config),
            "versions": versions(),
            "summary": report.summary,
            "table": report.table,
            "failures": failures,
        },
        rows=rows,
        table=report.table,
        figures=report.figures,
    )
    return Outcome(rows, failures, report)


def versions() -> dict[str, str]:
    """Versions of everything that the results depend on besides the configuration."""
    return {
        **{name: version(name) for name in _LIBRARIES},
        "code": code_digest(),
        "python": platform.python_version(),
        "machine": f"{platform.system()} {platform.machine()}",
    }


@cache
def code_digest() -> str:
    """A digest of the sources and the compiled core that determine the rows of a study."""
    sources = [path for package in _PACKAGES for path in _deciding(package)]
    digest = hashlib.sha256()
    for path in (*sources, Path(_core.__file__)):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def _deciding(package: Path) -> list[Path]:
    idle = {path for pattern in _WITHOUT_INFLUENCE for path in package.glob(pattern)}
    return sorted(set(package.rglob("*.py")) - idle)


def _solve_all(tasks: Sequence[Task], out: Path, jobs: int | None) -> tuple[list[Row], list[Row]]:
    store = results.Store(out / "cache")
    known = [store.read(task.key) for task in tasks]
    missing = [i for i, rows in enumerate(known) if rows is None]
    failures: dict[int, Row] = {}
    for i, text, failure in _progress(tasks, missing, jobs):
        if failure:
            failures[i] = {"task": tasks[i].arguments, **failure}
        else:
            known[i] = store.write(tasks[i].key, text)
    return [row for rows in known for row in rows or ()], [failures[i] for i in sorted(failures)]


def _progress(
    tasks: Sequence[Task], missing: Sequence[int], jobs: int | None
) -> Iterator[tuple[int, str, Row]]:
    solved = _parallel(jobs)(
        delayed(_attempt)(i, tasks[i].function, tasks[i].arguments) for i in missing
    )
    description = f"{len(missing)} of {len(tasks)} tasks"
    console = Console(stderr=True)
    yield from track(solved, description=description, total=len(missing), console=console)


def _parallel(jobs: int | None) -> Parallel:
    if jobs is None:
        return Parallel(return_as="generator_unordered")
    count = check.integer(jobs, "jobs", at_least=1)
    # BLAS gets one thread, for equal bits and honest processor times. A running process cannot be
    # limited any more, so a single job also runs in a new process; the second one gets no work.
    with parallel_config(backend="loky", n_jobs=max(count, 2), inner_max_num_threads=1):
        return Parallel(return_as="generator_unordered", pre_dispatch=count, batch_size=1)


def _attempt(
    index: int, function: Callable[..., list[Row]], arguments: dict[str, Any]
) -> tuple[int, str, Row]:
    """The rows as JSON, or the error: one failing task must not lose the work of the others."""
    try:
        return index, json.dumps(function(**arguments), allow_nan=False), {}
    except Exception as error:
        return index, "", {"error": type(error).__name__, "message": str(error)}


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

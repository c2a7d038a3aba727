"""A study: a frozen configuration in; rows, a table and figures out.

A study is cut into tasks that know nothing of one another. They run in as many processes as
wanted, or wherever `joblib.parallel_config` sends them, and what each has found is kept in the
folder of the results until its arguments or the package's code change: a study that was stopped
goes on where it was.
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
from leadthrough.show import style
from leadthrough_studies import results

Row = dict[str, Any]

# The packages whose code decides what is found.
_PACKAGES = (Path(leadthrough.__file__).parent, Path(__file__).parent)
_LIBRARIES = ("leadthrough", "numpy", "scipy", "joblib")
# Code that only shows what was found.
_WITHOUT_INFLUENCE = ("show/*", "cli/*", "*/report.py")


@dataclass(frozen=True)
class Task:
    """A piece of work: `function(**arguments)` gives rows of text and finite numbers.

    function: importable by its name. arguments: what JSON can hold, the seed among them where
    the function draws at random. The processor time it measures goes into columns whose names end
    in "_cpu_s": all others are the same in every run.
    """

    function: Callable[..., list[Row]]
    arguments: dict[str, Any]

    @property
    def key(self) -> str:
        """Changes with the arguments, the function and the package's code."""
        name = f"{self.function.__module__}.{self.function.__qualname__}"
        text = json.dumps([code_digest(), name, self.arguments], sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:32]


@dataclass(frozen=True, eq=False)
class Report:
    """table: the study's main figures, the same columns in every row. figures: by file stem.

    summary: whatever else is to stand in results.json.
    """

    table: list[Row]
    figures: dict[str, Figure] = field(default_factory=dict)
    summary: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Study:
    """configure: (quick, seed) to a frozen dataclass. tasks: of a configuration, in a fixed order.

    report: of a configuration and all rows, some of which may be missing because a task failed.
    """

    configure: Callable[[bool, int], Any]
    tasks: Callable[[Any], Sequence[Task]]
    report: Callable[[Any, list[Row]], Report]


@dataclass(frozen=True, eq=False)
class Outcome:
    """rows: in the order of the tasks. failures: tasks without rows, and why."""

    rows: list[Row]
    failures: list[Row]
    report: Report


def run(study: Study, config: Any, *, out: Path, jobs: int | None = None) -> Outcome:
    """Solve what is not solved yet; write results.json, table.csv and the figures into `out`.

    jobs: processes; None for what `joblib.parallel_config` says. Raises InvalidInput.
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
    """What the results depend on besides the configuration."""
    return {
        **{name: version(name) for name in _LIBRARIES},
        "code": code_digest(),
        "python": platform.python_version(),
        "machine": f"{platform.system()} {platform.machine()}",
    }


@cache
def code_digest() -> str:
    """A digest of the sources and the compiled core that decide what a study finds."""
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
    # BLAS gets one thread, for equal bits and honest processor times. A process that runs cannot be
    # told so any more: a single job has a second process beside it, which gets no work.
    with parallel_config(backend="loky", n_jobs=max(count, 2), inner_max_num_threads=1):
        return Parallel(return_as="generator_unordered", pre_dispatch=count, batch_size=1)


def _attempt(
    index: int, function: Callable[..., list[Row]], arguments: dict[str, Any]
) -> tuple[int, str, Row]:
    """The rows as JSON, or what went wrong: one bad task must not cost the others' work."""
    try:
        return index, json.dumps(function(**arguments), allow_nan=False), {}
    except Exception as error:
        return index, "", {"error": type(error).__name__, "message": str(error)}


def selected(rows: Sequence[Row], **values: Any) -> list[Row]:
    """The rows whose columns have the values given."""
    return [row for row in rows if all(row.get(name) == value for name, value in values.items())]


def mean(rows: Sequence[Row], column: str) -> float | None:
    """The mean of a column over the rows that have it, None where none has."""
    values = [row[column] for row in rows if column in row]
    return sum(values) / len(values) if values else None


def cpu_time(work: Callable[[], object], *, runs: int = 3) -> float:
    """The least processor time of a few runs, s: what the others took longer was not the work."""
    times = []
    for _ in range(runs):
        before = time.process_time()
        work()
        times.append(time.process_time() - before)
    return min(times)

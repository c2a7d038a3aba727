"""Tasks in, outcomes out as they come; what is in the store is not done again."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from leadthrough import check
from leadthrough.tasks.place import Place, opened
from leadthrough.tasks.store import Store
from leadthrough.tasks.task import Report, Task, job


@dataclass(frozen=True)
class Outcome:
    """What became of a task.

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

    No more tasks are looked at than the workers have room for, and no rows are kept in memory.
    Where the caller stops early, what is running is dropped.

    Args:
        tasks: what to do.
        store: takes the rows.
        on: "local:N" for N processes of this machine, the address of a Dask scheduler such as
            "tcp://host:8786" or the .json file that it wrote; None for this process, where a task
            can neither be bounded in time nor end its process alone.
        timeout: the longest that a task may take, s, > 0; None for no bound.

    Yields:
        An outcome for each task.

    Raises:
        InvalidInput: if an argument is wrong, the store cannot be written, a function cannot be
            imported by its name, or a worker of the cluster has other code.
        MissingDependency: for a cluster, if the extra `dask` is not installed.
        ClusterLost: if the scheduler does not answer any more.
    """
    bound = None if timeout is None else check.number(timeout, "task_timeout", above=0.0)
    place = opened(on)
    try:
        yield from _outcomes(tasks, store, place, bound)
    finally:
        place.close()


def _outcomes(
    tasks: Iterable[Task], store: Store, place: Place, timeout: float | None
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
        place.submit(task, job(task, identity, timeout))
        while len(waiting) >= place.room:
            yield from _finished(waiting, store, place)
    while waiting:
        yield from _finished(waiting, store, place)


def _finished(waiting: dict[str, list[int]], store: Store, place: Place) -> Iterator[Outcome]:
    """The outcomes of the task that is finished next, in the store before they are told."""
    report = place.next()
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

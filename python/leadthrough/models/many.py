"""Many motions of a skill at once, on several threads."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar

from leadthrough import check
from leadthrough.errors import InvalidInput
from leadthrough.models.protocol import Generator
from leadthrough.motion import MotionT

_Value = TypeVar("_Value")
_Result = TypeVar("_Result")
_MOST_THREADS = 256


def generate_all(
    skill: Generator[MotionT], queries: Sequence[Mapping[str, Any]], *, threads: int = 1
) -> list[MotionT]:
    """What a skill generates for each of several queries.

    Threads help as far as the compiled core computes, which lets other threads run meanwhile: past
    obstacles and along many samples. Short plans without obstacles are mostly Python.

    Args:
        skill: any skill.
        queries: the keyword arguments of `generate`, for each motion.
        threads: number of threads, 1 to 256; does not change the answers.

    Raises:
        InvalidInput: if a query is wrong or no mapping.
        UnsupportedQuery: for a part of a query that the skill does not support.
        NoPath: where obstacles leave no way. The first query that has no answer says why.
    """
    for i, query in enumerate(queries):
        if not isinstance(query, Mapping):
            raise InvalidInput(
                f"queries[{i}]: expected the arguments of generate by name, as in "
                f"{{'goal': (0.4, 0.1, 0.2)}}, got {type(query).__name__}"
            )
    return mapped(lambda query: skill.generate(**query), queries, threads)


def checked_threads(threads: int) -> int:
    """The number of threads, if it is 1 to 256."""
    return check.integer(threads, "threads", at_least=1, at_most=_MOST_THREADS)


def mapped(
    function: Callable[[_Value], _Result], values: Iterable[_Value], threads: int
) -> list[_Result]:
    """The function's results, in the order of the values, on that many threads."""
    count = checked_threads(threads)
    every = list(values)
    if count == 1:
        return [function(value) for value in every]
    runs = _runs(every, count)
    with ThreadPoolExecutor(count) as pool:
        done = pool.map(lambda run: [function(value) for value in run], runs)
        return [result for run in done for result in run]


def _runs(values: Sequence[_Value], threads: int) -> list[Sequence[_Value]]:
    """The values in consecutive runs: a task costs some tens of microseconds."""
    runs = []
    first = 0
    while first < len(values):
        size = max(1, (len(values) - first) // (2 * threads))
        runs.append(values[first : first + size])
        first += size
    return runs

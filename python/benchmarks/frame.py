"""Benchmarks and how they run: the answers are compared first, then the times."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

# Short calls are repeated for this long, s, or other processes decide their least time.
MIN_TIME = 0.3


@dataclass(frozen=True)
class Benchmark:
    """Our function and a peer's on one problem.

    Attributes:
        name: the problem.
        ours: returns our answer; called without arguments.
        peer: returns the peer's answer; called without arguments.
        peer_name: the peer's library.
        error: of our answer, given ours and the peer's.
        tolerance: the largest error that passes.
        clock: returns seconds; CPU seconds of all threads unless threads are measured.
        calls: if positive, both functions take the number of a call, 0 to calls - 1, and each call
            is timed by itself; `error` then gets the lists of answers.
    """

    name: str
    ours: Callable[..., Any]
    peer: Callable[..., Any]
    peer_name: str
    error: Callable[[Any, Any], float]
    tolerance: float
    clock: Callable[[], float] = time.process_time
    calls: int = 0


@dataclass(frozen=True)
class Row:
    """One result. Times are in seconds; the ratio is the peer's best time over ours.

    If calls were timed one by one, there are 99th percentiles, and the ratio is of the medians.
    """

    name: str
    peer: str
    error: float
    tolerance: float
    passed: bool
    ours_best: float | None = None
    ours_median: float | None = None
    peer_best: float | None = None
    peer_median: float | None = None
    ratio: float | None = None
    ours_p99: float | None = None
    peer_p99: float | None = None


def measure(benchmark: Benchmark, repeats: int) -> Row:
    """The row of a benchmark, without times if the answers differ.

    Our runs and the peer's alternate, so that a busy machine slows both; there are at least so
    many repeats of each.
    """
    if benchmark.calls:
        return _measure_calls(benchmark)
    error = float(benchmark.error(benchmark.ours(), benchmark.peer()))
    passed = bool(error <= benchmark.tolerance)
    answer = (benchmark.name, benchmark.peer_name, error, benchmark.tolerance, passed)
    if not passed:
        return Row(*answer)
    ours: list[float] = []
    peer: list[float] = []
    while len(ours) < repeats or sum(ours) + sum(peer) < MIN_TIME:
        ours.append(_seconds(benchmark.ours, benchmark.clock))
        peer.append(_seconds(benchmark.peer, benchmark.clock))
    return Row(
        *answer,
        ours_best=min(ours),
        ours_median=statistics.median(ours),
        peer_best=min(peer),
        peer_median=statistics.median(peer),
        ratio=min(peer) / min(ours),
    )


def _measure_calls(benchmark: Benchmark) -> Row:
    """The row of single calls; both sides take turns of a hundred calls."""
    answers: tuple[list[Any], list[Any]] = ([], [])
    times: tuple[list[float], list[float]] = ([], [])
    for first in range(0, benchmark.calls, 100):
        for side, function in enumerate((benchmark.ours, benchmark.peer)):
            for call in range(first, min(first + 100, benchmark.calls)):
                start = benchmark.clock()
                answer = function(call)
                times[side].append(benchmark.clock() - start)
                answers[side].append(answer)
    error = float(benchmark.error(*answers))
    passed = bool(error <= benchmark.tolerance)
    answer = (benchmark.name, benchmark.peer_name, error, benchmark.tolerance, passed)
    if not passed:
        return Row(*answer)
    ours, peer = times
    return Row(
        *answer,
        ours_best=min(ours),
        ours_median=statistics.median(ours),
        peer_best=min(peer),
        peer_median=statistics.median(peer),
        ratio=statistics.median(peer) / statistics.median(ours),
        ours_p99=statistics.quantiles(ours, n=100)[-1],
        peer_p99=statistics.quantiles(peer, n=100)[-1],
    )


def _seconds(function: Callable[[], Any], clock: Callable[[], float]) -> float:
    start = clock()
    function()
    return clock() - start

"""What a benchmark is, and how it is run: first the answers are compared, then the times."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Benchmark:
    """Our function and a peer's on one problem.

    name: the problem. ours, peer: called without arguments, return their answers. peer_name: the
    library. error: of our answer against the peer's. tolerance: the largest error that passes.
    clock: what measures; CPU seconds of all threads but where threads are the point.
    """

    name: str
    ours: Callable[[], Any]
    peer: Callable[[], Any]
    peer_name: str
    error: Callable[[Any, Any], float]
    tolerance: float
    clock: Callable[[], float] = time.process_time


@dataclass(frozen=True)
class Row:
    """One result. Times are seconds; ratio is the peer's best time over ours."""

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


def measure(benchmark: Benchmark, repeats: int) -> Row:
    """The row of a benchmark; without times if the answers differ.

    Ours and the peer's runs alternate, so that a busy machine slows both.
    """
    error = float(benchmark.error(benchmark.ours(), benchmark.peer()))
    passed = error <= benchmark.tolerance
    answer = (benchmark.name, benchmark.peer_name, error, benchmark.tolerance, passed)
    if not passed:
        return Row(*answer)
    ours, peer = [], []
    for _ in range(repeats):
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


def _seconds(function: Callable[[], Any], clock: Callable[[], float]) -> float:
    start = clock()
    function()
    return clock() - start

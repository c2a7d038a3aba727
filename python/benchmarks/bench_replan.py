"""Repair of arrival times when a box appears and vanishes, against a full march; batches.

The box invalidates under 2 % of the cells. In the rows "whole map" the update includes finding the
cells that have changed.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np
from bench_eikonal import constant_speed, relative_error, variable_speed
from frame import Benchmark

import leadthrough as lt
from leadthrough.planning import ArrivalField, arrival_times_batch

TOLERANCE = {"float64": 1e-6, "float32": 1e-5}  # relative to the latest time
MAX_INVALID = 0.02  # of the cells
THREADS = 2


def benchmarks(*, quick: bool) -> Iterator[Benchmark]:
    """Rows for 2-D and 3-D fields."""
    # Start of the box along every axis, as a fraction: all cells behind it lie in its shadow.
    quick_shapes = {(300, 300): 0.88, (60, 60, 60): 0.83}
    full_shapes = {(1000, 1000): 0.88, (150, 150, 150): 0.75}
    for shape, low in (quick_shapes if quick else full_shapes).items():
        size = " x ".join(map(str, shape))
        for kind, (speed, source) in {
            "constant speed": constant_speed(shape),
            "variable speed, walls": variable_speed(shape),
        }.items():
            for precision in ("float32", "float64"):
                problem = (speed.astype(precision), source)
                yield from _replans(f"{size}, {kind}, {precision}", *problem, low)
        yield _batch(f"8 marches {size}, float32, {THREADS} threads, wall time", shape)


def _replans(name: str, speed: Any, source: tuple[int, ...], low: float) -> Iterator[Benchmark]:
    grid = lt.Grid(np.zeros(speed.ndim), 1.0, speed.shape)
    field = ArrivalField(speed, grid, np.array(source, float), dtype=speed.dtype)
    box = tuple(slice(round(low * n), round((low + 0.07) * n)) for n in speed.shape)
    free, blocked = speed[box].copy(), np.zeros_like(speed[box])
    walled = speed.copy()
    walled[box] = 0.0
    if not field.update_part(box, blocked).invalidated < MAX_INVALID * speed.size:
        raise ValueError(f"{name}: the box invalidates too many cells")
    field.update_part(box, free)

    def part() -> list[Any]:
        return [_times_after(field.update_part, box, values, field) for values in (blocked, free)]

    def whole() -> list[Any]:
        return [_times_after(field.update, values, field) for values in (walled, speed)]

    def anew() -> list[Any]:
        return [lt.arrival_times(s, source, dtype=speed.dtype) for s in (walled, speed)]

    for way, ours in (("box", part), ("whole map", whole)):
        yield Benchmark(
            name=f"replan {name}, {way}",
            ours=ours,
            peer=anew,
            peer_name="full march",
            error=lambda a, b: max(map(relative_error, a, b)),
            tolerance=TOLERANCE[str(speed.dtype)],
        )


def _times_after(update: Any, *arguments: Any) -> Any:
    *values, field = arguments
    update(*values)
    return field.times


def _batch(name: str, shape: tuple[int, ...]) -> Benchmark:
    speed, source = variable_speed(shape)
    maps = [(speed * factor).astype(np.float32) for factor in np.linspace(0.5, 1.0, 8)]
    batch = partial(arrival_times_batch, maps, [source], dtype=np.float32, threads=THREADS)
    return Benchmark(
        name=name,
        ours=batch,
        peer=lambda: [lt.arrival_times(s, source, dtype=np.float32) for s in maps],
        peer_name="one by one",
        error=lambda a, b: max(map(relative_error, a, b)),
        tolerance=0.0,
        clock=time.perf_counter,
    )

"""Runs the benchmarks: python python/benchmarks/run.py [OPTIONS], see --help.

Prints a table and writes benchmarks.json, with versions and the machine's data, and scaling.svg:
how costs grow with the size of a problem, ours and the peers'. A complete run also writes table.md,
the table of docs/speed.md, and --check compares its figures with that page's. If calls are timed
one by one, times are median/99th percentile in us. Answers are checked first; a wrong one fails
the run.
With --loops it times the steps of control loops instead, a million each; with --waits what a
person waits for: plans, drags on the live page and commands.
"""

from __future__ import annotations

import argparse
import importlib
import importlib.metadata
import json
import os
import platform
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

# Before NumPy is loaded: processor time counts all threads, and those of linear algebra mostly wait
# for one another on small matrices, the peers' as ours.
for _threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_threads] = "1"

import control_loop  # noqa: E402
import printed  # noqa: E402
import waits  # noqa: E402
from frame import Row, measure  # noqa: E402

FILES = [
    "bench_arm",
    "bench_band",
    "bench_collision",
    "bench_curves",
    "bench_differential",
    "bench_dmp",
    "bench_dynamics",
    "bench_eikonal",
    "bench_ik",
    "bench_learning",
    "bench_models",
    "bench_paths",
    "bench_replan",
    "bench_time_law",
    "bench_two_arms",
    "bench_way_points",
]
SPEED = Path(__file__).parents[2] / "docs" / "speed.md"
REPEATS = {"quick": 3, "full": 5}


def main() -> int:
    """Run the benchmarks; the exit code is 0 if all answers agree and docs/speed.md holds."""
    options = _options()
    if options.loops:
        control_loop.run(options.out, steps=control_loop.STEPS // (100 if options.quick else 1))
        return 0
    if options.waits:
        return 0 if waits.run(options.out, quick=options.quick) else 1
    repeats = REPEATS["quick" if options.quick else "full"]
    print(f"{'problem':<65} {'peer':<12} {'error':>8} {'ours s':>9} {'peer s':>9} {'ratio':>6}")
    rows = []
    for name in FILES:
        for benchmark in importlib.import_module(name).benchmarks(quick=options.quick):
            if options.only in benchmark.name:
                rows.append(measure(benchmark, repeats))
                print(_text(rows[-1]), flush=True)
    if not options.only:
        rows += _scaling(options.out, quick=options.quick)
    _write(
        options.out / "benchmarks.json", json.dumps(_report(rows, quick=options.quick), indent=2)
    )
    if not options.quick and not options.only:
        _write(options.out / "table.md", printed.table(rows))
    holds = not options.check or _table_holds(rows)
    return 0 if holds and all(row.passed for row in rows) else 1


def _scaling(out: Path, *, quick: bool) -> list[Row]:
    """Rows of growing problems, which it prints and draws."""
    scaling = importlib.import_module("scaling")
    results = []
    for series, rows in scaling.measured(quick=quick):
        results.append((series, rows))
        print(*map(_text, rows), sep="\n", flush=True)
    scaling.plot(results, out / "scaling.svg")
    print(f"written: {out / 'scaling.svg'}")
    return [row for _, rows in results for row in rows]


def _table_holds(rows: Sequence[Row]) -> bool:
    faults = printed.too_good(SPEED.read_text(), rows)
    for fault in faults:
        print(fault)
    return not faults


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="run small problems, in two minutes")
    parser.add_argument(
        "--check",
        action="store_true",
        help="end with 1 if a figure in docs/speed.md is over 15 %% better than measured",
    )
    parser.add_argument(
        "--loops", action="store_true", help="time steps of control loops, and nothing else"
    )
    parser.add_argument(
        "--waits",
        action="store_true",
        help="time what a person waits for, and nothing else; end with 1 if it takes too long",
    )
    parser.add_argument(
        "--out", type=Path, default=Path("benchmark-results"), help="folder for the results"
    )
    parser.add_argument(
        "--only", default="", help="run only the problems whose name contains this text"
    )
    options = parser.parse_args()
    if options.check and (options.quick or options.only):
        parser.error("--check needs a complete run: leave --quick and --only away")
    return options


def _text(row: Row) -> str:
    head = f"{row.name:<65} {row.peer:<12} {row.error:8.1e}"
    if not row.passed:
        return f"{head} WRONG ANSWER: expected at most {row.tolerance:.1e}"
    if row.ours_p99 is None:
        return f"{head} {row.ours_best:9.4f} {row.peer_best:9.4f} {row.ratio:6.1f}"
    # A call's median and 99th percentile, us.
    ours, peer = (
        f"{1e6 * median:.0f}/{1e6 * p99:.0f}"
        for median, p99 in ((row.ours_median, row.ours_p99), (row.peer_median, row.peer_p99))
    )
    return f"{head} {ours:>9} {peer:>9} {row.ratio:6.1f}"


def _report(rows: list[Row], *, quick: bool) -> dict[str, Any]:
    libraries = ["leadthrough", "numpy", "scipy", *sorted({row.peer for row in rows})]
    return {
        "quick": quick,
        "times": "CPU seconds, or wall time where the name says so; best and median of runs that "
        "alternate with the peer's; of single calls if there is a 99th percentile",
        "machine": {
            "processor": _processor(),
            "processors": os.cpu_count(),
            "system": platform.platform(),
            "python": platform.python_version(),
        },
        "versions": {name: _version(name) for name in dict.fromkeys(map(str.lower, libraries))},
        "rows": [asdict(row) for row in rows],
    }


def _processor() -> str:
    facts = Path("/proc/cpuinfo")
    lines = facts.read_text().splitlines() if facts.exists() else []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else platform.processor()


def _version(name: str) -> str | None:
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return None


def _write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    print(f"written: {path}")


if __name__ == "__main__":
    sys.exit(main())

"""A study for the tests of the engine: as a program, python -m tasks.of_numbers OUT ON."""

import signal
import sys
from dataclasses import dataclass
from pathlib import Path

from tasks import work

from leadthrough_studies import study

COUNT = 60


@dataclass(frozen=True)
class Nothing:
    """No configuration."""


def study_of(todo):
    def report(config, rows):
        return study.Report([{"rows": len(rows), "sum": sum(row["norm"] for row in rows)}])

    return study.Study(configure=lambda *_: Nothing(), tasks=lambda _: todo, report=report)


def slow(out):
    return work.draws_of(COUNT, out / "log", 0.1)


if __name__ == "__main__":
    # Programs that a shell starts in the background ignore Ctrl-C unless they say otherwise.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    folder = Path(sys.argv[1])
    study.run(study_of(slow(folder)), Nothing(), out=folder, on=sys.argv[2])

"""Which small faults the tests notice: draws mutants, and runs the tests of their part on each.

    nice python tests/mutants/run.py build/mutants --count 300

The table, mutants.csv in the folder, has a row for each mutant: what was changed, and the first
test that failed; "" where all passed, "hang" where they ran over their time. A run that was stopped
goes on where it was; `--again` runs those that survived once more, after tests were added.
"""

from __future__ import annotations

import argparse
import csv
import dataclasses
import json
import resource
import signal
import sys
import tomllib
from collections import Counter
from itertools import chain, zip_longest
from pathlib import Path

from mutations import Mutant, drawn
from tree import DoesNotCompile, Tree

ROOT = Path(__file__).parents[2]
COLUMNS = (*(field.name for field in dataclasses.fields(Mutant)), "killed_by", "seconds")
NO_PROGRAM = "does not compile"
# Processor time that a part's tests may take: as often that without a fault, and some to begin, s.
SLOWER, BEGIN = 2.0, 10.0
# A header that more sources include takes minutes to compile, and is left out.
MAX_DEPENDENTS = 5


class Table:
    """Results in a file that grows by a row for each mutant."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self.rows: dict[Mutant, dict[str, str]] = {}
        if path.is_file():
            with path.open(newline="") as file:
                for row in csv.DictReader(file):
                    self.rows[_mutant_of(row)] = row

    def add(self, mutant: Mutant, killed_by: str, seconds: float) -> None:
        """Adds a row, or puts it in the place of the one that the mutant has."""
        row = {name: str(value) for name, value in dataclasses.asdict(mutant).items()}
        self.rows[mutant] = row | {"killed_by": killed_by, "seconds": f"{seconds:.1f}"}
        with self._path.open("w", newline="") as file:
            writer = csv.DictWriter(file, COLUMNS)
            writer.writeheader()
            writer.writerows(self.rows.values())

    def summary(self) -> str:
        """Killed and survived, for each part."""
        count: dict[str, Counter[str]] = {}
        for row in self.rows.values():
            if row["killed_by"] != NO_PROGRAM:
                told = "killed" if row["killed_by"] else "survived"
                count.setdefault(row["part"], Counter())[told] += 1
        lines = [f"{part:20}{c['killed']:4} of {c.total()} killed" for part, c in count.items()]
        total = sum(count.values(), Counter[str]())
        return "\n".join([*lines, f"{'all':20}{total['killed']:4} of {total.total()} killed"])


def main() -> None:
    """Draws, tries and writes."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, help="of the private copy, its build and the table")
    parser.add_argument("--count", type=int, default=300, help="mutants, evenly over the parts")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--again", action="store_true", help="only those that survived")
    options = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # with the source as it was
    folder = options.folder.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    parts = tomllib.loads((ROOT / "tests/mutants/parts.toml").read_text())
    tree, table = Tree(ROOT, folder), Table(folder / "mutants.csv")
    tests = {part: tree.files(each["tests"]) for part, each in parts.items()}
    unchanged = Unchanged(folder / "unchanged.json", tree)
    if options.again:
        for mutant in [each for each, row in table.rows.items() if not row["killed_by"]]:
            judge(mutant, tree, table, tests[mutant.part], unchanged)
    else:
        draws = [
            drawn(part, tree.root, each["sources"], options.seed) for part, each in parts.items()
        ]
        left = options.count
        for mutant in filter(None, chain.from_iterable(zip_longest(*draws))):
            if left == 0:
                break
            if tree.dependents(mutant.path) > MAX_DEPENDENTS:
                continue
            if mutant not in table.rows:
                judge(mutant, tree, table, tests[mutant.part], unchanged)
            left -= table.rows[mutant]["killed_by"] != NO_PROGRAM
    print(table.summary())


class Unchanged:
    """How much processor time the tests of each part take without a mutant, in a file."""

    def __init__(self, path: Path, tree: Tree) -> None:
        self._path, self._tree = path, tree
        self._seconds: dict[str, float] = json.loads(path.read_text()) if path.is_file() else {}

    def limit(self, part: str, tests: list[str]) -> float:
        """The time that they may take with one, s."""
        if part not in self._seconds:
            began = _spent()
            if failed := self._tree.passes(tests):
                raise SystemExit(f"{failed} fails without a mutant")
            self._seconds[part] = _spent() - began
            self._path.write_text(json.dumps(self._seconds))
        return SLOWER * self._seconds[part] + BEGIN


def judge(mutant: Mutant, tree: Tree, table: Table, tests: list[str], unchanged: Unchanged) -> None:
    """Runs the tests of a part on a mutant."""
    limit = unchanged.limit(mutant.part, tests)
    began = _spent()
    text = mutant.applied((tree.root / mutant.path).read_text(encoding="utf-8"))
    try:
        order = likeliest(mutant, table, tests)
        killed_by = tree.fails_on(mutant.path, text, order, limit=limit)
    except DoesNotCompile:
        killed_by = NO_PROGRAM
    table.add(mutant, killed_by, _spent() - began)
    place = f"{mutant.path}:{mutant.line}:{mutant.column}"
    print(f"{place} {mutant.old} -> {mutant.new}: {killed_by or 'SURVIVED'}", flush=True)


def likeliest(mutant: Mutant, table: Table, tests: list[str]) -> list[str]:
    """The tests of a part: those named like the source, then those that noticed most others."""
    rows = [row for row in table.rows.values() if row["part"] == mutant.part]
    killers = Counter(row["killed_by"].partition("::")[0] for row in rows)
    alike = f"test_{Path(mutant.path).stem}.py"
    return sorted(tests, key=lambda test: (Path(test).name != alike, -killers[test]))


def _spent() -> float:
    """Processor time of all programs that have ended, s."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _mutant_of(row: dict[str, str]) -> Mutant:
    fields = {name: row[name] for name in COLUMNS[:-2]}
    return Mutant(**fields | {"line": int(row["line"]), "column": int(row["column"])})


if __name__ == "__main__":
    main()

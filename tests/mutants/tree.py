"""A private copy of the repository that is built once; a mutant compiles only what it changes."""

from __future__ import annotations

import json
import os
import re
import resource
import shlex
import shutil
import subprocess
import sys
from collections.abc import Sequence
from contextlib import contextmanager
from pathlib import Path

_FOLDERS = ("cpp", "docs", "python", "robots", "tests")
_FILES = ("CMakeLists.txt", "pyproject.toml")
_MEMORY = 12 * 2**30  # bytes of addresses, for what a fault allocates without end
_PATIENCE = 20  # times as long as its processor time a test may wait, s
_TEST = re.compile(r"^TEST(?:_[FP])?\((\w+),", re.MULTILINE)
_FAILED = re.compile(r"^(?:\[  FAILED  \]|FAILED|ERROR) (\S+)", re.MULTILINE)
# An editable install would find the package of the repository itself.
_SITE = """import sys
sys.meta_path[:] = [f for f in sys.meta_path if type(f).__name__ != "ScikitBuildRedirectingFinder"]
"""


class DoesNotCompile(Exception):
    """The mutant is no program."""


class Tree:
    """A copy of the sources with its own build.

    Args:
        repository: its root.
        folder: of the copy and of the build.
    """

    def __init__(self, repository: Path, folder: Path) -> None:
        self.root = folder / "tree"
        self._build = folder / "build"
        self._site = folder / "site"
        for name in (*_FOLDERS, *_FILES):
            _refresh(repository / name, self.root / name)
        self._site.mkdir(parents=True, exist_ok=True)
        (self._site / "sitecustomize.py").write_text(_SITE)
        robots = self.root / "python/leadthrough/robots"
        if not robots.exists():
            robots.symlink_to("../../robots")
        self._build_all()
        self._links = {
            "leadthrough_tests": self._link_command("leadthrough_tests"),
            "_core": self._link_command("_core"),
        }
        self._core = next((self._build / "cpp/bind").glob("_core*.so"))
        self._use_core(self._core)

    def files(self, patterns: Sequence[str]) -> list[str]:
        """The tests, files of C++ or Python, that match patterns or lie in folders that do."""
        found = [path for pattern in patterns for path in sorted(self.root.glob(pattern))]
        tests = [
            test
            for path in found
            for test in (sorted(path.rglob("test_*.py")) if path.is_dir() else [path])
            if test.suffix in (".cpp", ".py")
        ]
        return list(dict.fromkeys(test.relative_to(self.root).as_posix() for test in tests))

    def dependents(self, path: str) -> int:
        """How many sources of C++ are compiled with a file."""
        return sum(str(self.root / path) in made_from for made_from in self._made_from.values())

    def passes(self, tests: Sequence[str], *, limit: float | None = None) -> str:
        """Runs tests until one fails.

        Args:
            tests: files of tests, from the root; those of C++ come first.
            limit: of processor time of each of the two, s.

        Returns:
            "" if all pass; else the first one that fails, or "hang".
        """
        return self._cpp_fails(self._build / "tests/cpp", tests, limit) or self._python_fails(
            tests, limit
        )

    def fails_on(self, path: str, text: str, tests: Sequence[str], *, limit: float) -> str:
        """The answer of `passes` with another text of one source.

        Args:
            path: of the source, from the root.
            text: its text for the time being.
            tests: as for `passes`.
            limit: as for `passes`.

        Raises:
            DoesNotCompile: if it is no program.
        """
        with self._changed(self.root / path, text):
            if path.endswith(".py"):
                return self._python_fails(tests, limit)
            folder = self._build / "mutant"
            objects = self._compile_dependents(path, folder)
            self._link("leadthrough_tests", objects, folder)
            if failed := self._cpp_fails(folder, tests, limit):
                return failed
            self._use_core(self._link("_core", objects, folder))
            try:
                return self._python_fails(tests, limit)
            finally:
                self._use_core(self._core)

    def _build_all(self) -> None:
        # With a folder as one source, each mutant would compile a whole folder.
        options = ("LEADTHROUGH_TESTS=ON", "LEADTHROUGH_PYTHON=ON", "LEADTHROUGH_UNITY=OFF")
        bind = [sys.executable, "-m", "pybind11", "--cmakedir"]
        places = (
            f"Python_EXECUTABLE={sys.executable}",
            f"pybind11_DIR={subprocess.check_output(bind, text=True).strip()}",
        )
        configure = ["cmake", "-S", self.root, "-B", self._build, "-G", "Ninja"]
        _run([*configure, *(f"-D{each}" for each in (*options, *places))])
        _run(["ninja", "-C", self._build, "-j1", "--quiet"])
        commands = json.loads((self._build / "compile_commands.json").read_text())
        self._compile = {
            each["command"].partition(" -o ")[2].split()[0]: each["command"] for each in commands
        }
        # Each object, and then the files that it was made from, indented.
        self._made_from: dict[str, set[str]] = {}
        for line in _run(["ninja", "-C", self._build, "-t", "deps"]).splitlines():
            if line and not line.startswith(" "):
                made_from = self._made_from.setdefault(line.split(":")[0], set())
            elif line:
                made_from.add(line.strip())

    def _link_command(self, target: str) -> str:
        steps = _run(["ninja", "-C", self._build, "-t", "commands", target]).splitlines()[-1]
        return next(step for step in steps.split(" && ") if " -o " in step)

    def _compile_dependents(self, path: str, folder: Path) -> dict[str, Path]:
        """New objects in place of all that are made from a source."""
        changed = str(self.root / path)
        objects = {}
        for number, (old, made_from) in enumerate(self._made_from.items()):
            if changed not in made_from or old not in self._compile:
                continue
            new = objects[old] = folder / f"{number}.o"
            new.parent.mkdir(exist_ok=True)
            command = shlex.split(self._compile[old].replace(f" -o {old} ", f" -o {new} "))
            # Faults need no fast code.
            command.append("-O1")
            done = subprocess.run(command, check=False, cwd=self._build, capture_output=True)
            if done.returncode:
                raise DoesNotCompile
        return objects

    def _link(self, target: str, objects: dict[str, Path], folder: Path) -> Path:
        """Links with new objects, which come before the libraries that have the old ones."""
        command = self._links[target]
        for old, new in objects.items():
            if f" {old} " in command:
                command = command.replace(f" {old} ", f" {new} ")
            elif "CMakeFiles/_core" not in old and "leadthrough_tests" not in old:
                command = command.replace(" -o ", f" {new} -o ")
        made = re.search(r" -o (\S+)", command)
        assert made
        result = folder / Path(made[1]).name
        _run(shlex.split(command.replace(f" -o {made[1]}", f" -o {result}")), self._build)
        return result

    def _use_core(self, core: Path) -> None:
        place = self.root / "python/leadthrough" / self._core.name
        place.unlink(missing_ok=True)
        place.symlink_to(core)

    def _cpp_fails(self, folder: Path, tests: Sequence[str], limit: float | None) -> str:
        texts = [(self.root / test).read_text() for test in tests if test.endswith(".cpp")]
        suites = sorted({name for text in texts for name in _TEST.findall(text)})
        if not suites:
            return ""
        names = ":".join(f"{suite}.*:*/{suite}.*" for suite in suites)
        program = [folder / "leadthrough_tests", f"--gtest_filter={names}", "--gtest_fail_fast"]
        return self._failure(program, limit)

    def _python_fails(self, tests: Sequence[str], limit: float | None) -> str:
        files = [test for test in tests if test.endswith(".py")]
        return self._failure(
            [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *files], limit
        )

    def _failure(self, program: Sequence[str | Path], limit: float | None) -> str:
        places = [self._site, self.root / "python"]
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(map(str, places))}
        if limit is not None:  # compiled modules of a mutant must not stay
            environment["PYTHONDONTWRITEBYTECODE"] = "1"

        def bounded() -> None:
            resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
            if limit is not None:
                resource.setrlimit(resource.RLIMIT_CPU, (int(limit), int(limit) + 1))

        try:
            done = subprocess.run(
                program, check=False, cwd=self.root, env=environment, preexec_fn=bounded, text=True,
                capture_output=True, timeout=limit and _PATIENCE * limit,
            )  # fmt: skip
        except subprocess.TimeoutExpired:
            return "hang"
        if done.returncode == 0:
            return ""
        told = _FAILED.search(done.stdout)
        if told is None and limit is None:
            raise RuntimeError(done.stdout[-3000:] + done.stderr[-3000:])
        return told[1] if told else "hang" if done.returncode in (-24, -9) else "crash"

    @contextmanager
    def _changed(self, path: Path, text: str):
        """A file with another text; afterwards as it was, to the time of its last change."""
        before, times = path.read_bytes(), path.stat()
        try:
            path.write_text(text, encoding="utf-8")
            yield
        finally:
            path.write_bytes(before)
            os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))


def _refresh(source: Path, target: Path) -> None:
    """Copies what has changed."""
    if source.is_file():
        if not target.is_file() or target.read_bytes() != source.read_bytes():
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source, target)
        return
    for path in sorted(source.rglob("*")):
        if path.is_file() and not path.is_symlink() and "__pycache__" not in path.parts:
            _refresh(path, target / path.relative_to(source))


def _run(command: Sequence[str | Path], folder: Path | None = None) -> str:
    """Output of a command; its errors are printed if it fails."""
    done = subprocess.run(command, cwd=folder, stdout=subprocess.PIPE, text=True, check=True)
    return done.stdout

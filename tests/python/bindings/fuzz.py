"""Calls of the compiled core with damaged arguments: each answers, raises or can be stopped.

Real calls are recorded while tests and scripts run. Of each call drawn, some arguments change their
type, shape, size or numbers. It then runs in a process forked from this one, and a signal stops it
after a second of processor time. A call that ends the process, or does not end, is a fault: it is
printed, and the exit code is 1.

    python tests/python/bindings/fuzz.py --count 50000 --seed 3 python/demos/02_*.py

`./do sanitize` runs it with AddressSanitizer.
"""

from __future__ import annotations

import argparse
import collections
import contextlib
import importlib
import os
import resource
import runpy
import signal
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

TESTS = Path(__file__).parents[1]
sys.path.insert(0, str(TESTS))
if "LEADTHROUGH_CORE" in os.environ:
    import sanitized_core  # noqa: F401

core = importlib.import_module("leadthrough._core")

FEW = 6  # recorded calls of each function
TOGETHER = 25  # calls in a child; the next one goes on after a call that ends it
OUTCOMES = {"a": "answered", "r": "refused", "s": "stopped"}
SECONDS, MAX_SECONDS = 1, 5  # of processor time: to be stopped, and to have ended
NUMBERS = (np.nan, np.inf, -np.inf, 0.0, -0.0, -1.0, 1e-300, 1e-30, 1e30, 1e300, 0.5, 1e9)
INTEGERS = (-1, 0, 1, 2, 3, 1000, 2**31 - 1, 2**31, -(2**31), 2**53, 2**63 - 1, -(2**63), 2**64)
TYPES = ("float32", "complex128", ">f8", "int64", "bool", "object", "U3")
FOREIGN = (None, "x", b"x", 1, 1.5, [], {}, (), object(), np.zeros(0), np.zeros((2, 2)), np.int8(1))
# Refusals of arguments, and of memory that no machine has.
ANSWERS = (TypeError, ValueError, IndexError, OverflowError, MemoryError, RuntimeError)
OUT_OF_MEMORY = ("allocation-size-too-big", "out-of-memory", "allocator is out of memory")


class StoppedError(BaseException):
    """Raised in a call that has used up its time."""


@dataclass(frozen=True)
class Call:
    """A function of the core with the arguments of a call."""

    name: str
    function: Callable[..., Any]
    arguments: list[Any]
    options: dict[str, Any]


def members(module: ModuleType) -> Iterator[tuple[str, Any, str, Any]]:
    """Functions, constructors and methods of the core: full name, owner, own name and member."""
    for name, thing in list(vars(module).items()):
        if isinstance(thing, type):
            for key, member in list(vars(thing).items()):
                made = key == "__init__" and type(member) is not type(object.__init__)
                if callable(member) and (made or not key.startswith("_")):
                    yield f"{name}.{key}", thing, key, member
        elif callable(thing) and not name.startswith("_"):
            yield name, module, name, thing


class Recorder:
    """Records calls of the core while its members are replaced."""

    def __init__(self) -> None:
        self.calls: dict[str, list[Call]] = collections.defaultdict(list)
        self.objects: list[Any] = []

    @contextlib.contextmanager
    def recording(self) -> Iterator[None]:
        before = list(members(core))
        for name, owner, key, member in before:
            made = owner if key == "__init__" else None
            setattr(owner, key, self._recording(name, member, made))
        try:
            yield
        finally:
            for _, owner, key, member in before:
                setattr(owner, key, member)

    def _recording(
        self, name: str, function: Callable[..., Any], made: type | None
    ) -> Callable[..., Any]:
        def recorded(*arguments: Any, **options: Any) -> Any:
            result = function(*arguments, **options)
            noted = self.calls[name]
            if len(noted) < FEW:
                if made is None:
                    noted.append(Call(name, function, list(arguments), options))
                else:
                    noted.append(Call(name, made, list(arguments[1:]), options))
                self.objects += [
                    each for each in arguments if type(each).__module__ == core.__name__
                ]
            return result

        recorded.__name__ = name.rpartition(".")[2]
        return recorded


def damaged_array(value: np.ndarray, rng: np.random.Generator) -> Any:
    """An array of another type, shape or layout, or with other numbers."""
    kind = rng.integers(7)
    if kind <= 1 and value.size:
        changed = value.copy()
        count = 1 if kind == 0 else value.size
        with np.errstate(all="ignore"):
            numbers = rng.choice(NUMBERS, count)
            changed.flat[rng.integers(value.size, size=count)] = (
                np.nan_to_num(numbers).astype(value.dtype) if value.dtype.kind in "iub" else numbers
            )
        return changed
    if kind == 2:
        with np.errstate(all="ignore"), contextlib.suppress(TypeError, ValueError):
            return value.astype(rng.choice(TYPES))
    if kind == 3:
        return np.asfortranarray(value) if value.ndim > 1 else np.repeat(value, 2)[::2]
    if kind == 4:
        return value[..., None] if rng.random() < 0.5 else value.ravel()
    if kind == 5 and value.ndim and value.size:
        return np.repeat(value, rng.integers(0, 4), axis=rng.integers(value.ndim))
    return np.resize(value, rng.integers(0, 5, value.ndim))


def damaged_text(value: str, rng: np.random.Generator) -> str:
    return (value[: rng.integers(len(value) + 1)], "\0", "\udc80", "é" * 9)[rng.integers(4)]


def damaged_list(value: Any, rng: np.random.Generator, objects: Sequence[Any]) -> list[Any]:
    """The list with some items damaged, left out or twice."""
    kept = [each for each in value for _ in range(rng.choice([0, 1, 1, 1, 1, 2]))]
    return [damaged(each, rng, objects) if rng.random() < 0.4 else each for each in kept]


def other_object(value: Any, rng: np.random.Generator, objects: Sequence[Any]) -> Any:
    """Another object of the class, or one without __init__."""
    alike = [each for each in objects if type(each) is type(value)]
    if type(value).__module__ == core.__name__ and rng.random() < 0.2:
        return type(value).__new__(type(value))
    return alike[rng.integers(len(alike))] if alike else value


def damaged(value: Any, rng: np.random.Generator, objects: Sequence[Any]) -> Any:
    """Another value, mostly of the same type."""
    if rng.random() < 0.15:
        return FOREIGN[rng.integers(len(FOREIGN))]
    kinds: dict[type, Callable[[], Any]] = {
        np.ndarray: lambda: damaged_array(value, rng),
        bool: lambda: not value,
        int: lambda: INTEGERS[rng.integers(len(INTEGERS))],
        float: lambda: float(rng.choice(NUMBERS)),
        str: lambda: damaged_text(value, rng),
        list: lambda: damaged_list(value, rng, objects),
        tuple: lambda: tuple(damaged_list(value, rng, objects)),
    }
    return kinds.get(type(value), lambda: other_object(value, rng, objects))()


def damaged_call(calls: Sequence[Call], rng: np.random.Generator, objects: Sequence[Any]) -> Call:
    """One of the calls with one or several of its arguments damaged."""
    call = calls[rng.integers(len(calls))]
    arguments, options = list(call.arguments), dict(call.options)
    places = [*range(len(arguments)), *options]
    for n in rng.permutation(len(places))[: 1 + rng.poisson(0.6)]:
        place = places[n]
        inside = arguments if isinstance(place, int) else options
        inside[place] = damaged(inside[place], rng, objects)  # type: ignore[index]
    return Call(call.name, call.function, arguments, options)


def read(result: Any) -> None:
    """Reads all numbers of a result: it may refer to memory that is gone."""
    if isinstance(result, np.ndarray):
        result.tobytes()
    elif isinstance(result, list | tuple):
        for each in result:
            read(each)
    elif type(result).__module__ == core.__name__:
        for name, member in vars(type(result)).items():
            if isinstance(member, property):
                read(getattr(result, name))


def stop(*_: object) -> None:
    raise StoppedError


def run(call: Call) -> bytes:
    """The outcome of a call that ends no process."""
    used = sum(os.times()[:2])
    resource.setrlimit(resource.RLIMIT_CPU, (int(used) + MAX_SECONDS, resource.RLIM_INFINITY))
    signal.alarm(100 * MAX_SECONDS)  # for what waits for ever
    signal.setitimer(signal.ITIMER_PROF, SECONDS)
    try:
        with np.errstate(all="ignore"):
            read(call.function(*call.arguments, **call.options))
    except ANSWERS:
        return b"r"
    except StoppedError:
        return b"s"
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
    return b"a"


def run_all(calls: Sequence[Call], written: int) -> None:
    signal.signal(signal.SIGPROF, stop)
    for call in calls:
        os.write(written, run(call))


def first_outcomes(calls: Sequence[Call]) -> tuple[list[str], str]:
    """Outcomes of the calls in a child, up to one that ends it, and what it wrote."""
    with tempfile.TemporaryFile() as codes, tempfile.TemporaryFile() as errors:
        child = os.fork()
        if child == 0:
            os.dup2(errors.fileno(), 2)
            try:
                run_all(calls, codes.fileno())
            except BaseException as error:
                print(repr(error), file=sys.stderr, flush=True)
                os._exit(1)
            os._exit(0)
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        codes.seek(0)
        errors.seek(0)
        text = errors.read().decode(errors="replace")
        seen = [OUTCOMES[code] for code in codes.read().decode()]
    if status == 0 and len(seen) == len(calls):
        return seen, ""
    if any(each in text for each in OUT_OF_MEMORY):
        return [*seen, "refused"], ""
    return [*seen, "hung" if -status in (signal.SIGXCPU, signal.SIGALRM) else "crashed"], text


def recorded(scripts: Sequence[str] = ()) -> Recorder:
    """Calls of the core in the tests of public calls, and in scripts."""
    recorder = Recorder()
    with recorder.recording():
        for name, test in vars(importlib.import_module("bindings.test_public_calls")).items():
            if name.startswith("test_"):
                test()
        for script in scripts:
            with contextlib.redirect_stdout(None), tempfile.TemporaryDirectory() as folder:
                sys.argv = [script, folder]
                runpy.run_path(script, run_name="__main__")
    return recorder


def outcomes(recorder: Recorder, count: int, seed: int) -> Iterator[tuple[Call, str, str]]:
    names = sorted(name for name, calls in recorder.calls.items() if calls)
    waiting: list[Call] = []
    for n in range(count):
        rng = np.random.default_rng([seed, n])
        calls = recorder.calls[names[rng.integers(len(names))]]
        waiting.append(damaged_call(calls, rng, recorder.objects))
        while len(waiting) == TOGETHER or (waiting and n + 1 == count):
            seen, text = first_outcomes(waiting)
            for call, how in zip(waiting, seen, strict=False):
                yield call, how, text
            waiting = waiting[len(seen) :]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--count", type=int, default=2000, help="Calls.")
    parser.add_argument("--seed", type=int, default=1, help="Seed of the random number generator.")
    parser.add_argument("scripts", nargs="*", help="Scripts whose calls are recorded, too.")
    options = parser.parse_args()
    recorder = recorded(options.scripts)
    seen: collections.Counter[str] = collections.Counter()
    for n, (call, how, text) in enumerate(outcomes(recorder, options.count, options.seed)):
        seen[how] += 1
        if how in ("hung", "crashed"):
            print(
                f"{n}: {call.name} {how}: {call.arguments!r} {call.options!r}\n{text}", flush=True
            )
    print(f"{len(recorder.calls)} functions: " + ", ".join(f"{seen[how]} {how}" for how in seen))
    return bool(seen["hung"] or seen["crashed"])


if __name__ == "__main__":
    sys.exit(main())

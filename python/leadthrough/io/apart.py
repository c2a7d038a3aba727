"""Readers of other libraries, at work in a process of their own.

HDF5, Arrow, the decompressors of ROS bags and the importers of meshes inflate whatever a file says,
and damage can make them crash or never end. In a process whose memory and time are bounded that
costs an error and not the program. The process stays for the next file; it imports the library
once. `leadthrough.io.apart_worker` is what runs in it.
"""

from __future__ import annotations

import atexit
import contextlib
import json
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Sequence
from dataclasses import asdict
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from leadthrough.errors import InvalidInput, MissingDependency
from leadthrough.events import Event
from leadthrough.io import wire
from leadthrough.io.apart_worker import MOST_SECONDS
from leadthrough.io.request import Request
from leadthrough.io.table import ArrayTable

# The worker bounds its processor time; this is for what waits without an end, on a busy machine.
_LONGEST_WAIT = 120.0  # s
_CODE = """
import json, sys
sys.path[:] = json.loads(sys.argv[1])
from leadthrough.io.apart_worker import serve
serve()
"""


def tables(
    read: Callable[..., Sequence[ArrayTable]], path: Path, request: Request | None = None
) -> list[ArrayTable]:
    """The tables that a reader finds in a file."""
    found, arrays = _ask(read, path, None if request is None else asdict(request))
    rest = iter(arrays)
    return [
        ArrayTable(
            {name: next(rest) for name in each["names"]},
            roles={role: tuple(names) for role, names in each["roles"].items()},
            label=each["label"],
            rate=each["rate"],
            quaternions=each["quaternions"],
            angles=each["angles"],
            extents={name: (least, most) for name, (least, most) in each["extents"].items()},
            events=tuple(Event(time, name) for time, name in each["events"]),
        )
        for each in found
    ]


def plain(read: Callable[[Path], Any], path: Path) -> Any:
    """The plain values that a reader finds in a file; arguments and errors as of `tables`."""
    return _ask(read, path, None)[0]


def mesh(
    read: Callable[[Path], tuple[NDArray[np.float64], NDArray[np.int64]]], path: Path
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """The vertices and triangles that a reader finds; arguments and errors as of `tables`."""
    vertices, faces = _ask(read, path, None)[1]
    return vertices, faces


def require(module: str, *, extra: str) -> None:
    """Refuses to go on without a library, which is not loaded here."""
    package = module.partition(".")[0]
    if any(name in sys.modules and sys.modules[name] is None for name in (package, module)):
        raise MissingDependency(package, extra=extra)
    if package not in sys.modules and find_spec(package) is None:
        raise MissingDependency(package, extra=extra)


class _Worker:
    """The process, and the two pipes to talk to it."""

    def __init__(self) -> None:
        self.owner = os.getpid()
        here = str(Path(__file__).parents[2])
        paths = [here, *(path for path in sys.path if path and path != here)]
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-c", _CODE, json.dumps(paths)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env={**os.environ, "ARROW_DEFAULT_MEMORY_POOL": "system", "OMP_NUM_THREADS": "1"},
            start_new_session=True,  # Ctrl-C is for the program, which then ends this process
        )
        self._receive()

    def ask(self, question: dict[str, Any]) -> tuple[Any, list[NDArray[Any]]]:
        """The answer to a question; EOFError if the process ends before it."""
        assert self._process.stdin is not None
        try:
            wire.send(self._process.stdin, question)
        except BrokenPipeError:
            raise EOFError from None
        return self._receive()

    def end(self) -> int:
        """Ends the process at once; returns how it ended."""
        self._process.kill()
        for pipe in (self._process.stdin, self._process.stdout):
            assert pipe is not None
            with contextlib.suppress(BrokenPipeError):
                pipe.close()
        return self._process.wait()

    def _receive(self) -> tuple[Any, list[NDArray[Any]]]:
        assert self._process.stdout is not None
        late = threading.Timer(_LONGEST_WAIT, self._process.kill)
        late.start()
        try:
            return wire.receive(self._process.stdout)
        finally:
            late.cancel()


_lock = threading.Lock()
_worker: _Worker | None = None


def _ask(
    read: Callable[..., Any], path: Path, request: dict[str, Any] | None
) -> tuple[Any, list[NDArray[Any]]]:
    question = {
        "module": read.__module__,
        "function": read.__name__,
        "path": str(path.absolute()),
        "request": request,
    }
    with _lock:
        answer, arrays = _exchange(question)
    if "error" in answer:
        raise _raised(answer["error"])
    return answer["found"], arrays


def _exchange(question: dict[str, Any]) -> tuple[Any, list[NDArray[Any]]]:
    global _worker  # noqa: PLW0603  (one process for all readings)
    if _worker is None or _worker.owner != os.getpid():
        _worker = _Worker()
    try:
        return _worker.ask(question)
    except EOFError:
        status = _worker.end()
        _worker = None
        raise InvalidInput(
            f"expected a file that can be read within {MOST_SECONDS} s; its reader took longer "
            f"or crashed on it (status {status})"
        ) from None
    except BaseException:
        _worker.end()  # the answer would be taken for that of the next question
        _worker = None
        raise


def _raised(error: dict[str, Any]) -> Exception:
    match error["kind"]:
        case "MissingDependency":
            return MissingDependency(error["package"], extra=error["extra"])
        case "OSError":
            return OSError(error["number"], error["message"])
        case _:
            return InvalidInput(error["message"])


@atexit.register
def end() -> None:
    """Ends the process, which the next reading starts anew."""
    global _worker  # noqa: PLW0603  (one process for all readings)
    if _worker is not None and _worker.owner == os.getpid():
        _worker.end()
    _worker = None


def _forget() -> None:
    """Leaves the process to the one that started it; for a fork of that one."""
    global _lock  # noqa: PLW0603  (another thread may have held it)
    _lock = threading.Lock()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget)

"""Runs the readers of other libraries in a process of their own.

HDF5, Arrow, the decompressors of ROS bags and the importers of meshes inflate whatever a file says,
and damage can make them crash or never end. In a process of bounded memory and time that costs an
error and not the program. The process runs `serve` and stays for the next file, so that it imports
the library once. Values and arrays pass through pipes, never with pickle.
"""

from __future__ import annotations

import atexit
import json
import math
import os
import struct
import subprocess
import sys
import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import InvalidInput, LeadthroughError, MissingDependency
from leadthrough.io.table import ArrayTable, Request
from leadthrough.motion import Event

# The worker bounds its processor time; this is for what waits without an end, on a busy machine.
_MAX_WAIT = 120.0  # s
_CODE = """
import json, sys
sys.path[:] = json.loads(sys.argv[1])
from leadthrough.io.reader_process import serve
serve()
"""
_PLAIN = ("label", "rate", "quaternions", "angles")  # attributes of a table
_LENGTH = struct.Struct("<Q")
MAX_MEMORY = 7 * 2**27  # bytes, beyond what the interpreter itself takes
MAX_SECONDS = 20  # of processor time, for one file


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
            **{name: each[name] for name in _PLAIN},
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
            send(self._process.stdin, question)
        except BrokenPipeError:
            raise EOFError from None
        return self._receive()

    def end(self) -> int:
        """Ends the process at once; returns how it ended."""
        self._process.kill()
        for pipe in (self._process.stdin, self._process.stdout):
            assert pipe is not None
            with suppress(BrokenPipeError):
                pipe.close()
        return self._process.wait()

    def _receive(self) -> tuple[Any, list[NDArray[Any]]]:
        assert self._process.stdout is not None
        late = threading.Timer(_MAX_WAIT, self._process.kill)
        late.start()
        try:
            return receive(self._process.stdout)
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
            f"expected a file that can be read within {MAX_SECONDS} s; its reader took longer "
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


def send(stream: IO[bytes], head: object, arrays: Sequence[NDArray[Any]] = ()) -> None:
    """Writes plain values, as JSON knows them, and arrays of numbers."""
    shapes = [[array.dtype.str, array.shape] for array in arrays]
    content = json.dumps([head, shapes]).encode()
    stream.write(_LENGTH.pack(len(content)) + content)
    for array in arrays:
        stream.write(_bytes(np.ascontiguousarray(array)))
    stream.flush()


def receive(stream: IO[bytes]) -> tuple[Any, list[NDArray[Any]]]:
    """The values and arrays of one `send`."""
    (length,) = _LENGTH.unpack(_exactly(stream, _LENGTH.size))
    head, shapes = json.loads(_exactly(stream, length))
    arrays = []
    for kind, shape in shapes:
        array = np.empty(shape, np.dtype(kind))
        # Buffered binary files have it, though their common type does not say so.
        if array.nbytes and stream.readinto(_bytes(array)) != array.nbytes:  # type: ignore[attr-defined]
            raise EOFError
        arrays.append(array)
    return head, arrays


def _bytes(array: NDArray[Any]) -> memoryview:
    return array.reshape(-1).view(np.uint8).data


def _exactly(stream: IO[bytes], count: int) -> bytes:
    content = stream.read(count)
    if len(content) != count:
        raise EOFError
    return content


def serve() -> None:
    """Answers questions from standard input on standard output, until that is closed."""
    questions = sys.stdin.buffer
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # libraries' prints must not get among the answers
    bound_memory()
    send(answers, {})
    while True:
        try:
            question, _ = receive(questions)
        except EOFError:
            return
        bound_time()
        found, arrays = answered(question)
        send(answers, found, arrays)
        del found, arrays


def answered(question: Mapping[str, Any]) -> tuple[dict[str, Any], list[NDArray[Any]]]:
    """A reader's result or error, as values and arrays for `send`."""
    try:
        read = getattr(import_module(question["module"]), question["function"])
        path, request = Path(question["path"]), question["request"]
        found = read(path) if request is None else read(path, _restored(request))
        return _packed(found)
    except MissingDependency as error:
        kind: dict[str, Any] = {"package": error.package, "extra": error.extra}
        return {"error": {"kind": "MissingDependency", **kind}}, []
    except LeadthroughError as error:
        return {"error": {"kind": "InvalidInput", "message": str(error)}}, []
    except MemoryError:
        message = f"expected a file that takes at most {MAX_MEMORY:,} bytes of memory, got a larger"
        return {"error": {"kind": "InvalidInput", "message": message}}, []
    except OSError as error:
        kind = {"number": error.errno, "message": error.strerror or str(error)}
        return {"error": {"kind": "OSError", **kind}}, []


def bound_memory() -> None:
    """Lets the process take no more than `MAX_MEMORY` beyond what it has; on Linux only."""
    with suppress(ImportError, OSError, ValueError, IndexError):
        import resource

        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[5])
        bound = pages * resource.getpagesize() + MAX_MEMORY
        resource.setrlimit(resource.RLIMIT_DATA, (bound, bound))


def bound_time() -> None:
    """Lets the system end the process after `MAX_SECONDS` from now on; not on Windows."""
    with suppress(ImportError, OSError, ValueError):
        import resource

        used = resource.getrusage(resource.RUSAGE_SELF)
        bound = math.ceil(used.ru_utime + used.ru_stime) + MAX_SECONDS
        resource.setrlimit(resource.RLIMIT_CPU, (bound, resource.getrlimit(resource.RLIMIT_CPU)[1]))


def _restored(request: Mapping[str, Any]) -> Request:
    columns = {role: tuple(names) for role, names in request["columns"].items()}
    pairs = {name: request[name] and tuple(request[name]) for name in ("frames", "part")}
    return Request(**{**request, "columns": columns, **pairs})


def _packed(found: Any) -> tuple[dict[str, Any], list[NDArray[Any]]]:
    if isinstance(found, tuple):
        return {"found": None}, [np.asarray(each) for each in found]
    if not isinstance(found, list) or not all(isinstance(each, ArrayTable) for each in found):
        return {"found": json.loads(json.dumps(found))}, []
    arrays = [np.asarray(array) for table in found for array in table.arrays.values()]
    heads = [
        {
            "names": list(table.arrays),
            "roles": {role: list(names) for role, names in table.roles.items()},
            **{name: getattr(table, name) for name in _PLAIN},
            "extents": dict(table.extents),
            "events": [[event.time, event.name] for event in table.events],
        }
        for table in found
    ]
    return {"found": heads}, arrays

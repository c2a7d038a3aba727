"""What runs in the process of `leadthrough.io.apart`: one reader after the other, within bounds."""

from __future__ import annotations

import json
import math
import os
import sys
from collections.abc import Mapping
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from leadthrough.errors import LeadthroughError, MissingDependency
from leadthrough.io import wire
from leadthrough.io.request import Request
from leadthrough.io.table import ArrayTable

MOST_MEMORY = 7 * 2**27  # bytes, beyond what the interpreter itself takes
MOST_SECONDS = 20  # of processor time, for one file


def serve() -> None:
    """Answers questions from standard input on standard output, until that is closed."""
    questions = sys.stdin.buffer
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what libraries print must not get among the answers
    bound_memory()
    wire.send(answers, {})
    while True:
        try:
            question, _ = wire.receive(questions)
        except EOFError:
            return
        bound_time()
        found, arrays = answered(question)
        wire.send(answers, found, arrays)
        del found, arrays


def answered(question: Mapping[str, Any]) -> tuple[dict[str, Any], list[NDArray[Any]]]:
    """What a reader finds, or its error, as values and arrays for `wire.send`."""
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
        message = (
            f"expected a file that takes at most {MOST_MEMORY:,} bytes of memory, got a larger"
        )
        return {"error": {"kind": "InvalidInput", "message": message}}, []
    except OSError as error:
        kind = {"number": error.errno, "message": error.strerror or str(error)}
        return {"error": {"kind": "OSError", **kind}}, []


def bound_memory() -> None:
    """Lets the process take no more than `MOST_MEMORY` beyond what it has; on Linux only."""
    with suppress(ImportError, OSError, ValueError, IndexError):
        import resource

        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[5])
        bound = pages * resource.getpagesize() + MOST_MEMORY
        resource.setrlimit(resource.RLIMIT_DATA, (bound, bound))


def bound_time() -> None:
    """Lets the system end the process after `MOST_SECONDS` from now on; not on Windows."""
    with suppress(ImportError, OSError, ValueError):
        import resource

        used = resource.getrusage(resource.RUSAGE_SELF)
        bound = math.ceil(used.ru_utime + used.ru_stime) + MOST_SECONDS
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
            "label": table.label,
            "rate": table.rate,
            "quaternions": table.quaternions,
            "angles": table.angles,
            "extents": dict(table.extents),
            "events": [[event.time, event.name] for event in table.events],
        }
        for table in found
    ]
    return {"found": heads}, arrays

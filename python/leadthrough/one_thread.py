"""The linear algebra of NumPy and SciPy on one thread.

With several, sums are taken in another order and the last bits change; and the matrices of a fit
are small, so that threads mostly wait for one another: on a busy machine for tens of times as long
as one thread computes.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from threadpoolctl import ThreadpoolController

# The setting is one of the process: of several Python threads one is inside, the others wait.
_INSIDE = threading.RLock()


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """A context, or decorator of a function, in which linear algebra uses one thread."""
    with _INSIDE, _controller().limit(limits=1, user_api="blas"):
        yield


@cache
def _controller() -> ThreadpoolController:
    # It knows the libraries that are loaded when it is made; SciPy brings its own.
    import scipy.linalg  # noqa: F401, PLC0415
    from threadpoolctl import ThreadpoolController  # noqa: PLC0415

    return ThreadpoolController()

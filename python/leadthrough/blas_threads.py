"""The linear algebra of NumPy and SciPy on one thread.

With several, sums are taken in another order and the last bits change; and the matrices of a fit
are small, so that threads mostly wait for one another: on a busy machine for tens of times as long
as one thread computes.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import cache, wraps
from typing import TYPE_CHECKING, ParamSpec, TypeVar

if TYPE_CHECKING:
    from threadpoolctl import ThreadpoolController

_Arguments = ParamSpec("_Arguments")
_Result = TypeVar("_Result")
# The setting is one of the process: of several Python threads one is inside, the others wait.
_INSIDE = threading.RLock()


def one_blas_thread(function: Callable[_Arguments, _Result]) -> Callable[_Arguments, _Result]:
    """The same function, inside of which linear algebra uses one thread."""

    @wraps(function)
    def limited(*args: _Arguments.args, **kwargs: _Arguments.kwargs) -> _Result:
        with _INSIDE, _controller().limit(limits=1, user_api="blas"):
            return function(*args, **kwargs)

    return limited


@cache
def _controller() -> ThreadpoolController:
    # It knows the libraries that are loaded when it is made; SciPy brings its own.
    import scipy.linalg  # noqa: F401, PLC0415
    from threadpoolctl import ThreadpoolController  # noqa: PLC0415

    return ThreadpoolController()

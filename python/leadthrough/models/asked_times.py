"""Times at which a distribution is asked for."""

from __future__ import annotations

from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput

# Covariances of more times would take gigabytes.
_MOST_TIMES = 1_000_000


def asked_times(times: ArrayLike, name: str, *, at_least: int = 1) -> Float64Array:
    """The times (n,), s, if they are neither too few nor too many."""
    found = check.array(times, name, shape=("n",))
    if not at_least <= len(found) <= _MOST_TIMES:
        raise InvalidInput(
            f"{name}: expected {at_least} to {_MOST_TIMES:,} times, got {len(found):,}"
        )
    return found

"""The nearest motion inside the limits for samples that exceed them.

Positions are brought inside their limits. Where the samples jump, they are cut into pieces; a
piece that is too fast is run more slowly along the same path; and bridges lead onto each piece, the
first one on time where that is possible. Pieces too short to be joined smoothly are outliers, and
left out.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from leadthrough import _core
from leadthrough.check import Float64Array
from leadthrough.guard.joining import LANDING, beyond_reach, joined_at_start, joined_on_time
from leadthrough.guard.rules import HISTORY, Rules

_JUMP = 3.0  # times its neighbours a step is longer that is a jump
_SLOWEST = 20  # times as long a piece may take


@dataclass(frozen=True, eq=False)
class Changed:
    """Rows inside the limits."""

    rows: Float64Array  # (n, joints)
    places: Float64Array  # which sample of the chunk each is, with fractions in between, (n,)
    complete: bool  # whether they lead to the end of the chunk


def changed(rules: Rules, history: Float64Array, samples: Float64Array) -> Changed:
    """The samples, brought inside the limits."""
    inside = np.clip(samples, rules.joints.lower, rules.joints.upper)
    rows, places = [history], [np.arange(-HISTORY, 0, dtype=np.float64)]
    complete = True
    for first, end in pairwise(_pieces(inside, rules.joints.velocity * rules.period)):
        piece = inside[first:end]
        if len(piece) < LANDING and end < len(inside):
            continue
        last = rows[-1][-HISTORY:]
        if beyond_reach(rules, last[-1], piece):
            complete = False
            break
        resting = max(0, LANDING - len(piece))
        path = np.concatenate([piece, np.repeat(piece[-1:], resting, axis=0)])
        run = _core.slowed(rules.limits, path, _SLOWEST * len(path))
        if run is None:
            complete = False
            break
        target, at = run
        joined = None if first else joined_on_time(rules, last, target)
        joined = joined or joined_at_start(rules, last, target)
        if joined is None:
            complete = False
            break
        bridge, skipped = joined
        at = np.minimum(first + at, end - 1.0)[skipped:]
        since = float(places[-1][-1])
        between = since + (at[0] - since) * np.arange(1, len(bridge) + 1) / (len(bridge) + 1)
        rows += [bridge, target[skipped:]]
        places += [between, at]
    return Changed(np.concatenate(rows)[HISTORY:], np.concatenate(places)[HISTORY:], complete)


def _pieces(samples: Float64Array, step: Float64Array) -> list[int]:
    """Where pieces without jumps begin, and the end of the last one."""
    steps = np.abs(np.diff(samples, axis=0))
    padded = np.pad(steps, ((1, 1), (0, 0)))
    beside = np.maximum(padded[:-2], padded[2:])
    jumps = ((steps > step) & (steps > _JUMP * beside)).any(axis=1)
    return [0, *(np.flatnonzero(jumps) + 1).tolist(), len(samples)]

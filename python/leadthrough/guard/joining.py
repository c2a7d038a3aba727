"""Ways from the present command onto samples to go on with."""

from __future__ import annotations

import numpy as np

from leadthrough import _core
from leadthrough.check import Float64Array
from leadthrough.guard.rules import HISTORY, Rules

LANDING = 3  # samples that a way has to fit to
_LONGEST = 10.0  # s
# A way that takes this fraction of the samples at most keeps to their clock.
_ON_TIME = 0.25

# Rows of the way, and how many samples it passes.
Joined = tuple[Float64Array, int]


def beyond_reach(rules: Rules, last: Float64Array, target: Float64Array) -> bool:
    """Whether no way leads onto a target, however slowly that is run: a joint is too far away."""
    periods = 2 * _most_periods(rules) + len(target)
    return bool((np.abs(target[0] - last) > periods * rules.period * rules.joints.velocity).any())


def joined_on_time(rules: Rules, history: Float64Array, target: Float64Array) -> Joined | None:
    """The shortest way onto a sample when that is due, if the first is due a period from now."""
    soon = max(1, int(_ON_TIME * len(target)))
    return _core.bridge_on_time(rules.limits, history, target, soon)


def joined_at_start(rules: Rules, history: Float64Array, target: Float64Array) -> Joined | None:
    """The shortest way onto the first sample; where none is short, by way of a rest."""
    longest = _most_periods(rules)
    found = _core.bridge_to_start(rules.limits, history, target, longest)
    if found is not None:
        return found
    way = rules.braked(history, target[:0])
    if way is None:
        return None
    rest = (way.rows if len(way.rows) else history)[-1:]
    pause = np.repeat(rest, HISTORY, axis=0)  # as long as differences reach
    found = _core.bridge_to_start(rules.limits, pause, target, longest)
    if found is None:
        return None
    return np.concatenate([way.rows, pause, found[0]]), found[1]


def _most_periods(rules: Rules) -> int:
    return max(1, round(_LONGEST / rules.period))

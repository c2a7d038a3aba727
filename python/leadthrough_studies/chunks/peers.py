"""What runs chunks elsewhere: a clamp of the velocity, a moving average, temporal ensembling.

All know when a chunk was observed and leave out the actions that were due before, and all bound
the step from one command to the next by the limits of velocity, as `max_relative_target` of LeRobot
does. Joints are kept inside their limits.

Source: Zhao et al. 2023, "Learning Fine-Grained Bimanual Manipulation with Low-Cost Hardware",
Algorithm 2, for temporal ensembling; huggingface/lerobot 3893 for the moving average.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from leadthrough.arm import JointLimits
from leadthrough.check import Float64Array
from leadthrough_studies.chunks.streams import LOOP, POLICY, Arrival, Stream

_TIME_CONSTANT = 0.1  # s, of the moving average
_OLDER = 0.01  # by which the logarithm of a chunk's weight falls from the oldest one on
_KEPT = 8  # chunks that are averaged at most

# From the chunks that have come, the time and the last command to the target.
Target = Callable[[list[Arrival], float, Float64Array], Float64Array]


def held(known: list[Arrival], now: float, last: Float64Array) -> Float64Array:
    """The newest chunk's action that is due, held until the next one."""
    del last
    newest = max(known, key=lambda each: each.observed)
    row = int((now - newest.observed) * POLICY + 1e-9)
    return np.asarray(newest.actions[min(row, len(newest.actions) - 1)])


def averaged(known: list[Arrival], now: float, last: Float64Array) -> Float64Array:
    """A moving average of the actions that are due."""
    return last + (held(known, now, last) - last) / (_TIME_CONSTANT * LOOP)


def ensembled(known: list[Arrival], now: float, last: Float64Array) -> Float64Array:
    """The weighted mean of all chunks' predictions for now, linear between actions."""
    rows = [(now - each.observed) * POLICY for each in known]
    valid = [each for each, row in zip(known, rows, strict=True) if row <= len(each.actions) - 1]
    if not valid:
        return held(known, now, last)
    valid = sorted(valid, key=lambda each: each.observed)[-_KEPT:]
    weights = np.exp(-_OLDER * np.arange(len(valid)))
    return np.average([_between(each, now) for each in valid], axis=0, weights=weights)


PEERS: dict[str, Target] = {"clamp": held, "moving average": averaged, "ensembling": ensembled}


def followed(target: Target, limits: JointLimits, stream: Stream) -> Float64Array:
    """Commands (ticks + 1, joints) of a peer, from the first configuration on."""
    waiting, known, last = list(stream.arrivals), [], stream.stops[0]
    sent, step = [last], limits.velocity / LOOP
    for tick in stream.ticks:
        now = tick / LOOP
        while waiting and waiting[0].time <= now:
            known.append(waiting.pop(0))
        if known:
            wanted = np.clip(target(known[-_KEPT:], now, last), limits.lower, limits.upper)
            last = last + np.clip(wanted - last, -step, step)
        sent.append(last)
    return np.array(sent)


def _between(chunk: Arrival, now: float) -> Float64Array:
    place = (now - chunk.observed) * POLICY
    row = min(int(place), len(chunk.actions) - 2)
    share = place - row
    return np.asarray((1.0 - share) * chunk.actions[row] + share * chunk.actions[row + 1])

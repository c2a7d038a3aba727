"""What happens during a motion besides moving, such as a gripper that closes: names with times.

What changes a motion's clock hands its events on through `moved`, so that they keep their places on
the way. A skill has them at shares of its duration, 0 to 1.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import count
from typing import Any

import numpy as np

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput


@dataclass(frozen=True, order=True)
class Event:
    """time: s, on the clock of the motion that has it. name: what happens, not empty.

    Raises InvalidInput.
    """

    time: float
    name: str

    def __post_init__(self) -> None:
        object.__setattr__(self, "time", check.number(self.time, "time"))
        if not isinstance(self.name, str) or not self.name.strip():
            raise InvalidInput(f"name: expected what happens, got {self.name!r}")


Events = tuple[Event, ...]


def checked(value: Any, times: Float64Array) -> Events:
    """`value` as events in the order of their times, inside those (n,) of a motion.

    Raises InvalidInput.
    """
    if not isinstance(value, Sequence):
        raise InvalidInput(f"events: expected a sequence of Event, got {type(value).__name__}")
    for each in value:
        if not isinstance(each, Event):
            raise InvalidInput(f"events: expected Event, got one of {type(each).__name__}")
    for event in value:
        if not times[0] <= event.time <= times[-1]:
            raise InvalidInput(
                f"events: expected times from {times[0]:.6g} to {times[-1]:.6g} s, as the motion "
                f"has, got {event.name!r} at {event.time:.6g} s"
            )
    return tuple(sorted(value))


def moved(events: Events, old: Any, new: Any) -> Events:
    """The events on another clock, which shows `new` (n,) where theirs shows `old` (n,).

    Both rise; where the old clock stands still, an event comes as soon as the new one gets there.
    """
    if not events:
        return ()
    before, after = np.asarray(old), np.asarray(new)
    times = np.array([event.time for event in events])
    # From the end on backwards: of several equal times np.interp takes the last.
    found = np.clip(np.interp(-times, -before[::-1], after[::-1]), after[0], after[-1])
    return tuple(Event(float(time), event.name) for time, event in zip(found, events, strict=True))


def within(events: Events, first: float, last: float) -> Events:
    """The events from `first` to `last`, s."""
    return tuple(event for event in events if first <= event.time <= last)


def agreed(shown: Sequence[Events], weights: Any = None) -> Events:
    """The events that most of several motions have, at the mean of their times.

    The k-th of a name is the same event in all; it counts where the motions that have it weigh
    more than half of all. weights: (m,), by default equal.
    """
    shares = np.ones(len(shown)) if weights is None else np.asarray(weights)
    seen: dict[tuple[str, int], list[tuple[float, float]]] = defaultdict(list)
    for events, share in zip(shown, shares, strict=True):
        numbers: dict[str, count[int]] = defaultdict(count)
        for event in events:
            seen[event.name, next(numbers[event.name])].append((event.time, float(share)))
    half = 0.5 * float(shares.sum())
    return tuple(
        sorted(
            Event(float(np.average(times, weights=own)), name)
            for (name, _), found in seen.items()
            for times, own in [tuple(zip(*found, strict=True))]
            if sum(own) > half
        )
    )


def every_round(events: Events, rounds: float) -> Events:
    """Events of one round, at 0 to 1, in all of a number of rounds."""
    return tuple(
        Event(event.time + k, event.name)
        for k in range(int(np.ceil(rounds)))
        for event in events
        if event.time + k <= rounds
    )


def by_round(events: Events, first: float, last: float) -> list[Events]:
    """Events from `first` to `last`, in rounds, each round's at 0 to 1."""
    end = int(np.ceil(last))
    return [
        tuple(
            Event(event.time - k, event.name)
            for event in events
            if k <= event.time < k + 1 or event.time == end == k + 1
        )
        for k in range(int(np.floor(first)), end)
    ]


def to_plain(events: Events) -> list[list[Any]]:
    """The events as values that JSON knows."""
    return [[event.time, event.name] for event in events]


def from_plain(value: Any) -> Events:
    """The events that `to_plain` took apart. Raises TypeError, InvalidInput."""
    return tuple(Event(*each) for each in value)

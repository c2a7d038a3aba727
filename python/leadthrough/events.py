"""Events of a motion, such as a gripper that closes: names with times.

Whatever changes a motion's clock passes its events through `moved`, so that they stay at their
places along the path. A skill stores its events at fractions, 0 to 1, of its duration.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import count

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput


@dataclass(frozen=True, order=True)
class Event:
    """Something that happens at one time of a motion.

    Attributes:
        time: s, on the clock of the motion.
        name: action or observation, such as "close gripper"; not blank.
    """

    time: float
    name: str

    def __post_init__(self) -> None:
        object.__setattr__(self, "time", check.number(self.time, "time"))
        if not isinstance(self.name, str):
            raise InvalidInput(f"name: expected the event's name as text, got {self.name!r}")
        if not self.name.strip():
            raise InvalidInput(f"name: expected an event's name, got blank text {self.name!r}")


Events = tuple[Event, ...]


def checked(value: object, times: Float64Array) -> Events:
    """Events in the order of their times."""
    if not isinstance(value, Sequence):
        raise InvalidInput(f"events: expected a sequence of Event, got {type(value).__name__}")
    for i, each in enumerate(value):
        if not isinstance(each, Event):
            raise InvalidInput(f"events[{i}]: expected an Event, got {type(each).__name__}")
    for event in value:
        if not times[0] <= event.time <= times[-1]:
            raise InvalidInput(
                f"events: expected times within the motion, {times[0]:.6g} to {times[-1]:.6g} s, "
                f"got {event.name!r} at {event.time:.6g} s"
            )
    return tuple(sorted(value))


def moved(events: Events, old: ArrayLike, new: ArrayLike) -> Events:
    """The events on another clock."""
    if not events:
        return ()
    before, after = np.asarray(old), np.asarray(new)
    times = np.array([event.time for event in events])
    # From the end backwards: of several equal times np.interp takes the last.
    found = np.clip(np.interp(-times, -before[::-1], after[::-1]), after[0], after[-1])
    return tuple(Event(float(time), event.name) for time, event in zip(found, events, strict=True))


def within(events: Events, first: float, last: float) -> Events:
    """The events from `first` to `last`, s, both included."""
    return tuple(event for event in events if first <= event.time <= last)


def clipped(events: Events, times: Float64Array) -> Events:
    """All events, those outside of a motion's times (n,) moved to its nearer end."""
    return tuple(
        Event(float(np.clip(event.time, times[0], times[-1])), event.name) for event in events
    )


def agreed(shown: Sequence[Events], weights: ArrayLike | None = None) -> Events:
    """The events that most of several motions have, at the weighted mean of their times."""
    each_weight = np.ones(len(shown)) if weights is None else np.asarray(weights)
    seen: dict[tuple[str, int], list[tuple[float, float]]] = defaultdict(list)
    for events, weight in zip(shown, each_weight, strict=True):
        numbers: dict[str, count[int]] = defaultdict(count)
        for event in events:
            seen[event.name, next(numbers[event.name])].append((event.time, float(weight)))
    half = 0.5 * float(each_weight.sum())
    return tuple(
        sorted(
            Event(float(np.average(times, weights=own)), name)
            for (name, _), found in seen.items()
            for times, own in [tuple(zip(*found, strict=True))]
            if sum(own) > half
        )
    )


def every_round(events: Events, rounds: float) -> Events:
    """The events of one round, repeated in every round; a round lasts 1."""
    return tuple(
        Event(event.time + k, event.name)
        for k in range(int(np.ceil(rounds)))
        for event in events
        if event.time + k <= rounds
    )


def by_round(events: Events, first: float, last: float) -> list[Events]:
    """The events of each round from `first` to `last`, at times 0 to 1 within their round."""
    end = int(np.ceil(last))
    return [
        tuple(
            Event(event.time - k, event.name)
            for event in events
            if k <= event.time < k + 1 or event.time == end == k + 1
        )
        for k in range(int(np.floor(first)), end)
    ]


def to_plain(events: Events) -> list[list[float | str]]:
    """The events as [time, name] pairs, which JSON can hold."""
    return [[event.time, event.name] for event in events]


def from_plain(value: Iterable[tuple[float, str]]) -> Events:
    """The events of [time, name] pairs, as `to_plain` makes them."""
    return tuple(Event(*each) for each in value)

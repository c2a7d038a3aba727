"""Time stamps of ROS messages: whole seconds and nanoseconds apart."""

from __future__ import annotations

from typing import TypedDict

NANOSECONDS = 1_000_000_000  # per second


class Stamp(TypedDict):
    """A time or duration as ROS 2 messages have it; `nanosec` is below 10**9."""

    sec: int
    nanosec: int


def stamp(nanoseconds: int) -> Stamp:
    """The stamp of a time in ns."""
    sec, nanosec = divmod(nanoseconds, NANOSECONDS)
    return {"sec": sec, "nanosec": nanosec}


def nanoseconds(sec: int, nanosec: int) -> int:
    """The time of a stamp in ns; its parts may be any kind of integer."""
    return int(sec) * NANOSECONDS + int(nanosec)

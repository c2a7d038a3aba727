"""Chunks of a simulated policy followed at 1 kHz: limits, contacts, lag and jerk of four methods.

A policy moves an arm through random configurations, by chunks of a second at 30 Hz, with noise and
with an offset of each chunk. They come 150 ms after they were observed, with one fault at a time,
as is reported of arms that run learned policies: half of the chunks 800 ms late; most of them lost;
a loop that misses 21 periods; wide seams between chunks; motions beyond the limits; an obstacle on
the way. Every method gets the same chunks. Commands are judged by their finite differences, by
`Arm.is_clear` at every fourth, and beside the motion that the policy means.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from leadthrough.arm import Arm, JointLimits
from leadthrough.check import Float64Array
from leadthrough.guard import Chunks, Guard
from leadthrough_studies.chunks.peers import PEERS, followed
from leadthrough_studies.chunks.report import report
from leadthrough_studies.chunks.streams import FAULTS, LOOP, POLICY, Stream, stream
from leadthrough_studies.study import Row, Study, Task

OURS = "ours"
_HOMES = {
    "panda": (0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7),
    "ur3": (0.0, -1.4, 1.6, -1.8, -1.5, 0.0),
}
_REACHED = 0.01  # m, of the tip
_LOOKED_AT = 4  # every so many commands, for contacts and the lag
# Third differences of accelerations that are linear between commands.
_JERK = 7.0 / 6.0


@dataclass(frozen=True)
class ChunksConfig:
    """The configuration of the study.

    Attributes:
        arms: names of the arms.
        faults: of the streams.
        streams: of each arm and fault.
        segments: of each motion, from one configuration to the next.
        seed: of motions and chunks.
    """

    arms: tuple[str, ...] = ("panda", "ur3")
    faults: tuple[str, ...] = FAULTS
    streams: int = 4
    segments: int = 4
    seed: int = 0


def configure(quick: bool, seed: int) -> ChunksConfig:
    """Four streams of each arm for each fault, or one of a Panda."""
    if quick:
        return ChunksConfig(("panda",), streams=1, segments=2, seed=seed)
    return ChunksConfig(seed=seed)


def tasks(config: ChunksConfig) -> list[Task]:
    """A task for every stream."""
    return [
        Task(
            follow,
            {
                "arm": arm,
                "fault": fault,
                "segments": config.segments,
                "seed": [config.seed, number],
            },
        )
        for arm in config.arms
        for fault in config.faults
        for number in range(config.streams)
    ]


def follow(*, arm: str, fault: str, segments: int, seed: list[int]) -> list[Row]:
    """A row for each method."""
    robot = Arm.load(arm)
    coming = stream(robot, np.array(_HOMES[arm]), fault, segments, seed)
    ours, calls = _ours(robot, coming)
    rows = []
    for method, sent in [
        *((name, followed(target, robot.limits, coming)) for name, target in PEERS.items()),
        (OURS, ours),
    ]:
        row = {"arm": arm, "fault": fault, "method": method, "seed": seed[-1]}
        rows.append(row | _judged(robot, coming, sent))
    rows[-1] |= {"p99_call_ms": float(np.quantile(calls, 0.99)), "max_call_ms": max(calls)}
    return rows


def _ours(arm: Arm, coming: Stream) -> tuple[Float64Array, list[float]]:
    """Commands, and the processor time of each period, ms."""
    chunks = Chunks(Guard(arm, coming.obstacles, rate=LOOP), rate=POLICY)
    chunks.start(coming.stops[0])
    waiting, sent, calls = list(coming.arrivals), [coming.stops[0]], []
    for tick in coming.ticks:
        begin = time.thread_time()
        while waiting and waiting[0].time <= tick / LOOP:
            each = waiting.pop(0)
            chunks.put(each.actions, each.observed)
        sent.append(chunks.next(tick / LOOP).q)
        calls.append(1e3 * (time.thread_time() - begin))
    return np.array(sent), calls


def _judged(arm: Arm, coming: Stream, sent: Float64Array) -> Row:
    times = np.array([0, *coming.ticks]) / LOOP
    some = slice(None, None, _LOOKED_AT)
    lag = _least_lag(coming, times[some], sent[some]) if len(coming.obstacles) == 1 else None
    tips = arm.forward_kinematics(np.array([sent[-1], coming.stops[-1]]))[0]
    jerk = np.diff(sent, 3, axis=0) * LOOP**3
    clear = np.asarray(arm.is_clear(sent[some], coming.obstacles))
    return {
        **_uses(sent, arm.limits),
        "contacts": int(np.count_nonzero(~clear)),
        "lag_ms": None if lag is None else 1e3 * lag,
        "error_rad": float(np.abs(sent - coming.wanted(times)).mean()),
        "jerk_rms": float(np.sqrt(np.mean((jerk / np.asarray(arm.limits.jerk)) ** 2))),
        "reached": int(np.linalg.norm(tips[0] - tips[1]) < _REACHED),
    }


def _least_lag(coming: Stream, times: Float64Array, sent: Float64Array) -> float:
    """The lag in s with which the commands are nearest to the motion that the policy means."""
    best, reach = 0.3, 0.5
    for step in (0.01, 0.001):
        tried = best + np.arange(-reach, reach + 0.5 * step, step)
        errors = [np.abs(sent - coming.wanted(times - lag)).mean() for lag in tried]
        best, reach = float(tried[np.argmin(errors)]), step
    return round(best, 3)


def _uses(sent: Float64Array, limits: JointLimits) -> Row:
    """The largest fraction of each limit that is used."""
    uses = {}
    for order, name in enumerate(("velocity", "acceleration", "jerk"), 1):
        used = np.abs(np.diff(sent, order, axis=0)) * LOOP**order / getattr(limits, name)
        uses[f"{name}_use"] = float(used.max()) / (_JERK if name == "jerk" else 1.0)
    return uses


STUDY = Study(configure, tasks, report)

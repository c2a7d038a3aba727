"""Streams of a simulated policy's chunks: a motion through random configurations, and faults."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from leadthrough import trajectories as tr
from leadthrough.arm import Arm
from leadthrough.check import Float64Array
from leadthrough.shapes import Box, Shape, Sphere

LOOP, POLICY = 1000.0, 30.0  # Hz
_ACTIONS = 30  # of a chunk
_EVERY = 6  # actions from one chunk to the next
_LATENCY = 0.15  # s
_LATE = 0.8  # s
_MISSED = 21  # periods
_NOISE, _SEAM, _WIDE_SEAM = 0.001, 0.003, 0.02  # rad, of actions and of whole chunks
_SEGMENT = 1.6  # s from one configuration to the next
_FAST_SEGMENT = 0.5  # s, where the policy is too fast
_USE = 0.5  # of the limit of velocity that a segment uses at most
_BALLS = (0.06, 0.03)  # m, radii of the obstacle that are tried
_MAX_DRAWS = 1000
_PEAK = 15.0 / 8.0  # of the velocity of a minimum-jerk motion, over its mean
TABLE = Box((1.2, 1.6, 0.05), (0.7, 0.0, -0.1))

FAULTS = ("none", "late", "lost", "missed periods", "seams", "too fast", "obstacle")


@dataclass(frozen=True, eq=False)
class Arrival:
    """A chunk as it comes."""

    time: float  # s
    observed: float  # s
    actions: Float64Array  # (n, joints), rad


@dataclass(frozen=True, eq=False)
class Stream:
    """A motion that a policy means, its chunks, and the periods in which the loop ran."""

    stops: Float64Array  # (n, joints), configurations, rad
    segment: float  # s between two of them
    arrivals: list[Arrival]
    ticks: list[int]
    obstacles: list[Shape]

    def wanted(self, times: Float64Array) -> Float64Array:
        """The configurations (n, joints) that the policy means at some times."""
        place = np.clip(times / self.segment, 0.0, len(self.stops) - 1.0)
        first = np.minimum(place.astype(np.intp), len(self.stops) - 2)
        rise = tr.minimum_jerk_time_scaling(place - first)[:, None]
        return np.asarray(self.stops[first] + rise * (self.stops[first + 1] - self.stops[first]))


def stream(arm: Arm, home: Float64Array, fault: str, segments: int, seed: list[int]) -> Stream:
    """A stream with a fault; its motion is clear of the table."""
    rng = np.random.default_rng([*seed, FAULTS.index(fault)])
    segment = _FAST_SEGMENT if fault == "too fast" else _SEGMENT
    bare = Stream(_stops(arm, home, segments, rng), segment, [], [], [TABLE])
    seconds = segments * segment + 1.0
    count = round(seconds * LOOP)
    starts = np.arange(0, round(seconds * POLICY) - 1, _EVERY) / POLICY
    seam = _WIDE_SEAM if fault == "seams" else _SEAM
    arrivals = []
    for number, observed in enumerate(starts.tolist()):
        actions = bare.wanted(observed + np.arange(_ACTIONS) / POLICY)
        if observed < seconds - 1.0:  # later the policy sees that the arm is there
            actions = actions + rng.normal(0.0, seam, actions.shape[1])
        actions = actions + rng.normal(0.0, _NOISE, actions.shape)
        late = fault == "late" and number % 8 in (4, 5, 6, 7)
        latency = _LATE if late else _LATENCY
        if fault != "lost" or number % 8 < 2 or observed > seconds - 2.0:
            arrivals.append(Arrival(observed + latency, observed, actions))
    arrivals.sort(key=lambda each: (each.time, each.observed))
    ticks = [t for t in range(1, count) if fault != "missed periods" or t % 500 >= _MISSED]
    obstacles: list[Shape] = [TABLE]
    if fault == "obstacle":
        obstacles.append(_on_the_way(arm, bare.stops))
    return Stream(bare.stops, segment, arrivals, ticks, obstacles)


def _on_the_way(arm: Arm, stops: Float64Array) -> Sphere:
    """A ball in the middle of a segment's path of the tip, clear of the arm at first."""
    balls = [
        Sphere(radius, arm.forward_kinematics(0.5 * (a + b))[0])
        for radius in _BALLS
        for a, b in pairwise(stops)
    ]
    return next((ball for ball in balls if arm.is_clear(stops[0], [TABLE, ball])), balls[-1])


def _stops(arm: Arm, home: Float64Array, count: int, rng: np.random.Generator) -> Float64Array:
    """Configurations with clear segments between them, each within its use of the limits."""
    stops = [home]
    reach = _USE * arm.limits.velocity * _SEGMENT / _PEAK
    for _ in range(_MAX_DRAWS):
        if len(stops) == count + 1:
            break
        goal = stops[-1] + rng.choice([-1.0, 1.0], len(home)) * rng.uniform(0.3, 1.0) * reach
        goal = np.clip(goal, home - 0.9, home + 0.9)
        inside = np.all((goal > arm.limits.lower + 0.1) & (goal < arm.limits.upper - 0.1))
        if inside and arm.check(np.linspace(stops[-1], goal, 20), [TABLE]).ok:
            stops.append(goal)
    return np.array(stops)

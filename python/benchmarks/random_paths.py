"""Random paths for the time law, hostile ones among them: paths refused and limits exceeded.

    python python/benchmarks/random_paths.py 100000 [FIRST]

Way-points that nearly coincide, tiny motions, joints that move alone, narrow turns, motions to and
fro on a line, noisy and pausing recordings, limits over decades. All of them can be done: a refusal
is a fault, and so is a limit exceeded by more than 1e-6 of itself: by differences of the positions,
by the densely sampled quintics between samples, and by differences of accelerations.
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

import leadthrough as lt
from leadthrough.arm import JointLimits
from leadthrough.trajectories import Spline

RATES = (100.0, 250.0, 500.0, 1000.0, 1000.0, 1000.0)
ALLOWED = 1e-6
Rng = np.random.Generator


@dataclass(frozen=True, eq=False)
class Case:
    """A path, limits and the other arguments of `lt.retime`."""

    kind: str
    path: Any
    limits: JointLimits
    options: dict[str, Any] = field(default_factory=dict)


def case(seed: int) -> Case:
    """The random path of a number; kinds take turns."""
    rng = np.random.default_rng([15, seed])
    joints, points = int(rng.integers(1, 9)), int(rng.integers(2, 9))
    limits, size = _limits(rng, joints), 10 ** rng.uniform(-2, 0.5)
    way = size * rng.normal(size=(points, joints))
    if rng.random() < 0.3:
        way += rng.uniform(-3.0, 3.0, joints)
    kinds = list(_KINDS)
    kind = kinds[seed % len(kinds)]
    path, options = _KINDS[kind](rng, way, size)
    return Case(kind, path, limits, {"rate": float(rng.choice(RATES)), **options})


def excess(motion: lt.JointTrajectory, limits: JointLimits) -> float:
    """By how much of itself a limit is exceeded, beyond the rounding of the positions."""
    q, ratio = motion.positions, 0.0
    if len(q) == 1:
        return -1.0
    step = motion.times[1] - motion.times[0]
    standing = np.vstack([q[[0] * 3], q, q[[-1] * 3]])
    ulps = np.finfo(np.float64).eps * np.abs(q).max(axis=0)
    between = _between(motion, step)
    for order, limit in enumerate((limits.velocity, limits.acceleration, limits.jerk), 1):
        differences = np.abs(np.diff(standing, order, axis=0)).max(axis=0) / step**order
        differences -= ulps * (2.0 / step) ** order
        curve = np.abs(between[order]).max(axis=(0, 1)) - 10.0 * ulps * (2.0 / step) ** order
        ratio = max(ratio, float((np.maximum(differences, curve) / limit).max()))
    return ratio - 1.0


def _between(motion: lt.JointTrajectory, step: float) -> dict[int, Any]:
    """Velocities and accelerations (samples a step, steps, joints) of the quintics, and jerks."""
    states = [motion.positions, motion.velocities, motion.accelerations]
    q, v, a = (np.stack([rows[:-1], rows[1:]]) * step**k for k, rows in enumerate(states))
    c0, c1, c2 = q[0], v[0], 0.5 * a[0]
    rise, gain, push = q[1] - c0 - c1 - c2, v[1] - c1 - 2.0 * c2, a[1] - 2.0 * c2
    c3, c4, c5 = (
        10.0 * rise - 4.0 * gain + 0.5 * push,
        -15.0 * rise + 7.0 * gain - push,
        6.0 * rise - 3.0 * gain + 0.5 * push,
    )
    u = np.linspace(0.0, 1.0, 9)[:, None, None]
    velocity = c1 + u * (2.0 * c2 + u * (3.0 * c3 + u * (4.0 * c4 + u * 5.0 * c5)))
    acceleration = 2.0 * c2 + u * (6.0 * c3 + u * (12.0 * c4 + u * 20.0 * c5))
    jerk = np.diff(a, axis=0) / step**3
    return {1: velocity / step, 2: acceleration / step**2, 3: jerk}


def _limits(rng: Rng, joints: int) -> JointLimits:
    def spread(size: float) -> Any:
        return 10 ** rng.uniform(-size, size, joints)

    velocity = 10 ** rng.uniform(-1, 1) * spread(0.5)
    acceleration = velocity * 10 ** rng.uniform(0, 1.5) * spread(0.3)
    jerk = acceleration * 10 ** rng.uniform(0, 2.5) * spread(0.3)
    if rng.random() < 0.1:
        jerk = np.full(joints, np.inf)
    names, far = tuple(f"joint_{i}" for i in range(joints)), np.full(joints, 1e3)
    return JointLimits(names, -far, far, velocity, acceleration, jerk)


def _corners(rng: Rng, way: Any, size: float) -> tuple[Any, dict[str, Any]]:
    return way, {"blend": size * 10 ** rng.uniform(-4, 0)}


def _stops(rng: Rng, way: Any, _size: float) -> tuple[Any, dict[str, Any]]:
    if rng.random() < 0.5:
        return way, {}
    return way, {"dwell_times": {int(rng.integers(len(way))): float(rng.uniform(0, 0.3))}}


def _coinciding(rng: Rng, way: Any, size: float) -> tuple[Any, dict[str, Any]]:
    rows = [way[0]]
    for point in way[1:]:
        for _ in range(rng.integers(0, 3)):
            shift = 10 ** rng.uniform(-16, -2) * rng.normal(size=len(point))
            if rng.random() < 0.5:
                shift *= np.arange(len(point)) == rng.integers(len(point))
            rows.append(rows[-1] + shift)
        rows += [point] * (1 + (rng.random() < 0.2))
    blend = size * 10 ** rng.uniform(-6, 0) if rng.random() < 0.6 else 0.0
    return np.array(rows), {"blend": blend}


def _tiny(rng: Rng, way: Any, _size: float) -> tuple[Any, dict[str, Any]]:
    path = way[0] + 10 ** rng.uniform(-12, -3) * rng.normal(size=way.shape)
    return path, {"blend": 10 ** rng.uniform(-13, -3) if rng.random() < 0.5 else 0.0}


def _single(rng: Rng, way: Any, size: float) -> tuple[Any, dict[str, Any]]:
    path, joint = np.repeat(way[:1], len(way), axis=0), rng.integers(way.shape[1])
    path[:, joint] = way[:, joint]
    return path, {"blend": size * 10 ** rng.uniform(-6, 0) if rng.random() < 0.5 else 0.0}


def _spline(rng: Rng, way: Any, _size: float) -> tuple[Any, dict[str, Any]]:
    knots = np.cumsum(10 ** rng.uniform(-1, 0, len(way)))
    spline = CubicSpline(knots, way, bc_type="natural")
    return Spline(spline.x, spline.c[::-1].transpose(1, 0, 2)), {}


def _cusp(rng: Rng, way: Any, size: float) -> tuple[Any, dict[str, Any]]:
    """Nearly to and fro: a parabola's turn, as narrow as its first term is small."""
    table = np.zeros((1, 6, way.shape[1]))
    table[0, :3] = [
        way[0],
        10 ** rng.uniform(-7, 0) * way[-1],
        size * rng.normal(size=table.shape[2]),
    ]
    begin, end = -rng.uniform(0.2, 1), rng.uniform(0.2, 1)
    table[0, 0] += begin * table[0, 1] + begin**2 * table[0, 2]
    table[0, 1] += 2.0 * begin * table[0, 2]
    return Spline(np.array([begin, end]), table), {}


def _recording(rng: Rng, way: Any, _size: float) -> tuple[Any, dict[str, Any]]:
    count = int(rng.integers(3, 400))
    u = np.linspace(0, len(way) - 1, count)
    places = np.clip(u + rng.uniform(0, 0.8) * np.sin(u * rng.uniform(0, 7)), 0, len(way) - 1)
    curve = CubicSpline(np.arange(len(way)), way)
    q = curve(places)
    if rng.random() < 0.3:
        q = q + 10 ** rng.uniform(-8, -4) * rng.normal(size=q.shape)
    if rng.random() < 0.3:
        pause = int(rng.integers(count))
        q[pause : pause + 60] = q[pause]
    return lt.JointTrajectory(np.linspace(0, rng.uniform(0.5, 10), count), q), {}


def _line(rng: Rng, way: Any, size: float) -> tuple[Any, dict[str, Any]]:
    share = rng.uniform(0, 1, len(way))
    share = share if rng.random() < 0.3 else np.sort(share)
    path = way[0] + share[:, None] * (way[1] - way[0])
    return path, {"blend": float(rng.choice([0.0, 0.01 * size]))}


def _uneven(rng: Rng, way: Any, size: float) -> tuple[Any, dict[str, Any]]:
    """Steps of joints of very different extent, forwards and back."""
    steps = rng.choice([-1.0, 0.0, 1.0], size=(len(way) + 2, way.shape[1]))
    path = np.cumsum(steps * 10 ** rng.uniform(-7, 0, way.shape[1]), axis=0) * size
    return path, {"blend": size * 10 ** rng.uniform(-6, -1) if rng.random() < 0.5 else 0.0}


_KINDS: dict[str, Callable[[Rng, Any, float], tuple[Any, dict[str, Any]]]] = {
    "corners": _corners,
    "stops": _stops,
    "coinciding": _coinciding,
    "tiny": _tiny,
    "single": _single,
    "spline": _spline,
    "cusp": _cusp,
    "recording": _recording,
    "line": _line,
    "uneven": _uneven,
}


def main() -> int:
    """Prints what becomes of each kind; the exit code is 0 if there is no fault."""
    count, first = int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 0
    results: Counter[tuple[str, str]] = Counter()
    worst = -1.0
    for seed in range(first, first + count):
        one = case(seed)
        try:
            used = excess(lt.retime(one.path, one.limits, **one.options), one.limits)
        except lt.errors.LeadthroughError as error:
            results[one.kind, "refused"] += 1
            print(f"{seed} {one.kind}: {error}")
            continue
        worst = max(worst, used)
        results[one.kind, "exceeded" if used > ALLOWED else "kept"] += 1
    for (kind, result), times in sorted(results.items()):
        print(f"{kind:<12} {result:<9} {times:7d}")
    print(f"largest excess of a limit, relative to it: {worst:.2e}")
    return int(any(result != "kept" for _, result in results))


if __name__ == "__main__":
    sys.exit(main())

"""How the cost grows: with cells, joints, weights, demonstrations, way-points, obstacles, threads.

Each series is one problem in several sizes, ours and a peer's, answers checked as in the table. Of
threads the peer is one thread, and the times are those of the wall clock.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import bench_time_law as time_law
import numpy as np
import pinocchio as pin
import skfmm
from bench_collision import Peer
from frame import Benchmark, Row, measure
from judge import random_configurations
from matplotlib.figure import Figure
from movement_primitives import dmp as peers
from movement_primitives.promp import ProMP as PeerProMP
from waits import demonstrations

import leadthrough as lt

REPEATS = 3
# Of batches on threads: wall times of some milliseconds, on which other processes show.
MORE_REPEATS = 15
LIMITS = lt.Arm.load("panda").limits


@dataclass(frozen=True)
class Series:
    """One problem in several sizes.

    Attributes:
        quantity: the growing one.
        sizes: of it.
        benchmark: the problem of a size.
        repeats: of each side; the least time counts.
    """

    quantity: str
    sizes: Sequence[int]
    benchmark: Callable[[int], Benchmark]
    repeats: int = REPEATS


def measured(*, quick: bool) -> Iterator[tuple[Series, list[Row]]]:
    """Each series with a row for each of its sizes; quick takes the smaller half of them."""
    for series in SERIES:
        few = series.sizes[: max(2, len(series.sizes) // 2)] if quick else series.sizes
        rows = [measure(series.benchmark(size), series.repeats) for size in few]
        yield replace(series, sizes=few), rows


def plot(results: Sequence[tuple[Series, list[Row]]], path: Path) -> None:
    """Draws every series into one figure.

    Args:
        results: the series and their rows.
        path: the image to write.
    """
    columns = 4
    figure = Figure(figsize=(14.0, 3.2 * -(-len(results) // columns)), layout="constrained")
    panels = np.ravel(figure.subplots(-(-len(results) // columns), columns))
    for panel in panels[len(results) :]:
        panel.set_axis_off()
    for panel, (series, rows) in zip(panels, results, strict=False):
        known = [(size, row) for size, row in zip(series.sizes, rows, strict=True) if row.passed]
        sizes = [size for size, _ in known]
        panel.loglog(sizes, [row.ours_best for _, row in known], "o-", label="leadthrough")
        panel.loglog(sizes, [row.peer_best for _, row in known], "s--", label=rows[0].peer)
        panel.set_xlabel(series.quantity)
        panel.set_ylabel("s")
        panel.set_xticks(sizes, [f"{size:,}" for size in sizes], rotation=30)
        panel.minorticks_off()
        panel.grid(alpha=0.3)
        panel.legend()
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path)


def _cells(side: int) -> Benchmark:
    speed = np.ones((side,) * 3)
    source = (side // 2,) * 3
    front = np.ones(speed.shape)
    front[source] = 0.0
    return Benchmark(
        f"scaling: march {side}³ cells",
        ours=lambda: lt.arrival_times(speed, [source], dtype=np.float32),
        peer=lambda: skfmm.travel_time(front, speed, order=1),
        peer_name="scikit-fmm",
        # Its front is a surface about the source, ours the source: half a cell apart.
        error=lambda a, b: float(np.abs(a - b).max()) / side,
        tolerance=0.05,
    )


def _joints(count: int) -> Benchmark:
    text = _serial_arm(count)
    arm = lt.Arm.from_urdf(text)
    model = pin.buildModelFromXML(text)
    data, tip = model.createData(), model.getFrameId(arm.tip)
    q = np.random.default_rng(0).uniform(-1.0, 1.0, (2000, count))

    def peer() -> Any:
        places = np.empty((len(q), 3))
        for i, row in enumerate(q):
            pin.framesForwardKinematics(model, data, row)
            places[i] = data.oMf[tip].translation
        return places

    return Benchmark(
        f"scaling: forward kinematics of {count} joints",
        ours=lambda: arm.forward_kinematics(q)[0],
        peer=peer,
        peer_name="pin",
        error=lambda a, b: float(np.abs(a - b).max()),
        tolerance=1e-9,
    )


def _serial_arm(count: int) -> str:
    joint = (
        '<link name="l{0}"/><joint name="j{0}" type="revolute"><parent link="l{1}"/>'
        '<child link="l{0}"/><origin xyz="0 0 0.2"/><axis xyz="{2}"/>'
        '<limit lower="-3" upper="3" velocity="2" effort="10"/></joint>'
    )
    axes = ("0 0 1", "0 1 0", "1 0 0")
    parts = "".join(joint.format(k + 1, k, axes[k % 3]) for k in range(count))
    return f'<robot name="serial"><link name="l0"/>{parts}</robot>'


def _weights(count: int) -> Benchmark:
    times = np.linspace(0.0, 1.0, 1001)
    rise = lt.trajectories.minimum_jerk_time_scaling(times)[:, None]
    joints = np.sin(np.outer(times, np.arange(1, 8))) * rise
    shown = [lt.Demonstration(lt.JointTrajectory(times, joints))]

    def peer() -> Any:
        primitive = peers.DMP(7, execution_time=1.0, dt=0.001, n_weights_per_dim=count)
        primitive.imitate(times, joints)
        return primitive.open_loop()[1]

    return Benchmark(
        f"scaling: primitive of {count} weights",
        ours=lambda: lt.DMP(weights=count).fit(shown).generate(dt=0.001).positions,
        peer=peer,
        peer_name="movement_primitives",
        error=lambda a, _: float(np.abs(a - joints).mean()),
        tolerance=0.02,
    )


def _demonstrations(count: int) -> Benchmark:
    rng = np.random.default_rng(0)
    u = np.linspace(0.0, 1.0, 200)
    shape = np.sin(np.outer(u, np.arange(1, 8)))
    curves = shape + rng.normal(0.0, 0.1, (count, 1, 7)) * u[:, None]
    shown = [lt.Demonstration(lt.JointTrajectory(u, each)) for each in curves]

    def peer() -> Any:
        primitive = PeerProMP(7, 10)
        primitive.imitate(np.tile(u, (count, 1)), curves)
        return primitive.mean_trajectory(u.copy())

    return Benchmark(
        f"scaling: ProMP of {count} demonstrations",
        ours=lambda: lt.ProMP(weights=10).fit(shown).distribution(u)[0],
        peer=peer,
        peer_name="movement_primitives",
        error=lambda a, _: float(np.abs(a - curves.mean(axis=0)).max()),
        tolerance=0.05,
    )


def _way_points(count: int) -> Benchmark:
    way = np.random.default_rng(0).uniform(-1.0, 1.0, (count, 7))
    points = 80 * count
    optimum = time_law.peer(way, LIMITS, points)
    return Benchmark(
        f"scaling: time law through {count} way-points",
        ours=lambda: time_law.ours(way, LIMITS, 1.0),
        peer=lambda: time_law.peer(way, LIMITS, points),
        peer_name="toppra",
        error=lambda a, _: a.duration / optimum - 1.0,
        tolerance=0.05,
    )


def _obstacles(count: int) -> Benchmark:
    rng = np.random.default_rng(2)
    places = rng.uniform((-0.8, -0.8, 0.0), (0.8, 0.8, 1.0), (count, 3))
    boxes = [lt.Box((0.1, 0.05, 0.2), place) for place in places]
    arm = lt.Arm.load("panda")
    q = random_configurations(arm, 100, seed=1)
    peer = Peer("panda", arm).to_boxes(boxes)

    def error(ours: Any, theirs: Any) -> float:
        apart = (ours > 1e-5) | (theirs > 1e-5)
        return float(np.abs(ours - theirs)[apart].max(initial=0.0))

    return Benchmark(
        f"scaling: distance of the arm to {count} boxes",
        ours=lambda: arm.distance(q, boxes),
        peer=lambda: peer(q),
        peer_name="coal",
        error=error,
        tolerance=1e-5,
    )


def _threads(count: int, what: str) -> Benchmark:
    ours = BATCHES[what]()
    return Benchmark(
        f"scaling: {what} on {count} threads, wall time",
        ours=partial(ours, threads=count),
        peer=partial(ours, threads=1),
        peer_name="one thread",
        error=lambda a, b: float(not all(map(np.array_equal, a, b))),
        tolerance=0.0,
        clock=time.perf_counter,
    )


def _solved() -> Callable[..., Any]:
    arm = lt.Arm.load("panda")
    places, turns = arm.forward_kinematics(random_configurations(arm, 2000, seed=1))
    return lambda threads: arm.inverse_kinematics_batch(places, turns, threads=threads).q


def _apart() -> Callable[..., Any]:
    arm = lt.Arm.load("panda")
    q = random_configurations(arm, 2000, seed=1)
    return lambda threads: arm.self_distance(q, threads=threads)


def _sampled() -> Callable[..., Any]:
    times = np.linspace(0.0, 5.0, 500)
    waves = np.sin(np.outer(times, np.arange(1, 8)))
    skill = lt.ProMP().fit([lt.JointTrajectory(times, waves * scale) for scale in (0.5, 0.6)])
    return lambda threads: [
        each.positions for each in skill.sample(50, seed=1, dt=1e-3, threads=threads)
    ]


def _checked() -> Callable[..., Any]:
    arm = lt.Arm.load("panda")
    ends = random_configurations(arm, 11, seed=1)
    q = np.concatenate([np.linspace(a, b, 100) for a, b in pairwise(ends)])
    boxes = [lt.Box((0.1, 0.05, 0.2), place) for place in ((0.6, 0.3, 0.2), (-0.4, 0.5, 0.4))]
    return lambda threads: arm.check(q, boxes, threads=threads).distances


def _planned() -> Callable[..., Any]:
    skill = lt.FastMarching().fit(demonstrations(3))
    box = lt.Box((0.06, 0.06, 0.3), skill.generate().at(1.5))
    moved = np.random.default_rng(3).uniform(-0.02, 0.02, (32, 3))
    goal = skill.generate().positions[-1]
    return _generated(skill, [{"goal": goal + each, "obstacles": [box]} for each in moved])


def _rolled_out() -> Callable[..., Any]:
    times = np.linspace(0.0, 10.0, 1001)
    s = lt.trajectories.minimum_jerk_time_scaling(times / 10.0)[:, None]
    turned = lt.rotations.exp(s * [0.3, 0.2, 1.5])
    skill = lt.DMP().fit([lt.PoseTrajectory(times, s * [0.3, 0.2, 0.1], turned)])
    moved = np.random.default_rng(3).uniform(-0.05, 0.05, (50, 3))
    end = skill.generate().positions[-1]
    return _generated(skill, [{"goal": end + each, "dt": 1e-3} for each in moved])


def _generated(skill: Any, queries: Sequence[dict[str, Any]]) -> Callable[..., Any]:
    return lambda threads: [
        each.positions for each in lt.models.generate_all(skill, queries, threads=threads)
    ]


BATCHES = {
    "inverse kinematics": _solved,
    "distances": _apart,
    "checks": _checked,
    "plans": _planned,
    "rollouts": _rolled_out,
    "samples": _sampled,
}
SERIES = (
    Series("cells along a side, 3-D march", (20, 40, 80, 120), _cells),
    Series("joints, 2,000 forward kinematics", (2, 4, 7, 14), _joints),
    Series("weights, fit and rollout of 7 joints", (10, 25, 50, 100, 200), _weights),
    Series("demonstrations, fit of 7 joints", (2, 5, 10, 20, 40), _demonstrations),
    Series("way-points, time law of 7 joints", (6, 12, 50, 200), _way_points),
    Series("boxes, 100 distances of an arm", (1, 3, 10, 30), _obstacles),
    *(
        Series(f"threads, {what}", (1, 2), partial(_threads, what=what), MORE_REPEATS)
        for what in BATCHES
    ),
)

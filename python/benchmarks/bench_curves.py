"""Evaluation of curves against SciPy and pytransform3d."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from frame import Benchmark
from pytransform3d.batch_rotations import quaternion_slerp_batch
from scipy.interpolate import BPoly, CubicSpline

from leadthrough import rotations, trajectories as tr

TOLERANCE = 1e-12
REPEATS = 1000


def benchmarks(*, quick: bool) -> Iterator[Benchmark]:
    """Curves of seven dimensions at 1,000 times, evaluated repeatedly."""
    repeats = REPEATS // 10 if quick else REPEATS
    rng = np.random.default_rng(0)
    times, points = np.linspace(0.0, 1.0, 12), rng.normal(size=(12, 7))
    fine = np.linspace(0.0, 1.0, 1000)
    spline, cubic = tr.natural_cubic(times, points), CubicSpline(times, points, bc_type="natural")
    bezier, poly = tr.Bezier(points[:6]), BPoly(points[:6, None], [0.0, 1.0])
    ends = rotations.exp(rng.normal(size=(2, 3)))
    slerp = tr.Slerp([0.0, 1.0], ends)
    yield _row("cubic spline", "SciPy", spline.evaluate, cubic, t=fine, repeats=repeats)
    yield _row("Bezier curve of degree 5", "SciPy", bezier.evaluate, poly, t=fine, repeats=repeats)

    def peer(t: Any) -> Any:
        return quaternion_slerp_batch(*ends, t, shortest_path=True)

    yield _row("slerp", "pytransform3d", slerp.evaluate, peer, t=fine, repeats=repeats)


def _row(name: str, peer_name: str, ours: Any, peer: Any, *, t: Any, repeats: int) -> Benchmark:
    return Benchmark(
        f"{name}, 1000 times",
        ours=lambda: _last(ours, t, repeats),
        peer=lambda: _last(peer, t, repeats),
        peer_name=peer_name,
        error=lambda a, b: float(np.minimum(np.abs(a - b), np.abs(a + b)).max()),
        tolerance=TOLERANCE,
    )


def _last(evaluate: Any, t: Any, repeats: int) -> Any:
    """The last of several answers: to keep all would measure how the system hands out memory."""
    for _ in range(repeats):
        answer = evaluate(t)
    return answer

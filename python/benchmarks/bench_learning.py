"""Learning from eight demonstrations of 200 samples, against movement_primitives.

`lt.learn` leaves each demonstration out and chooses among four families; the peer's two, a ProMP
and the DMP of the nearest demonstration, are chosen among in the same way. A family and a query are
AlignedMean's, which is chosen, against the ProMP conditioned on both ends. A simulated person shows
reaches over an obstacle. The error is ours over the peer's on reaches that neither has learned
from, start and goal given.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from frame import Benchmark

import leadthrough as lt
from leadthrough.preprocess.resample import by_arc_length
from leadthrough_studies.comparison.methods import BEST_PEER, PeerPrimitive
from leadthrough_studies.demonstrator import Teaching, guide

SHOWN, TESTED = 8, 12  # reaches
REACH = np.array([[0.0, 0.0, 0.0], [0.3, 0.1, 0.25], [0.6, 0.0, 0.05]])  # m
TEACHING = Teaching(duration=3.98)  # s, 200 samples
ROWS = 100  # evenly spaced along each path
# In the order of preference; the settings of the comparison study.
PEERS = (BEST_PEER, PeerPrimitive(weights=50))


def benchmarks(*, quick: bool) -> Iterator[Benchmark]:  # noqa: ARG001 - all are quick
    """Rows of the choice of a family, of its fit and of a query."""
    rng = np.random.default_rng(0)
    every = [guide(REACH, TEACHING, rng) for _ in range(SHOWN + TESTED)]
    shown, tested = every[:SHOWN], every[SHOWN:]

    def worse(ours: Any, peer: Any) -> float:
        return _error(ours, tested) / _error(peer, tested)

    problem = f"{SHOWN} demonstrations of {len(shown[0].motion.times)} samples"
    yield Benchmark(
        f"lt.learn: {problem}, four families; the peer's two",
        ours=lambda: lt.learn(_anew(shown)),
        peer=lambda: _chosen(shown),
        peer_name="movement_primitives",
        error=worse,
        tolerance=1.0,
    )
    model = lt.AlignedMean()
    yield Benchmark(
        f"AlignedMean: fit of {problem}; the peer's ProMP",
        ours=lambda: model.fit(_anew(shown)),
        peer=lambda: BEST_PEER.fit(shown),
        peer_name="movement_primitives",
        error=worse,
        tolerance=1.0,
    )
    skill, peer = model.fit(shown), BEST_PEER.fit(shown)
    yield Benchmark(
        f"AlignedMean: {TESTED} motions between new ends; the peer's ProMP",
        ours=lambda: _between(skill, tested),
        peer=lambda: _between(peer, tested),
        peer_name="movement_primitives",
        error=lambda a, b: _distance(a, tested) / _distance(b, tested),
        tolerance=1.0,
    )


def _anew(shown: Sequence[Any]) -> list[Any]:
    """Motions that are not known from the run before, whose smoothed paths are kept."""
    return [copy.copy(each.motion) for each in shown]


def _chosen(shown: Sequence[Any]) -> Any:
    """The peer's family with the least error on demonstrations left out in turn, fitted to all."""

    def error(model: Any) -> float:
        rest = [[each for each in shown if each is not left_out] for left_out in shown]
        pairs = zip(rest, shown, strict=True)
        return math.fsum(_error(model.fit(own), [left_out]) for own, left_out in pairs)

    return min(PEERS, key=error).fit(shown)


def _between(skill: Any, tested: Sequence[Any]) -> list[Any]:
    """A skill's motions from the starts to the goals of demonstrations."""
    paths = [each.motion.positions for each in tested]
    return [skill.generate(start=each[0], goal=each[-1]) for each in paths]


def _error(skill: Any, tested: Sequence[Any]) -> float:
    return _distance(_between(skill, tested), tested)


def _distance(made: Sequence[Any], tested: Sequence[Any]) -> float:
    """Mean distance of evenly spaced rows of motions and demonstrations."""
    pairs = [
        by_arc_length(each.positions, ROWS) - by_arc_length(shown.motion.positions, ROWS)
        for each, shown in zip(made, tested, strict=True)
    ]
    return float(np.linalg.norm(pairs, axis=2).mean())

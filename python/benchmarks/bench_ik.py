"""Inverse kinematics of single poses of three robots against peers, call by call.

The targets are poses of random configurations within the joint limits. The seeds are random too,
and all solvers get the same targets and seeds. Pinocchio's kinematics of the same URDF judge every
answer, joint limits included. We must solve 99.95 % of the poses; the row's name has the peer's
percentage. Times are medians and 99th percentiles over the calls. Ours solve to 1e-6 m and rad, the
peers to 1e-5.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from frame import Benchmark
from judge import Judge, quaternion, random_configurations, urdf_of
from peers import TRAC_IK_TOLERANCE, Solve, eaik, ssik, toolbox, trac_ik

import leadthrough as lt

TOLERANCE = 1e-5  # m and rad: what counts as solved
MAX_UNSOLVED = 5e-4
SAME = 1e-4  # rad, between configurations


def benchmarks(*, quick: bool) -> Iterator[Benchmark]:
    """Rows for every robot and peer."""
    count = 200 if quick else 5000
    for name in ("panda",) if quick else ("panda", "ur3", "tiago"):
        arm, urdf = lt.Arm.load(name), urdf_of(name)
        yield from _rows(name, arm, Judge(arm, urdf), urdf, count)
    yield from _all_configurations(count)


def _rows(name: str, arm: lt.Arm, judge: Judge, urdf: Path, count: int) -> Iterator[Benchmark]:
    targets = [judge.pose(q) for q in random_configurations(arm, count, seed=2)]
    seeds = random_configurations(arm, count, seed=3)
    poses = [(target.translation.copy(), quaternion(target)) for target in targets]

    def ours(call: int) -> Any:
        return arm.inverse_kinematics(*poses[call], q0=seeds[call]).q

    peers = {
        "roboticstoolbox-python": (toolbox(arm, urdf), TOLERANCE),
        "pytracik": (trac_ik(arm, urdf), TRAC_IK_TOLERANCE),
    }
    for peer_name, (solve, peer_tolerance) in peers.items():
        few = range(min(count, 500))  # enough for the percentage in the name
        solved = judge.percent_solved(
            targets[: len(few)],
            [solve(targets[i], seeds[i]) for i in few],
            tolerance=peer_tolerance,
        )
        yield Benchmark(
            f"{name}: {count} poses, peer solves {solved}",
            ours=ours,
            peer=partial(_call, solve, targets, seeds),
            peer_name=peer_name,
            error=lambda answers, _: 1.0 - judge.solved(targets, answers, tolerance=TOLERANCE),
            tolerance=MAX_UNSOLVED,
            calls=count,
        )


def _all_configurations(count: int) -> Iterator[Benchmark]:
    """Ours are inside the limits, by the turns nearest to a posture; EAIK's are as they come.

    The error is the fraction of the peer's configurations, as far as its own kinematics confirm
    them, that ours lack.
    """
    arm, urdf = lt.Arm.load("ur3"), urdf_of("ur3")
    shown = random_configurations(arm, count, seed=2)
    poses = [arm.forward_kinematics(q) for q in shown]
    closed, written = eaik(urdf), ssik(arm, urdf)

    def nearest(target: Any, q0: Any) -> list[Any]:
        found = written["solve"](target, q_seed=q0, enumerate_windings=False)
        return [solution.q for solution in found]

    peers: dict[str, tuple[Callable[..., Any], Callable[..., Any]]] = {
        "EAIK": (closed.fwdKin, lambda target, _: closed.IK(target).Q),
        "ssik": (written["fk"], nearest),
    }
    for name, (forward, solve) in peers.items():
        targets = [forward(q) for q in shown]
        yield Benchmark(
            f"ur3: all configurations of {count} poses",
            ours=lambda call: arm.inverse_kinematics_all(*poses[call], q0=shown[call - 1]),
            peer=partial(_call, solve, targets, np.roll(shown, 1, axis=0)),
            peer_name=name,
            error=partial(_missed, forward, targets),
            tolerance=0.0,
            calls=count,
        )


def _missed(
    forward: Callable[..., Any],
    targets: Sequence[Any],
    ours: Sequence[lt.IkSolutions],
    peers: Sequence[Any],
) -> float:
    missing = 0
    for own, found, target in zip(ours, peers, targets, strict=True):
        for q in found:
            apart = np.abs(np.remainder(own.q - q + np.pi, 2.0 * np.pi) - np.pi).max(axis=1)
            real = np.abs(forward(q) - target).max() < TOLERANCE
            missing += real and apart.min(initial=np.inf) > SAME
    return missing / len(targets)


def _call(solve: Solve, targets: Sequence[Any], seeds: Any, call: int) -> Any:
    return solve(targets[call], seeds[call])

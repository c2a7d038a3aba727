"""Forward kinematics of arms against Pinocchio, robot by robot."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pinocchio as pin
from frame import Benchmark
from judge import Judge, random_configurations, urdf_of

import leadthrough as lt

KINEMATICS_TOLERANCE = 1e-12  # m and rad


def benchmarks(*, quick: bool) -> Iterator[Benchmark]:
    """Rows for every robot."""
    count = 100 if quick else 500
    for name in ("panda",) if quick else ("panda", "ur3", "tiago"):
        arm = lt.Arm.load(name)
        judge = Judge(arm, urdf_of(name))
        yield from _kinematics(name, arm, judge, count)


def _kinematics(name: str, arm: lt.Arm, judge: Judge, count: int) -> Iterator[Benchmark]:
    q = random_configurations(arm, count, seed=1)
    full = [judge.configuration(row) for row in q]

    def peer() -> Any:
        poses = np.empty((count, 3))
        for i, row in enumerate(full):
            pin.framesForwardKinematics(judge.model, judge.data, row)
            poses[i] = judge.data.oMf[judge.tip].translation
        return poses

    offset = (
        judge.pose(q[0]).translation - peer()[0]
    )  # the base is shifted in the URDF, but never rotated
    ways = {
        "batch": lambda: arm.forward_kinematics(q)[0],
        "one by one": lambda: np.array([arm.forward_kinematics(row)[0] for row in q]),
    }
    for way, ours in ways.items():
        yield Benchmark(
            f"{name}: kinematics of {count} configurations, {way}",
            ours=ours,
            peer=peer,
            peer_name="pin",
            error=lambda a, b: float(np.abs(a - b - offset).max()),
            tolerance=KINEMATICS_TOLERANCE,
        )

"""The arm against its peers: forward kinematics and single poses; robot by robot.

Every answer of ours is judged by Pinocchio's kinematics of the same URDF. Poses are random and the
same for all, as are the seeds; the peers' share of solved ones stands in the row's name, by the
same judge. Ours solve to 1e-6 m and rad, the peers to 1e-5.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import roboticstoolbox as rtb
from frame import Benchmark
from trac_ik import TracIK

import leadthrough as lt
from leadthrough.arm.robots import find_robot

PEER_TOLERANCE = 1e-5  # m and rad
TOLERANCE = 2.0 * PEER_TOLERANCE  # TRAC-IK's holds for each axis
KINEMATICS_TOLERANCE = 1e-12  # m and rad
TRAC_IK_TIMEOUT = 0.005  # s of wall clock, its default

Solve = Callable[[Any, Any], Any]  # target (pin.SE3) and seed to q or None


def benchmarks(*, quick: bool) -> Iterator[Benchmark]:
    """Rows of every robot."""
    count = 100 if quick else 500
    for name in ("panda",) if quick else ("panda", "ur3", "tiago"):
        arm, urdf = lt.Arm.load(name), find_robot(name) / f"{name}.urdf"
        judge = Judge(arm, urdf)
        yield from _kinematics(name, arm, judge, count)
        yield from _single_poses(name, arm, judge, urdf, count)


class Judge:
    """Pinocchio's kinematics of a robot in which nothing but the arm moves."""

    def __init__(self, arm: lt.Arm, urdf: Path) -> None:
        self.limits = arm.limits
        self.model = pin.buildModelFromUrdf(str(urdf))
        self.data = self.model.createData()
        self.base, self.tip = (self.model.getFrameId(name) for name in (arm.base, arm.tip))

    def pose(self, q: Any) -> Any:
        pin.framesForwardKinematics(self.model, self.data, self.configuration(q))
        return self.data.oMf[self.base].actInv(self.data.oMf[self.tip])

    def configuration(self, q: Any) -> Any:
        """Pinocchio's: a joint without limits is a point on the circle."""
        full = pin.neutral(self.model)
        for joint, value in zip(list(self.model.joints)[1:], q, strict=True):
            whole = value if joint.nq == 1 else (np.cos(value), np.sin(value))
            full[joint.idx_q : joint.idx_q + joint.nq] = whole
        return full

    def error(self, q: Any, target: Any) -> float:
        """The larger of m and rad away from the target; inf outside the limits."""
        if q is None or (q < self.limits.lower).any() or (q > self.limits.upper).any():
            return np.inf
        offset = self.pose(q).actInv(target)
        turn = np.linalg.norm(pin.log3(offset.rotation))
        return float(max(np.linalg.norm(offset.translation), turn))

    def worst(self, targets: Sequence[Any], answers: Any, _peers: Any = None) -> float:
        return max(self.error(q, target) for q, target in zip(answers, targets, strict=True))

    def share(self, targets: Sequence[Any], answers: Any) -> str:
        errors = [self.error(q, target) for q, target in zip(answers, targets, strict=True)]
        return f"{100 * np.mean(np.array(errors) < TOLERANCE):.1f} %"


def _kinematics(name: str, arm: lt.Arm, judge: Judge, count: int) -> Iterator[Benchmark]:
    q = _random(arm, count, seed=1)
    full = [judge.configuration(row) for row in q]

    def peer() -> Any:
        poses = np.empty((count, 3))
        for i, row in enumerate(full):
            pin.framesForwardKinematics(judge.model, judge.data, row)
            poses[i] = judge.data.oMf[judge.tip].translation
        return poses

    offset = judge.pose(q[0]).translation - peer()[0]  # the base's place; no robot's is turned
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


def _single_poses(
    name: str, arm: lt.Arm, judge: Judge, urdf: Path, count: int
) -> Iterator[Benchmark]:
    targets = [judge.pose(q) for q in _random(arm, count, seed=2)]
    seeds = _random(arm, count, seed=3)
    poses = [(target.translation.copy(), quaternion(target)) for target in targets]
    peers = {
        "roboticstoolbox-python": _toolbox(arm, urdf),
        "pytracik": trac_ik(arm, urdf),
    }
    for peer_name, solve in peers.items():
        peer = partial(_each, solve, targets, seeds)
        yield Benchmark(
            f"{name}: {count} poses, peer solves {judge.share(targets, peer())}",
            ours=lambda: [
                arm.inverse_kinematics(*pose, seed=seed).q
                for pose, seed in zip(poses, seeds, strict=True)
            ],
            peer=peer,
            peer_name=peer_name,
            error=partial(judge.worst, targets),
            tolerance=TOLERANCE,
        )


def _each(solve: Solve, targets: Sequence[Any], seeds: Any) -> list[Any]:
    return [solve(target, seed) for target, seed in zip(targets, seeds, strict=True)]


def _toolbox(arm: lt.Arm, urdf: Path) -> Solve:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        chain = rtb.ERobot.URDF(str(urdf)).ets(start=arm.base, end=arm.tip)
    residual = 0.5 * PEER_TOLERANCE**2  # its measure is half the squared error

    def solve(target: Any, seed: Any) -> Any:
        solution = chain.ik_LM(target.homogeneous, q0=seed, tol=residual)
        return solution.q if solution.success else None

    return solve


def trac_ik(arm: lt.Arm, urdf: Path) -> Solve:
    solver = TracIK(arm.base, arm.tip, urdf, timeout=TRAC_IK_TIMEOUT, epsilon=PEER_TOLERANCE)
    return lambda target, seed: solver.ik(target.translation, target.rotation, seed)


def ranges(arm: lt.Arm) -> tuple[Any, Any]:
    return np.maximum(arm.limits.lower, -np.pi), np.minimum(arm.limits.upper, np.pi)


def _random(arm: lt.Arm, count: int, *, seed: int) -> Any:
    lower, upper = ranges(arm)
    return np.random.default_rng(seed).uniform(lower, upper, (count, len(lower)))


def quaternion(pose: Any) -> Any:
    x, y, z, w = pin.Quaternion(pose.rotation).coeffs()
    return np.array([w, x, y, z])

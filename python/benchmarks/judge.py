"""Pinocchio as the judge of an arm's answers, and the random configurations to ask for."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

import leadthrough as lt

ROBOTS = Path(__file__).parents[2] / "robots"


def urdf_of(robot: str) -> Path:
    """The URDF of one of the robots in this repository."""
    return ROBOTS / robot / f"{robot}.urdf"


class Judge:
    """Pinocchio's kinematics of a robot in which only the joints of the arm move."""

    def __init__(self, arm: lt.Arm, urdf: Path) -> None:
        self.limits = arm.limits
        self.model = pin.buildModelFromUrdf(str(urdf))
        self.data = self.model.createData()
        self.base, self.tip = (self.model.getFrameId(name) for name in (arm.base, arm.tip))

    def pose(self, q: Any) -> Any:
        """The pose of the tip in the arm's base frame (pin.SE3) for joint positions (n,)."""
        pin.framesForwardKinematics(self.model, self.data, self.configuration(q))
        return self.data.oMf[self.base].actInv(self.data.oMf[self.tip])

    def configuration(self, q: Any) -> Any:
        """Pinocchio's configuration vector, in which a joint without limits is (cos, sin)."""
        full = pin.neutral(self.model)
        for joint, value in zip(list(self.model.joints)[1:], q, strict=True):
            whole = value if joint.nq == 1 else (np.cos(value), np.sin(value))
            full[joint.idx_q : joint.idx_q + joint.nq] = whole
        return full

    def error(self, q: Any, target: Any) -> float:
        """The position (m) or orientation error (rad), the larger; inf outside the limits."""
        if q is None or (q < self.limits.lower).any() or (q > self.limits.upper).any():
            return np.inf
        offset = self.pose(q).actInv(target)
        turn = np.linalg.norm(pin.log3(offset.rotation))
        return float(max(np.linalg.norm(offset.translation), turn))

    def worst(self, targets: Sequence[Any], answers: Any, _peers: Any = None) -> float:
        """The largest error of all answers."""
        return max(self.error(q, target) for q, target in zip(answers, targets, strict=True))

    def solved(self, targets: Sequence[Any], answers: Any, *, tolerance: float) -> float:
        """The fraction of answers within a tolerance in m and rad."""
        errors = [self.error(q, target) for q, target in zip(answers, targets, strict=True)]
        return float(np.mean(np.array(errors) < tolerance))

    def percent_solved(self, targets: Sequence[Any], answers: Any, *, tolerance: float) -> str:
        """The fraction of answers within a tolerance, as text in percent."""
        return f"{100 * self.solved(targets, answers, tolerance=tolerance):.1f} %"


def ranges(arm: lt.Arm) -> tuple[Any, Any]:
    """Lower and upper joint limits, cut to one turn about zero."""
    return np.maximum(arm.limits.lower, -np.pi), np.minimum(arm.limits.upper, np.pi)


def random_configurations(arm: lt.Arm, count: int, *, seed: int) -> Any:
    """Joint positions (count, n), uniformly distributed within `ranges`."""
    lower, upper = ranges(arm)
    return np.random.default_rng(seed).uniform(lower, upper, (count, len(lower)))


def quaternion(pose: Any) -> Any:
    """The orientation of a pin.SE3 as w, x, y, z."""
    x, y, z, w = pin.Quaternion(pose.rotation).coeffs()
    return np.array([w, x, y, z])

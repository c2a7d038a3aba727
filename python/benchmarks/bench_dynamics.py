"""Jacobians, their derivative in time and torques of many configurations, against Pinocchio.

Pinocchio has no batches in Python: it is called configuration by configuration, with its own inputs
prepared beforehand.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pinocchio as pin
from frame import Benchmark

import leadthrough as lt
from leadthrough.arm.robots import find_robot

TOLERANCE = 1e-10  # m, rad, N m


def benchmarks(*, quick: bool) -> Iterator[Benchmark]:
    """Rows of every robot."""
    count = 500 if quick else 5000
    for name in ("panda",) if quick else ("panda", "ur3", "tiago"):
        arm = lt.Arm.load(name)
        peer = Peer(name, arm)
        q, qd, qdd = np.random.default_rng(1).uniform(-1.5, 1.5, (3, count, len(arm.joint_names)))
        full = [peer.configuration(row) for row in q]
        pairs: dict[str, tuple[Callable[[], Any], Callable[[], Any]]] = {
            "Jacobians": (
                lambda arm=arm, q=q: arm.jacobian(q),
                lambda peer=peer, full=full: [peer.jacobian(row) for row in full],
            ),
            "Jacobian derivatives": (
                lambda arm=arm, q=q, qd=qd: arm.jacobian_derivative(q, qd),
                lambda peer=peer, full=full, qd=qd: list(map(peer.derivative, full, qd)),
            ),
            "inverse dynamics": (
                lambda arm=arm, q=q, qd=qd, qdd=qdd: arm.inverse_dynamics(q, qd, qdd),
                lambda peer=peer, full=full, qd=qd, qdd=qdd: list(map(peer.torques, full, qd, qdd)),
            ),
            "mass matrices": (
                lambda arm=arm, q=q: np.triu(arm.mass_matrix(q)),
                lambda peer=peer, full=full: [peer.mass_matrix(row) for row in full],
            ),
        }
        for what, (ours, theirs) in pairs.items():
            yield Benchmark(
                f"{name}: {what} of {count} configurations",
                ours=ours,
                peer=theirs,
                peer_name="pin",
                error=lambda a, b: float(np.abs(a - np.array(b)).max()),
                tolerance=TOLERANCE,
            )


class Peer:
    """Pinocchio's model of a robot in which nothing but the arm moves; no base is turned."""

    def __init__(self, name: str, arm: lt.Arm) -> None:
        self.model = pin.buildModelFromUrdf(str(find_robot(name) / f"{name}.urdf"))
        self.data = self.model.createData()
        self.tip = self.model.getFrameId(arm.tip)

    def configuration(self, q: Any) -> Any:
        """Pinocchio's: a joint without limits is a point on the circle."""
        full = pin.neutral(self.model)
        for joint, value in zip(list(self.model.joints)[1:], q, strict=True):
            whole = value if joint.nq == 1 else (np.cos(value), np.sin(value))
            full[joint.idx_q : joint.idx_q + joint.nq] = whole
        return full

    def jacobian(self, q: Any) -> Any:
        return pin.computeFrameJacobian(self.model, self.data, q, self.tip, pin.LOCAL_WORLD_ALIGNED)

    def derivative(self, q: Any, qd: Any) -> Any:
        pin.computeJointJacobiansTimeVariation(self.model, self.data, q, qd)
        pin.updateFramePlacement(self.model, self.data, self.tip)
        return pin.getFrameJacobianTimeVariation(
            self.model, self.data, self.tip, pin.LOCAL_WORLD_ALIGNED
        )

    def torques(self, q: Any, qd: Any, qdd: Any) -> Any:
        return pin.rnea(self.model, self.data, q, qd, qdd).copy()

    def mass_matrix(self, q: Any) -> Any:
        return np.triu(pin.crba(self.model, self.data, q))  # the rest is not computed

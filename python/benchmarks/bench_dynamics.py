"""Jacobians, their time derivatives and torques of many configurations, against Pinocchio.

Pinocchio has no batches in Python: it is called once per configuration, with its inputs prepared
beforehand.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pinocchio as pin
from frame import Benchmark
from judge import Judge, urdf_of

import leadthrough as lt

TOLERANCE = 1e-10  # m, rad, N m


def benchmarks(*, quick: bool) -> Iterator[Benchmark]:
    """Rows for every robot."""
    count = 500 if quick else 5000
    for name in ("panda",) if quick else ("panda", "ur3", "tiago"):
        arm = lt.Arm.load(name)
        peer = Peer(arm, urdf_of(name))
        q, qd, qdd = np.random.default_rng(1).uniform(-1.5, 1.5, (3, count, len(arm.joint_names)))
        full = [peer.configuration(row) for row in q]
        pairs: dict[str, tuple[Callable[[], Any], Callable[[], Any]]] = {
            "Jacobians": (
                lambda arm=arm, q=q: arm.jacobian(q),
                lambda peer=peer, full=full: [peer.jacobian(row) for row in full],
            ),
            "Jacobians one by one": (
                lambda arm=arm, q=q: [arm.jacobian(row) for row in q],
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
                error=lambda a, b: float(np.abs(np.array(a) - np.array(b)).max()),
                tolerance=TOLERANCE,
            )


class Peer(Judge):
    """Pinocchio's derivatives and dynamics, in the world frame: no robot's base is rotated."""

    def jacobian(self, q: Any) -> Any:
        """The Jacobian (6, n) of the tip, linear rows first."""
        return pin.computeFrameJacobian(self.model, self.data, q, self.tip, pin.LOCAL_WORLD_ALIGNED)

    def derivative(self, q: Any, qd: Any) -> Any:
        """The time derivative (6, n) of the Jacobian."""
        pin.computeJointJacobiansTimeVariation(self.model, self.data, q, qd)
        pin.updateFramePlacement(self.model, self.data, self.tip)
        return pin.getFrameJacobianTimeVariation(
            self.model, self.data, self.tip, pin.LOCAL_WORLD_ALIGNED
        )

    def torques(self, q: Any, qd: Any, qdd: Any) -> Any:
        """Joint torques (n,)."""
        return pin.rnea(self.model, self.data, q, qd, qdd).copy()

    def mass_matrix(self, q: Any) -> Any:
        """The upper triangle (n, n) of the mass matrix, which is all that is computed."""
        return np.triu(pin.crba(self.model, self.data, q))

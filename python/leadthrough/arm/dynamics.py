"""Torques and mass matrices, of one configuration or of many at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import _core, check
from leadthrough.arm.definition import ArmDefinition
from leadthrough.arm.joint_rows import finite, joint_rows
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidRobot

# m/s^2, down in a base frame whose z axis points up.
GRAVITY = (0.0, 0.0, -9.81)


class ArmDynamics(ArmDefinition):
    """The methods of an `Arm` that need its masses."""

    def inverse_dynamics(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, *, gravity: ArrayLike = GRAVITY
    ) -> Float64Array:
        """Joint torques in N m (forces in N for prismatic joints) that produce a motion.

        The model has the links that the arm moves, those on side branches fixed to them, and the
        payloads. It has no friction, no motor inertia and nothing that hangs from joints outside
        the arm, unless these are held.

        Args:
            q: configuration (joints,) or a batch (m, joints).
            qd: joint velocities, shape of q, rad/s (m/s).
            qdd: joint accelerations, shape of q, rad/s^2 (m/s^2).
            gravity: acceleration (3,) of gravity in the base frame, m/s^2.

        Returns:
            (joints,), or (m, joints) for a batch.

        Raises:
            InvalidInput: if the shapes differ, or a number is not finite or too large.
            InvalidRobot: if the URDF states no masses.
        """
        _require_masses(self._chain)
        batch, rows = joint_rows(self._chain, q=q, qd=qd, qdd=qdd)
        pull = check.array(gravity, "gravity", shape=(3,))
        torques = finite(_core.inverse_dynamics(self._chain, rows[0], rows[1], rows[2], pull))
        return torques if batch else torques[0]

    def gravity_torques(self, q: ArrayLike, *, gravity: ArrayLike = GRAVITY) -> Float64Array:
        """Joint torques in N m (N) that hold the arm still against gravity.

        Args:
            q: configuration (joints,) or a batch (m, joints).
            gravity: acceleration (3,) of gravity in the base frame, m/s^2.

        Returns:
            (joints,), or (m, joints) for a batch; of the links as in `inverse_dynamics`.

        Raises:
            InvalidInput: if q has another shape, or a number is not finite or too large.
            InvalidRobot: if the URDF states no masses.
        """
        batch, (rows,) = joint_rows(self._chain, q=q)
        still = np.zeros_like(rows)
        torques = self.inverse_dynamics(rows, still, still, gravity=gravity)
        return torques if batch else torques[0]

    def mass_matrix(self, q: ArrayLike) -> Float64Array:
        """Joint-space mass matrix M: M qdd is the torque that the accelerations qdd need.

        Args:
            q: configuration (joints,) or a batch (m, joints).

        Returns:
            (joints, joints), or (m, joints, joints) for a batch; of the links as in
            `inverse_dynamics`.

        Raises:
            InvalidInput: if q has another shape, or a number is not finite or too large.
            InvalidRobot: if the URDF states no masses.
        """
        _require_masses(self._chain)
        batch, (rows,) = joint_rows(self._chain, q=q)
        shape = (len(rows), self._chain.joints, self._chain.joints)
        matrices = finite(_core.mass_matrix(self._chain, rows)).reshape(shape)
        return matrices if batch else matrices[0]


def _require_masses(chain: _core.Chain) -> None:
    if chain.mass == 0.0:
        raise InvalidRobot(
            "robot", "no link that the arm moves has a mass: its URDF states no <inertial>"
        )

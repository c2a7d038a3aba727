"""Torques and mass matrices, of one configuration or of many at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import _core, check
from leadthrough.arm.kinematics import finite, joint_rows
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidRobot

# m/s^2, down in a base frame whose z axis points up.
GRAVITY = (0.0, 0.0, -9.81)


def inverse_dynamics(
    chain: _core.Chain, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, gravity: ArrayLike
) -> Float64Array:
    """See `Arm.inverse_dynamics`."""
    _require_masses(chain)
    batch, rows = joint_rows(chain, q=q, qd=qd, qdd=qdd)
    pull = check.array(gravity, "gravity", shape=(3,))
    torques = finite(_core.inverse_dynamics(chain, rows[0], rows[1], rows[2], pull))
    return torques if batch else torques[0]


def gravity_torques(chain: _core.Chain, q: ArrayLike, gravity: ArrayLike) -> Float64Array:
    """See `Arm.gravity_torques`."""
    batch, (rows,) = joint_rows(chain, q=q)
    still = np.zeros_like(rows)
    torques = inverse_dynamics(chain, rows, still, still, gravity)
    return torques if batch else torques[0]


def mass_matrix(chain: _core.Chain, q: ArrayLike) -> Float64Array:
    """See `Arm.mass_matrix`."""
    _require_masses(chain)
    batch, (rows,) = joint_rows(chain, q=q)
    shape = (len(rows), chain.joints, chain.joints)
    matrices = finite(_core.mass_matrix(chain, rows)).reshape(shape)
    return matrices if batch else matrices[0]


def _require_masses(chain: _core.Chain) -> None:
    if chain.mass == 0.0:
        raise InvalidRobot(
            "robot", "no link that the arm moves has a mass: its URDF states no <inertial>"
        )

"""Faults in a plan that a simulation should find.

Each fault is one that matters: an obstacle that the arm touches by an exact collision check, and
torque limits below what the motion needs by inverse dynamics. A motion that needs less than half of
the torque is no fault of an arm with half of it, so that one has drives with half of what the
motion needs as well.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from leadthrough.arm import Arm, JointLimits
from leadthrough.check import Float64Array
from leadthrough.errors import LeadthroughError
from leadthrough.shapes import Sphere
from leadthrough.simulation import Disturbances, SimulationReport, simulate
from leadthrough_studies.simulation.motions import Given, faster_limits, timed

_RADII = (0.05, 0.03, 0.015, 0.008)  # m, of the obstacle; the first that fits
_DEEP = 2e-3  # m, by which the arm enters it
_PLACES = (1.0, 0.8, 0.6, 0.4)  # fractions of the motion's way
_FASTER = 10.0

HALF, HALF_NEEDED = "torque limit halved", "torque limit half of what is needed"
PAYLOAD, OBSTACLE, LIMITS = "payload tripled", "obstacle missing", "limits ten times too high"
FAULTS = (HALF, HALF_NEEDED, PAYLOAD, OBSTACLE, LIMITS)


def faulty(given: Given) -> Iterator[tuple[str, SimulationReport | None]]:
    """Each fault, with what the simulation shows; None where it would be none.

    Args:
        given: a sound motion.
    """
    arm, joints = given.arm, given.joints
    assert arm.limits.effort is not None
    needed = _needed(given)
    half = 0.5 * arm.limits.effort
    yield HALF, simulate(_weaker(arm, half), joints) if (needed > half).any() else None
    yield HALF_NEEDED, simulate(_weaker(arm, np.minimum(0.5 * needed, half)), joints)
    yield PAYLOAD, simulate(arm, joints, disturbances=Disturbances(payload=3.0))
    obstacle = _missed(given)
    yield OBSTACLE, None if obstacle is None else simulate(arm, joints, [obstacle])
    yield LIMITS, _hurried(given)


def _needed(given: Given) -> Float64Array:
    """The largest torque of each joint (joints,) that the motion needs, N m."""
    joints = given.joints
    assert joints.velocities is not None
    assert joints.accelerations is not None
    torques = given.arm.inverse_dynamics(joints.positions, joints.velocities, joints.accelerations)
    return np.asarray(np.abs(torques).max(axis=0))


def _weaker(arm: Arm, effort: Float64Array) -> Arm:
    """The same arm with other torque limits."""
    return replace(arm, limits=JointLimits(**(vars(arm.limits) | {"effort": effort})))


def _missed(given: Given) -> Sphere | None:
    """A ball on the tip's way that the arm enters, and does not touch at the start."""
    arm, rows = given.arm, given.joints.positions
    tip, _ = arm.forward_kinematics(rows)
    away = np.linalg.norm(tip - tip[0], axis=1)
    some = rows[:: max(1, len(rows) // 200)]
    for radius in _RADII:
        for part in _PLACES:
            place = tip[int(np.argmax(away >= part * away.max()))]
            ball = Sphere(radius, place)
            gaps = np.asarray(arm.distance(some, [ball]))
            if gaps[0] > _DEEP and gaps.min() < -_DEEP:
                return ball
    return None


def _hurried(given: Given) -> SimulationReport | None:
    """The motion timed with a limits file ten times too high, on the arm as it is."""
    arm = given.arm
    try:
        wrong = replace(arm, limits=faster_limits(arm, _FASTER))
        return simulate(wrong, timed(arm, given.path, faster=_FASTER))
    except LeadthroughError:
        return None

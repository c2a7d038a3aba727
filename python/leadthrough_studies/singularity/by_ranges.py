"""Equations 3 to 7 of Yang, Liu and Pears with a secondary task that counts in joint ranges.

The paper minimises "the deviation of each joint's angle from the midpoint of its motion range". In
radians, as in the module `damped_least_squares`, a joint with a wide range pulls as hard as
one with a narrow range. Here the deviations are fractions of the ranges: the pull is

    qdot_i = gain (middle_i - q_i) mean(range^2) / range_i^2,

steepest descent of the sum of squared fractions, in the unit of the plain one.
"""

from __future__ import annotations

import numpy as np

from leadthrough import rotations
from leadthrough.arm import Arm
from leadthrough.check import Float64Array
from leadthrough.motion import JointTrajectory, PoseTrajectory
from leadthrough_studies.damped_least_squares import DampedLeastSquares


def follow_by_ranges(
    arm: Arm,
    way: PoseTrajectory,
    start: Float64Array,
    settings: DampedLeastSquares,
    *,
    scaled: bool = True,
) -> JointTrajectory:
    """One step per sample along a motion, as `damped_least_squares.follow_path`.

    Args:
        arm: the arm; its Jacobian keeps all its directions along the motion.
        way: poses.
        start: configuration (joints,) where the first step begins.
        settings: those of the method.
        scaled: whether deviations count in joint ranges, or in rad as the plain task has them.
    """
    span = arm.limits.upper - arm.limits.lower
    stiffness = np.mean(span**2) / span**2 if scaled else np.ones_like(span)
    middle = 0.5 * (arm.limits.upper + arm.limits.lower)
    steps = np.diff(way.times, prepend=2.0 * way.times[0] - way.times[1])
    q, found = np.array(start, dtype=np.float64), []
    for position, orientation, dt in zip(way.positions, way.orientations, steps, strict=True):
        twist = _offset(arm, q, position, orientation) / dt
        pull = settings.nullspace_gain * stiffness * (middle - q)
        velocity = _step(arm.jacobian(q), twist, pull, settings)
        q = np.clip(q + dt * velocity, arm.limits.lower, arm.limits.upper)
        found.append(q)
    return JointTrajectory(way.times, np.array(found), joint_names=arm.joint_names)


def _offset(
    arm: Arm, q: Float64Array, position: Float64Array, orientation: Float64Array
) -> Float64Array:
    """Remaining difference to a pose (6,), m and rad, in the base frame."""
    here, turned = arm.forward_kinematics(q)
    back = rotations.inverse(turned[None])
    left = rotations.log(rotations.compose(orientation[None], back))[0]
    return np.concatenate([position - here, left])


def _step(
    jacobian: Float64Array, twist: Float64Array, pull: Float64Array, settings: DampedLeastSquares
) -> Float64Array:
    """Equations 4 to 7 at one configuration."""
    weight = np.repeat([1.0, settings.rotation_weight], 3)
    weighted = weight[:, None] * jacobian
    values = np.linalg.svd(weighted, compute_uv=False)
    share = settings.condition_threshold * values[-1] / values[0]
    regular = settings.damping**2 * max(1.0 - share**2, 0.0) + settings.alpha
    square = weighted @ weighted.T + regular * np.eye(6)
    primary = weighted.T @ np.linalg.solve(square, weight * twist)
    inverse = np.linalg.pinv(weighted)
    return np.asarray(primary + pull - inverse @ (weighted @ pull))

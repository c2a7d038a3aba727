"""Two paths of a Panda's tool past singularities, and methods that compute the joints along them.

Yang, Liu and Pears draw their two approaches but do not state them; these are ours. Each path
passes through a posture close to a singularity, three quarters of the way along. There it runs in
the direction of tool motion (rotations weighted with 0.3 m per rad) that requires the fastest
joints. The motion goes from rest to rest in 4 s:

1. The wrist: the axes of joints 5 and 7 are nearly aligned, so that one turns against the other.
2. The shoulder: the axes of joints 1 and 3 are nearly aligned because joint 2 is near zero. It is
   a singularity of the whole arm, which no self-motion leaves.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from leadthrough import rotations
from leadthrough.arm import Arm, FollowOptions
from leadthrough.check import Float64Array
from leadthrough.motion import JointTrajectory, PoseTrajectory
from leadthrough.trajectories import minimum_jerk_time_scaling
from leadthrough_studies.damped_least_squares import DampedLeastSquares, follow_path
from leadthrough_studies.singularity.by_ranges import follow_by_ranges

ROTATION_WEIGHT = 0.3  # m per rad
_CLOSEST_AT = 0.75  # fraction of the path
_TRAVEL = 0.2  # m, or 0.2 / 0.3 rad
_DURATION = 4.0  # s
_RATE = 100.0  # Hz
# How far `follow` may deviate from the path.
DEVIATION = (0.02, 0.05)  # m, rad


@dataclass(frozen=True)
class Approach:
    """A path past a singularity.

    Attributes:
        title: the singularity.
        posture: joint positions close to the singularity, rad.
        joints: numbers (from 1) of the joints that the singularity affects most.
        paper: the paper's figures of its own approach, without its method ("plain") and with it
            ("damped"): percentage of samples below a condition number of 8 and of 10, and peak
            velocities of joints in rad/s.
    """

    title: str
    posture: tuple[float, ...]
    joints: tuple[int, ...]
    paper: dict[str, dict[str, float]]


APPROACHES = {
    1: Approach(
        "the wrist",
        (0.0, -0.4, 0.0, -2.2, 1.57, 0.05, 0.4),
        (7,),
        {
            "plain": {"below_8": 0.0, "below_10": 100.0, "joint_7": -1.0},
            "damped": {"below_8": 20.0, "below_10": 83.0, "joint_7": -0.8},
        },
    ),
    2: Approach(
        "the shoulder",
        (0.0, 0.02, 1.57, -1.8, 0.0, 1.6, 0.7),
        (4, 6, 7),
        {
            "plain": {"below_8": 0.0, "below_10": 72.0},
            "damped": {"below_8": 28.0, "below_10": 83.0, "joint_6": -0.6, "joint_7": -1.4},
        },
    ),
}


def motion(arm: Arm, approach: Approach) -> PoseTrajectory:
    """The motion of the tool through the posture: a straight line with a turn about one axis."""
    posture = np.array(approach.posture)
    direction = slowest_direction(arm, posture)
    position, orientation = arm.forward_kinematics(posture)
    times = np.arange(round(_DURATION * _RATE) + 1) / _RATE
    u = times / _DURATION
    along = _TRAVEL * (minimum_jerk_time_scaling(u) - _CLOSEST_AT)
    turned = rotations.exp(np.outer(along, direction[3:]))
    return PoseTrajectory(
        times,
        position + np.outer(along, direction[:3]),
        rotations.compose(turned, np.tile(orientation, (len(times), 1))),
    )


def slowest_direction(arm: Arm, q: Float64Array) -> Float64Array:
    """The twist that requires the fastest joints.

    Args:
        arm: the arm.
        q: joint positions (n,), rad.

    Returns:
        The twist (6,), m and rad, of length 1 with rotations weighted.
    """
    weights = np.repeat([1.0, ROTATION_WEIGHT], 3)
    left, _, _ = np.linalg.svd(weights[:, None] * arm.jacobian(q))
    direction = left[:, -1] / weights
    # The decomposition leaves the sign open. This sign turns joint 7 backwards, as in the paper.
    return np.asarray(-direction * np.sign(direction[np.argmax(np.abs(direction))]))


def start(arm: Arm, approach: Approach, way: PoseTrajectory) -> Float64Array:
    """The joint positions at the start of the motion that lead to the posture of the approach."""
    posture = np.array(approach.posture)
    before = np.linalg.norm(way.positions - arm.forward_kinematics(posture)[0], axis=1).argmin()
    back = PoseTrajectory(
        way.times[: before + 1],
        way.positions[before::-1],
        way.orientations[before::-1],
    )
    return np.array(
        arm.follow(back, q0=posture, options=FollowOptions(nullspace_gain=0.0)).positions[-1]
    )


def plain(arm: Arm, way: PoseTrajectory, q: Float64Array) -> JointTrajectory:
    """The joint motion by equation 2, the pseudo-inverse."""
    return damped(arm, way, q, damping=0.0, nullspace_gain=0.0)


def damped(arm: Arm, way: PoseTrajectory, q: Float64Array, **settings: Any) -> JointTrajectory:
    """The joint motion by equations 3 to 7."""
    return follow_path(arm, way, q0=q, settings=DampedLeastSquares(**settings)).joints


def damped_alone(arm: Arm, way: PoseTrajectory, q: Float64Array) -> JointTrajectory:
    """The joint motion by equation 5 without the secondary task."""
    return damped(arm, way, q, nullspace_gain=0.0)


def damped_by_ranges(arm: Arm, way: PoseTrajectory, q: Float64Array) -> JointTrajectory:
    """The joint motion by equations 3 to 7, the secondary task in fractions of joint ranges."""
    return follow_by_ranges(arm, way, q, DampedLeastSquares())


def slowed(arm: Arm, way: PoseTrajectory, q: Float64Array) -> JointTrajectory:
    """The joint motion by `Arm.follow`, which slows down where the joints would be too fast."""
    return arm.follow(way, q0=q, on_rate_limit="slow")


def deviating(arm: Arm, way: PoseTrajectory, q: Float64Array) -> JointTrajectory:
    """The joint motion by `Arm.follow`, which deviates where the joints would be too fast."""
    return arm.follow(way, q0=q, on_rate_limit="deviate", deviation=DEVIATION)


Method = Callable[[Arm, PoseTrajectory, Float64Array], JointTrajectory]

METHODS: dict[str, Method] = {
    "plain": plain,
    "damped alone": damped_alone,
    "damped": damped,
    "damped, by ranges": damped_by_ranges,
    "follow, slowing": slowed,
    "follow, deviating": deviating,
}

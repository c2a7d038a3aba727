"""The arm's own joints of a recording, and the poses that its tip went through."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import leadthrough._core as core
from leadthrough import rotations, sanity
from leadthrough.arm.limits import JointLimits
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.motion import (
    JointTrajectory,
    Motion,
    PoseTrajectory,
    Trajectory,
    columns_of,
    in_order,
    joints_with,
)

# A recorded joint this far beyond its limits, rad (m) and as a fraction of its range, is of another
# arm or in another unit; calibrations differ by less.
_BEYOND, _BEYOND_RANGE = 0.5, 0.25
# m: the mean motion of several demonstrations is less far from where the mean of their joints is.
_OTHER_TIP = 0.05


def joints_of(chain: core.Chain | JointLimits, trajectory: Motion) -> JointTrajectory:
    """See `Arm.joints_of`."""
    own = _own(chain, trajectory)
    if outside := _outside(chain, own):
        sanity.warn(outside)
    return own


def warn_of_another_arm(chain: core.Chain, motion: Motion) -> None:
    """Warns if the joints that go along with a demonstrated motion take the tip elsewhere."""
    joints = demonstrated_joints(chain, motion)
    if joints is None or not isinstance(motion, Trajectory | PoseTrajectory):
        return
    positions, _ = chain.forward_kinematics(joints.positions)
    if motion.positions.shape[1] != positions.shape[1]:
        return
    away = float(np.linalg.norm(positions - motion.positions, axis=1).max())
    if away > _OTHER_TIP:
        sanity.warn(
            f"robot: with the demonstrated joints, this arm's tip is up to {away:.3g} m from its "
            "demonstrated position; use the robot, base and tip of the recording"
        )


def _outside(chain: core.Chain | JointLimits, own: JointTrajectory) -> str | None:
    """Message about joints far beyond the arm's limits, if any are."""
    ends = np.array([own.positions.min(axis=0), own.positions.max(axis=0)])
    with np.errstate(invalid="ignore"):
        allowed = np.maximum(_BEYOND, _BEYOND_RANGE * (chain.upper - chain.lower))
        beyond = np.maximum(chain.lower - ends, ends - chain.upper)
    far = np.where(np.isfinite(allowed), beyond - allowed, -1.0)
    end, j = np.unravel_index(int(np.argmax(far)), far.shape)
    if far[end, j] <= 0.0:
        return None
    name, value = chain.joint_names[j], ends[end, j]
    return (
        f"trajectory: {name} goes to {value:.4g} rad (m), and its limits are {chain.lower[j]:.4g} "
        f"to {chain.upper[j]:.4g}; read a recording in degrees with angles='degrees', or name the "
        "robot that was recorded"
    )


def _own(chain: core.Chain | JointLimits, trajectory: Motion) -> JointTrajectory:
    names = tuple(chain.joint_names)
    own = in_order(_without_others(trajectory, names), names, "trajectory")
    unwrapped = _unwrapped(chain, own.positions)
    return own if unwrapped is own.positions else replace(own, positions=unwrapped)


def _without_others(trajectory: Motion, names: tuple[str, ...]) -> Motion:
    """The recording without joints that are not the arm's, such as a gripper's."""
    recorded: tuple[str, ...] = getattr(trajectory, "joint_names", ())
    # LeRobot's names of motors end in ".pos".
    own = [i for i, each in enumerate(recorded) if {each, each.removesuffix(".pos")} & set(names)]
    if not isinstance(trajectory, JointTrajectory) or not len(own) == len(names) < len(recorded):
        return trajectory
    return columns_of(trajectory, own, tuple(recorded[i] for i in own))


def reach_ends(
    chain: core.Chain,
    joints: JointTrajectory,
    motion: Trajectory | PoseTrajectory,
    allowed: tuple[float, float],
) -> bool:
    """Whether joints that go along with a motion are at its ends, within errors in m and rad."""
    positions, orientations = chain.forward_kinematics(joints.positions[[0, -1]])
    far = float(np.linalg.norm(positions - motion.positions[[0, -1]], axis=1).max())
    turned = 0.0
    if isinstance(motion, PoseTrajectory):
        turned = float(np.max(rotations.distance(orientations, motion.orientations[[0, -1]])))
    return far <= allowed[0] and turned <= allowed[1]


def demonstrated_joints(chain: core.Chain, motion: Motion) -> JointTrajectory | None:
    """The arm's own joints that go along with a motion of the tip."""
    joints = joints_with(motion)
    if joints is None:
        return None
    try:
        return _own(chain, joints)
    except InvalidInput:
        return None


def _unwrapped(chain: core.Chain | JointLimits, positions: Float64Array) -> Float64Array:
    """Joints (n, joints) without the leaps of whole turns that encoders make."""
    endless = ~(np.isfinite(chain.lower) & np.isfinite(chain.upper))
    leaps = endless & (np.abs(np.diff(positions, axis=0)) > np.pi).any(axis=0)
    leaps |= sanity.whole_turns(positions)
    if not leaps.any():
        return positions
    return np.where(leaps, np.unwrap(positions, axis=0), positions)


def poses(chain: core.Chain, trajectory: Motion) -> PoseTrajectory:
    """See `Arm.poses`."""
    own = _own(chain, trajectory)
    if outside := _outside(chain, own):
        raise InvalidInput(outside)
    positions, orientations = chain.forward_kinematics(own.positions)
    return PoseTrajectory(own.times, positions, orientations, own.events, own)

"""The arm's own joints of a recording, and the poses that its tip went through."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from leadthrough import _core
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.motion import JointTrajectory, Motion, PoseTrajectory, joints_with


def joints_of(chain: _core.Chain, trajectory: Motion) -> JointTrajectory:
    """See `Arm.joints_of`."""
    names = tuple(chain.joint_names)
    if not isinstance(trajectory, JointTrajectory):
        got = type(trajectory).__name__
        raise InvalidInput(f"trajectory: expected a JointTrajectory, got {got}")
    columns = _columns(trajectory, names)
    velocities, accelerations = (
        None if rows is None else rows[:, columns]
        for rows in (trajectory.velocities, trajectory.accelerations)
    )
    return replace(
        trajectory,
        positions=_unwrapped(chain, trajectory.positions[:, columns]),
        velocities=velocities,
        accelerations=accelerations,
        joint_names=names,
    )


def shown_joints(chain: _core.Chain, motion: Motion) -> JointTrajectory | None:
    """The arm's own joints that go along with a motion of the tip.

    None where there are none, or those of another arm.
    """
    shown = joints_with(motion)
    if shown is None:
        return None
    try:
        return joints_of(chain, shown)
    except InvalidInput:
        return None


def _unwrapped(chain: _core.Chain, positions: Float64Array) -> Float64Array:
    """Joints (n, joints) without the leaps of whole turns that encoders make.

    Only joints that turn without end can leap so.
    """
    endless = ~(np.isfinite(chain.lower) & np.isfinite(chain.upper))
    leaps = endless & (np.abs(np.diff(positions, axis=0)) > np.pi).any(axis=0)
    if not leaps.any():
        return positions
    return np.where(leaps, np.unwrap(positions, axis=0), positions)


def _columns(trajectory: JointTrajectory, names: tuple[str, ...]) -> list[int]:
    """Where the joints stand in the recording."""
    recorded = trajectory.joint_names
    if not recorded:
        count = trajectory.positions.shape[1]
        if count != len(names):
            raise InvalidInput(
                f"trajectory: expected {len(names)} joints where it names none, got {count}"
            )
        return list(range(count))
    if not set(names) <= set(recorded):
        # LeRobot's names of motors.
        recorded = tuple(name.removesuffix(".pos") for name in recorded)
    if not set(names) <= set(recorded):
        raise InvalidInput(
            f"trajectory: expected at least the joints {', '.join(names)}, "
            f"got {', '.join(trajectory.joint_names)}"
        )
    return [recorded.index(name) for name in names]


def poses(chain: _core.Chain, trajectory: Motion) -> PoseTrajectory:
    """See `Arm.poses`."""
    own = joints_of(chain, trajectory)
    positions, orientations = chain.forward_kinematics(own.positions)
    return PoseTrajectory(own.times, positions, orientations, own.events, own)

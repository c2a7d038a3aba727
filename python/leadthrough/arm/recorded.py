"""The arm's own joints of a recording, and the poses that its tip went through."""

from __future__ import annotations

from dataclasses import replace

from leadthrough import _core
from leadthrough.errors import InvalidInput
from leadthrough.motion import JointTrajectory, Motion, PoseTrajectory


def joints_of(trajectory: Motion, names: tuple[str, ...]) -> JointTrajectory:
    """See `Arm.joints_of`."""
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
        positions=trajectory.positions[:, columns],
        velocities=velocities,
        accelerations=accelerations,
        joint_names=names,
    )


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
        raise InvalidInput(
            f"trajectory: expected at least the joints {', '.join(names)}, "
            f"got {', '.join(recorded)}"
        )
    return [recorded.index(name) for name in names]


def poses(chain: _core.Chain, trajectory: Motion) -> PoseTrajectory:
    """See `Arm.poses`."""
    own = joints_of(trajectory, tuple(chain.joint_names))
    positions, orientations = chain.forward_kinematics(own.positions)
    return PoseTrajectory(own.times, positions, orientations, own.events)

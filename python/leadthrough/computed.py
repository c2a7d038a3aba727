"""Motions of arrays just computed: not checked or copied again, and read-only from then on."""

from __future__ import annotations

from leadthrough.check import Float64Array
from leadthrough.events import Events
from leadthrough.motion import JointTrajectory, MotionT


def computed(
    kind: type[MotionT],
    *,
    events: Events,
    joints: JointTrajectory | None = None,
    **arrays: Float64Array,
) -> MotionT:
    """A motion of arrays just computed, which are not checked or copied and become read-only."""
    motion = object.__new__(kind)
    for array in arrays.values():
        array.setflags(write=False)
    vars(motion).update(arrays, events=events, joints=joints)
    return motion


def computed_joints(
    times: Float64Array,
    positions: Float64Array,
    velocities: Float64Array,
    accelerations: Float64Array,
    *,
    joint_names: tuple[str, ...],
    events: Events = (),
) -> JointTrajectory:
    """Joints of arrays just computed, as `computed` makes motions of points and poses."""
    motion = object.__new__(JointTrajectory)
    arrays = {
        "times": times,
        "positions": positions,
        "velocities": velocities,
        "accelerations": accelerations,
    }
    for array in arrays.values():
        array.setflags(write=False)
    vars(motion).update(arrays, joint_names=joint_names, events=events)
    return motion

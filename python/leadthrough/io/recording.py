"""Recordings as they stand in files, faults included."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.events import Events
from leadthrough.motion import Demonstration, JointTrajectory, Motion, PoseTrajectory, Trajectory


@dataclass(frozen=True, eq=False)
class Recording:
    """One recorded motion with its faults, which `leadthrough.preprocess.clean` removes.

    Times, positions, orientations and derivatives may hold NaN and infinity.

    Attributes:
        times: (n,) s, in the order of the file.
        positions: (n, d) m, or joint positions in rad (m for prismatic joints).
        orientations: (n, 4) w, x, y, z, of any length and sign, or None.
        joint_names: None where the positions are not joints, empty where the joints have no names.
        velocities: (n, joints) rad/s, or None.
        accelerations: (n, joints) rad/s^2, or None.
        events: on the same clock.
        name: of the recording; for messages and demonstrations.

    Raises:
        InvalidInput: if an array is not numeric or its shape does not fit.
    """

    times: Float64Array
    positions: Float64Array
    orientations: Float64Array | None = None
    joint_names: tuple[str, ...] | None = None
    velocities: Float64Array | None = None
    accelerations: Float64Array | None = None
    events: Events = ()
    name: str = ""

    def __post_init__(self) -> None:
        count = len(check.with_gaps(self.times, "times", shape=("n",)))
        width: int | str = "d"
        for field in ("times", "positions", "orientations", "velocities", "accelerations"):
            value = getattr(self, field)
            if value is None and field not in ("times", "positions"):
                continue
            shape = {"times": (count,), "orientations": (count, 4)}.get(field, (count, width))
            array = check.with_gaps(value, field, shape=shape).copy()
            array.setflags(write=False)
            object.__setattr__(self, field, array)
            width = array.shape[1] if field == "positions" else width

    @property
    def kind(self) -> Literal["joints", "poses", "points"]:
        """What moves."""
        if self.joint_names is not None:
            return "joints"
        return "points" if self.orientations is None else "poses"

    def motion(self) -> Motion:
        """The recording as a motion, unchanged.

        Raises:
            InvalidInput: if anything is wrong with it; `leadthrough.preprocess.clean` repairs it.
        """
        if self.joint_names is not None:
            return JointTrajectory(
                self.times,
                self.positions,
                self.velocities,
                self.accelerations,
                self.joint_names,
                self.events,
            )
        if self.orientations is not None:
            return PoseTrajectory(self.times, self.positions, self.orientations, self.events)
        return Trajectory(self.times, self.positions, self.events)


def recording_of(demonstration: Demonstration) -> Recording:
    """The recording with a demonstration's motion and name."""
    motion = demonstration.motion
    if isinstance(motion, JointTrajectory):
        return Recording(
            motion.times,
            motion.positions,
            joint_names=motion.joint_names,
            velocities=motion.velocities,
            accelerations=motion.accelerations,
            events=motion.events,
            name=demonstration.name,
        )
    turned = motion.orientations if isinstance(motion, PoseTrajectory) else None
    return Recording(
        motion.times, motion.positions, turned, events=motion.events, name=demonstration.name
    )

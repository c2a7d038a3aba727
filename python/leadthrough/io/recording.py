"""Recordings as they stand in files, faults included."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import Float64Array, ShortRepr
from leadthrough.motion import (
    Demonstration,
    Event,
    Events,
    JointTrajectory,
    Motion,
    PoseTrajectory,
    Trajectory,
)


@dataclass(frozen=True, eq=False, init=False)
class Recording(ShortRepr):
    """One recorded motion with its faults, which `leadthrough.preprocess.clean` removes.

    Times, positions, orientations and derivatives may hold NaN and infinity.

    Attributes:
        times: (n,) s, in the order of the file.
        positions: (n, d) m, or joint positions in rad (m for prismatic joints).
        orientations: (n, 4) w, x, y, z, of any length and sign, or None.
        joint_names: None where the positions are not joints, empty where the joints have no names.
        velocities: (n, joints) rad/s, or None.
        accelerations: (n, joints) rad/s^2, or None.
        joints: of the arm whose tip moved so, n samples in the same order, or None.
        events: on the same clock.
        name: of the recording; for messages and demonstrations.
    """

    times: Float64Array
    positions: Float64Array
    orientations: Float64Array | None
    joint_names: tuple[str, ...] | None
    velocities: Float64Array | None
    accelerations: Float64Array | None
    joints: JointTrajectory | None
    events: Events
    name: str

    def __init__(
        self,
        times: ArrayLike,
        positions: ArrayLike,
        orientations: ArrayLike | None = None,
        *,
        joint_names: Sequence[str] | None = None,
        velocities: ArrayLike | None = None,
        accelerations: ArrayLike | None = None,
        joints: JointTrajectory | None = None,
        events: Sequence[Event] = (),
        name: str = "",
    ) -> None:
        clock = _frozen(times, "times", ("n",))
        rows = _frozen(positions, "positions", (len(clock), "d"))
        given = (
            ("orientations", orientations, (len(clock), 4)),
            ("velocities", velocities, rows.shape),
            ("accelerations", accelerations, rows.shape),
        )
        vars(self).update(
            {
                field: None if value is None else _frozen(value, field, shape)
                for field, value, shape in given
            },
            times=clock,
            positions=rows,
            joint_names=None if joint_names is None else tuple(joint_names),
            joints=joints,
            events=tuple(events),
            name=name,
        )

    @property
    def kind(self) -> Literal["joints", "poses", "points"]:
        """Kind of the positions."""
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
            rest = (self.orientations, self.events, self.joints)
            return PoseTrajectory(self.times, self.positions, *rest)
        return Trajectory(self.times, self.positions, self.events, self.joints)


def recording_of(demonstration: Demonstration) -> Recording:
    """The recording with a demonstration's motion and name."""
    motion = demonstration.motion
    optional = ("orientations", "joint_names", "velocities", "accelerations", "joints")
    return Recording(
        motion.times,
        motion.positions,
        **{name: getattr(motion, name, None) for name in optional},
        events=motion.events,
        name=demonstration.name,
    )


def _frozen(value: ArrayLike, name: str, shape: Sequence[int | str]) -> Float64Array:
    array = check.with_gaps(value, name, shape=shape).copy()
    array.setflags(write=False)
    return array

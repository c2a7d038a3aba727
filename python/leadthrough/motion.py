"""Motions and demonstrations: frozen, checked, with read-only copies of the data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Generic, TypeVar

import numpy as np

from leadthrough import check, events, rotations
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.events import Event, Events


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Timed points.

    times: (n,) s, strictly increasing. positions: (n, d) m (drawings may use any unit). events:
    what happens meanwhile, at any times between the first and the last; sorted on entry.
    """

    times: Float64Array
    positions: Float64Array
    events: tuple[Event, ...] = ()

    def __post_init__(self) -> None:
        _freeze_clock(self)
        _freeze_rows(self, "positions", len(self.times), "d")

    @property
    def duration(self) -> float:
        """Time from the first sample to the last, s."""
        return float(self.times[-1] - self.times[0])


@dataclass(frozen=True, eq=False)
class PoseTrajectory:
    """Timed poses in one frame.

    times: (n,) s, strictly increasing. positions: (n, 3) m. orientations: (n, 4) w, x, y, z;
    normalised and made sign-continuous on entry. events: as in `Trajectory`.
    """

    times: Float64Array
    positions: Float64Array
    orientations: Float64Array
    events: tuple[Event, ...] = ()

    def __post_init__(self) -> None:
        _freeze_clock(self)
        _freeze_rows(self, "positions", len(self.times), 3)
        quaternions = check.quaternions(
            self.orientations, "orientations", shape=(len(self.times), 4)
        )
        continuous = rotations.group.aligned(quaternions)
        continuous.setflags(write=False)
        object.__setattr__(self, "orientations", continuous)

    @property
    def duration(self) -> float:
        """Time from the first sample to the last, s."""
        return float(self.times[-1] - self.times[0])


@dataclass(frozen=True, eq=False)
class JointTrajectory:
    """Timed joint configurations.

    times: (n,) s, strictly increasing. positions, velocities, accelerations: (n, joints) in rad,
    rad/s, rad/s^2 (m for prismatic joints); the last two may be None. joint_names: one a column,
    or empty. events: as in `Trajectory`.
    """

    times: Float64Array
    positions: Float64Array
    velocities: Float64Array | None = None
    accelerations: Float64Array | None = None
    joint_names: tuple[str, ...] = ()
    events: tuple[Event, ...] = ()

    def __post_init__(self) -> None:
        _freeze_clock(self)
        _freeze_rows(self, "positions", len(self.times), "joints")
        joints = self.positions.shape[1]
        for name in ("velocities", "accelerations"):
            if getattr(self, name) is not None:
                _freeze_rows(self, name, len(self.times), joints)
        names = self.joint_names
        if isinstance(names, str) or not isinstance(names, Sequence):
            raise InvalidInput(f"joint_names: expected a sequence of names, got {names!r}")
        if not all(isinstance(name, str) for name in names):
            raise InvalidInput(f"joint_names: expected names, got {names!r}")
        object.__setattr__(self, "joint_names", tuple(names))
        if self.joint_names and len(self.joint_names) != joints:
            raise InvalidInput(f"joint_names: expected {joints} names, got {len(self.joint_names)}")

    @property
    def duration(self) -> float:
        """Time from the first sample to the last, s."""
        return float(self.times[-1] - self.times[0])


Motion = Trajectory | PoseTrajectory | JointTrajectory
AnyMotion = TypeVar("AnyMotion", Trajectory, PoseTrajectory, JointTrajectory)
MotionT = TypeVar("MotionT", bound=Motion)
if TYPE_CHECKING:
    # Type checkers bring typing_extensions. By the default, a plain `Demonstration` is one of any
    # motion; typing.TypeVar takes defaults from Python 3.13 on.
    from typing_extensions import TypeVar as _TypeVar

    MotionT_co = _TypeVar("MotionT_co", bound=Motion, default=Motion, covariant=True)
else:
    MotionT_co = TypeVar("MotionT_co", bound=Motion, covariant=True)


def normalised_times(times: Float64Array) -> Float64Array:
    """Fractions (n,) of the duration passed at rising times (n,), from 0 to 1; 0 if n is 1."""
    if len(times) == 1:
        return np.zeros(1)
    return np.asarray((times - times[0]) / (times[-1] - times[0]))


def computed(kind: type[AnyMotion], *, events: Events, **arrays: Float64Array) -> AnyMotion:
    """A motion of arrays just computed, which hold all that its constructor checks or makes true.

    They are not copied, and become read-only. events: sorted, inside the motion's times.
    """
    motion = object.__new__(kind)
    for array in arrays.values():
        array.setflags(write=False)
    vars(motion).update(arrays, events=events)
    return motion


@dataclass(frozen=True, eq=False)
class Demonstration(Generic[MotionT_co]):
    """One motion that was shown to the robot, such as a `Demonstration[JointTrajectory]`."""

    motion: MotionT_co
    name: str = ""

    def __post_init__(self) -> None:
        if not isinstance(self.motion, Trajectory | PoseTrajectory | JointTrajectory):
            raise InvalidInput(
                "motion: expected a Trajectory, PoseTrajectory or JointTrajectory, "
                f"got {type(self.motion).__name__}"
            )

    @property
    def events(self) -> tuple[Event, ...]:
        """What happened during the motion."""
        return self.motion.events


def _freeze_clock(motion: Motion) -> None:
    object.__setattr__(motion, "times", check.times(motion.times, "times"))
    object.__setattr__(motion, "events", events.checked(motion.events, motion.times))


def _freeze_rows(motion: Motion, name: str, count: int, width: int | str) -> None:
    rows = check.frozen(getattr(motion, name), name, shape=(count, width))
    if rows.shape[1] == 0:
        raise InvalidInput(f"{name}: expected at least one column, got none")
    object.__setattr__(motion, name, rows)

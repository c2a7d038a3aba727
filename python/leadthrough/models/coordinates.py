"""Motions of any type as columns of numbers that a model may average, and back.

Points and joints stand for themselves. Orientations are rotation vectors in the tangent spaces
along a reference: log(reference(phase)^-1 q), in the reference's own frame. They stay small where
the demonstrations stay near each other, however far all of them rotate.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Generic, cast

import numpy as np
from numpy.typing import NDArray

from leadthrough import check, rotations
from leadthrough.check import Float64Array, InvalidInput, ShortRepr
from leadthrough.models.mean_orientation import mean_orientations
from leadthrough.models.posture import Posture, arrays_of, demonstrated_posture, settings_of
from leadthrough.models.targets import Target
from leadthrough.motion import (
    Event,
    Events,
    JointTrajectory,
    Motion,
    MotionT,
    MotionT_co,
    PoseTrajectory,
    Trajectory,
    agreed_events,
    events_of_plain,
    in_order,
    moved_events,
    plain_events,
    with_derivatives,
)

# Phases of the reference orientation.
NODES = np.linspace(0.0, 1.0, 201)
# Columns that vary less than this fraction of the widest are as good as constant.
_MIN_FRACTION = 1e-3
# Reach where all positions, or all orientations, are the same: a millimetre, a milliradian.
_STILL = 1e-3


@dataclass(frozen=True, eq=False)
class Coordinates(ShortRepr, Generic[MotionT_co]):
    """Meaning of the columns of a model, which become motions again."""

    kind: str  # "points", "joints" or "poses"
    size: int  # number of columns of a point, of the joints, or of a pose's position
    joint_names: tuple[str, ...] = ()  # of joints
    reference: Float64Array | None = None
    events: tuple[Event, ...] = ()  # at phases
    posture: Posture | None = None  # the arm's joints at phases, or None

    @property
    def width(self) -> int:
        """Number of columns; a pose has its position and then three of its orientation."""
        return self.size + (3 if self.kind == "poses" else 0)

    @cached_property
    def every(self) -> NDArray[np.int64]:
        """The numbers (width,) of its columns."""
        return np.arange(self.width, dtype=np.int64)

    def columns(self, motion: Motion, phases: Float64Array, name: str) -> Float64Array:
        """The columns (n, width) of a motion."""
        if not isinstance(motion, _TYPES[self.kind]) or motion.positions.shape[1] != self.size:
            raise InvalidInput(
                f"{name}: expected {self.kind} of {self.size} columns, got {_described(motion)}"
            )
        if isinstance(motion, JointTrajectory):
            return in_order(motion, self.joint_names, name).positions
        if isinstance(motion, Trajectory):
            return motion.positions
        return np.hstack([motion.positions, self.tangent(motion.orientations, phases)])

    def tangent(self, orientations: Float64Array, phases: Float64Array) -> Float64Array:
        """Rotation vectors (n, 3) of orientations (n, 4) from the reference at phases (n,)."""
        reference = rotations.inverse(self.reference_at(phases))
        return rotations.log(rotations.compose(reference, orientations))

    def orientations(self, tangent: Float64Array, phases: Float64Array) -> Float64Array:
        """The orientations (n, 4) that rotation vectors (n, 3) stand for at phases (n,)."""
        return rotated_by(self.reference_at(phases), tangent)

    def reference_at(self, phases: Float64Array) -> Float64Array:
        """The reference orientation (n, 4) at phases (n,) in [0, 1]."""
        assert self.reference is not None
        inside = np.clip(phases, 0.0, 1.0)
        return rotations.squad(NODES, self.reference, inside)

    def motion(
        self,
        times: Float64Array,
        phases: Float64Array,
        columns: Float64Array,
        velocities: Float64Array | None = None,
        accelerations: Float64Array | None = None,
    ) -> MotionT_co:
        """A motion of the demonstrated type."""
        happening = moved_events(self.events, phases, times)
        joints = None if self.posture is None else self.posture.along(times, phases)
        made: Motion
        if self.kind == "points":
            made = Trajectory(times, columns, happening, joints)
        elif self.kind == "joints":
            names = self.joint_names
            made = with_derivatives(
                JointTrajectory(times, columns, velocities, accelerations, names, happening)
            )
        else:
            given = self.orientations(columns[:, 3:], phases)
            made = PoseTrajectory(times, columns[:, :3], given, happening, joints)
        return cast(MotionT_co, made)  # of the type that the coordinates was made for

    def target(self, value: Target, name: str, phase: float) -> Float64Array:
        """A target of a query, in columns."""
        if self.kind != "poses":
            return check.array(value, name, shape=(self.size,))
        if not isinstance(value, tuple | list) or len(value) != 2:
            return check.array(value, name, shape=(3,))
        position = check.array(value[0], name, shape=(3,))
        given = check.quaternions(value[1], name, shape=(4,))
        return np.concatenate([position, self.tangent(given[None], np.array([phase]))[0]])

    def arrays(self) -> dict[str, Any]:
        """Its arrays by name, for a file."""
        reference = {} if self.reference is None else {"reference": self.reference}
        return reference | arrays_of(self.posture)

    def settings(self) -> dict[str, Any]:
        """Its plain values by name, for a file."""
        return {
            "chart": self.kind,
            "size": self.size,
            "joint_names": list(self.joint_names),
            "events": plain_events(self.events),
            **settings_of(self.posture),
        }

    @staticmethod
    def from_archive(settings: dict[str, Any], arrays: Any) -> Coordinates:
        """The coordinates that `settings` and `arrays` took apart."""
        shape = (len(NODES), 4)
        return Coordinates(
            check.choice(settings["chart"], "chart", _TYPES),
            check.integer(settings["size"], "size", at_least=1),
            tuple(settings["joint_names"]),
            check.unit_quaternions(arrays["reference"], "reference", shape=shape)
            if "reference" in arrays
            else None,
            events_of_plain(settings.get("events", ())),
            Posture.from_archive(dict(settings), arrays),
        )


_TYPES: dict[str, type] = {
    "points": Trajectory,
    "joints": JointTrajectory,
    "poses": PoseTrajectory,
}


def coordinates_of(
    motions: Sequence[MotionT],
    phases: Sequence[Float64Array],
    *,
    middle: Callable[[Sequence[Float64Array]], Float64Array] = mean_orientations,
) -> Coordinates[MotionT]:
    """The coordinates in which motions are near each other."""
    kind = next(kind for kind, each in _TYPES.items() if isinstance(motions[0], each))
    names = motions[0].joint_names if isinstance(motions[0], JointTrajectory) else ()
    poses = [motion for motion in motions if isinstance(motion, PoseTrajectory)]
    reference = middle(_at_nodes(poses, phases)) if poses else None
    happened = [
        each
        for motion, u in zip(motions, phases, strict=True)
        for each in events_by_round(moved_events(motion.events, motion.times, u), u[0], u[-1])
    ]
    size = motions[0].positions.shape[1]
    posture = demonstrated_posture(motions, phases)
    return Coordinates(kind, size, names, reference, agreed_events(happened), posture)


def scales(columns: Sequence[Float64Array], coordinates: Coordinates) -> Float64Array:
    """The reach of the columns of motions, (width,) > 0, in their units."""
    reach = np.sqrt(np.mean([each.var(axis=0) for each in columns], axis=0))
    wide = np.ones(coordinates.width)
    for group in (slice(0, coordinates.size), slice(coordinates.size, coordinates.width)):
        wide[group] = reach[group].max(initial=0.0) or _STILL / _MIN_FRACTION
    return np.asarray(np.maximum(reach, _MIN_FRACTION * wide))


def _at_nodes(
    motions: Sequence[PoseTrajectory], phases: Sequence[Float64Array]
) -> list[Float64Array]:
    """The orientations (201, 4) at the nodes of motions whose samples stand at phases."""
    return [
        rotations.interpolate(at, motion.orientations, np.clip(NODES, at[0], at[-1]))
        for motion, at in zip(motions, phases, strict=True)
    ]


def rotated_by(reference: Float64Array, tangent: Float64Array) -> Float64Array:
    """The orientations (n, 4) that rotation vectors (n, 3) stand for from a reference (n, 4)."""
    return rotations.align_signs(rotations.compose(reference, rotations.exp(tangent)))


def carried(before: Float64Array, after: Float64Array) -> Float64Array:
    """Matrices (n, 3, 3) that carry small deviations from one tangent space to another."""
    # log(exp(d) exp(v)) = d + J_r(d)^-1 v + ..., with J_r(d) = J_l(-d); Sola et al. 2018, eq. 151.
    return np.asarray(rotations.left_jacobian_inverse(-after) @ rotations.left_jacobian(-before))


def _described(motion: Motion) -> str:
    return f"{type(motion).__name__} of {motion.positions.shape[1]} columns"


def events_by_round(events: Events, first: float, last: float) -> list[Events]:
    """The events of each round from `first` to `last`, at times 0 to 1 within their round."""
    end = int(np.ceil(last))
    return [
        tuple(
            Event(event.time - k, event.name)
            for event in events
            if k <= event.time < k + 1 or event.time == end == k + 1
        )
        for k in range(int(np.floor(first)), end)
    ]

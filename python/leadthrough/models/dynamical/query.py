"""Queries of a dynamical system: the goal and the start in normalised columns, and back."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Generic

import numpy as np

from leadthrough import rotations
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.models.coordinates import NODES, Coordinates
from leadthrough.models.targets import Target
from leadthrough.motion import MotionT_co


@dataclass(frozen=True, eq=False)
class Situation(Generic[MotionT_co]):
    """A goal, and where a motion starts."""

    coordinates: Coordinates[MotionT_co]  # of motions to this goal
    goal: Float64Array  # position or joints (m,) of the goal
    start: Float64Array  # the start (d,) in normalised columns about the goal
    scale: Float64Array  # divisors (d,) of the columns

    def columns(self, x: Float64Array) -> Float64Array:
        """The coordinates's columns (n, d) of normalised positions (n, d)."""
        columns = x * self.scale
        columns[:, : self.coordinates.size] += self.goal
        return columns


def situation(
    coordinates: Coordinates[MotionT_co],
    ends: Float64Array,
    scale: Float64Array,
    start: Target | None,
    goal: Target | None,
) -> Situation[MotionT_co]:
    """The situation that a query describes; what it leaves open is as demonstrated."""
    size = coordinates.size
    position = ends[1, :size]
    if goal is not None:
        target = coordinates.target(goal, "goal", 1.0)
        position = target[:size]
        if len(target) > size:
            coordinates = _about(
                coordinates, coordinates.orientations(target[None, size:], np.ones(1))[0]
            )
    demonstrated = ends[0].copy()
    if start is not None:
        given = coordinates.target(start, "start", 0.0)
        if len(given) > size:
            given = np.concatenate(
                [given[:size], _nearest_sheet(given[size:], demonstrated[size:])]
            )
        demonstrated[: len(given)] = given
    demonstrated[:size] -= position
    return Situation(coordinates, position, demonstrated / scale, scale)


def _about(coordinates: Coordinates[MotionT_co], goal: Float64Array) -> Coordinates[MotionT_co]:
    return replace(coordinates, reference=np.tile(goal, (len(NODES), 1)))


def _nearest_sheet(vector: Float64Array, other: Float64Array) -> Float64Array:
    """The rotation vector (3,) of the same rotation that is nearest to another vector."""
    return min(sheets(vector, other), key=lambda each: float(np.linalg.norm(each - other)))


def sheets(turn: Float64Array, axis: Float64Array) -> list[Float64Array]:
    """Rotation vectors (3,) of one rotation: the shortest, and with a turn less and a turn more."""
    angle = float(np.linalg.norm(turn))
    own = turn / angle if angle > 0.0 else axis / max(float(np.linalg.norm(axis)), 1e-300)
    return [(angle + 2.0 * np.pi * k) * own for k in (0, -1, 1)]


def twist(coordinates: Coordinates, vectors: Float64Array, rate: Float64Array) -> Float64Array:
    """Angular velocities (n, 3) in the base frame of rotation vectors from the goal."""
    local = (rotations.left_jacobian(vectors) @ rate[:, :, None])[:, :, 0]
    assert coordinates.reference is not None
    return np.asarray(local @ rotations.to_matrix(coordinates.reference[:1])[0].T)


def pose_of(place: Any) -> Target:
    """Position and orientation of a pose."""
    if not isinstance(place, tuple | list) or len(place) != 2:
        raise InvalidInput(
            "position: expected (position (3,), orientation (4,)) of a skill of poses"
        )
    return place[0], place[1]

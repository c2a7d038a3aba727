"""What a query says in the base frame, as it is seen from the frame of a task."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypedDict

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check, rotations
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput, UnsupportedQuery
from leadthrough.models.frame import Frame
from leadthrough.models.targets import Target
from leadthrough.motion import MotionT
from leadthrough.shapes import Shape

Via = Sequence[tuple[float, ArrayLike]]

# Largest difference of an axis from an axis of the base frame that passes for rounding.
_ALIGNED = 1e-9


class Beyond(TypedDict, total=False):
    """Parts of a query that only some skills take."""

    via: Via
    start_velocity: ArrayLike
    final_velocity: ArrayLike


class Limits(TypedDict, total=False):
    """What only skills with limits take."""

    limits: tuple[ArrayLike, ArrayLike]


def motion_seen(frame: Frame, motion: MotionT) -> MotionT:
    """A motion with its events."""
    back = Frame(-frame.origin @ frame.axes, frame.axes.T)
    return back.base(motion)


def place_seen(frame: Frame, place: Any, name: str, *, poses: bool) -> Target | None:
    """A place; None for None."""
    if place is None:
        return None
    turned = poses and isinstance(place, tuple | list) and len(place) == 2
    given = place[0] if turned else place
    position = check.array(given, name, shape=(len(frame.origin),))
    seen: Float64Array = (position - frame.origin) @ frame.axes
    if not turned:
        return seen
    q = check.quaternions(place[1], name, shape=(4,))
    back = rotations.inverse(frame.orientations(1))
    return seen, rotations.compose(back, q[None])[0]


def shape_seen(frame: Frame, shape: Shape) -> Shape:
    """A shape; a frame of two dimensions lies in the plane z = 0."""
    size = len(frame.origin)
    origin, axes = np.zeros(3), np.eye(3)
    origin[:size], axes[:size, :size] = frame.origin, frame.axes
    position = (np.asarray(shape.position) - origin) @ axes
    back = rotations.inverse(rotations.from_matrix(axes[None]))
    return shape.at(position, rotations.compose(back, shape.orientation[None])[0])


def limits_seen(
    frame: Frame, limits: tuple[ArrayLike, ArrayLike]
) -> tuple[Float64Array, Float64Array]:
    """Limits of each column, where the frame's axes are those of the base frame, in any order."""
    if not isinstance(limits, Sequence) or len(limits) != 2:
        raise InvalidInput(f"limits: expected a pair (lower, upper), got {limits!r}")
    size = len(frame.origin)
    corners = np.stack([check.array(side, "limits", shape=(size,)) for side in limits])
    if not (corners[0] < corners[1]).all():
        raise InvalidInput(f"limits: expected lower < upper, got {corners[0]} and {corners[1]}")
    if np.abs(np.abs(frame.axes).max(axis=0) - 1.0).max() > _ALIGNED:
        raise UnsupportedQuery(
            "limits: limits of the base frame are none of single columns in a frame that is turned "
            "against it; give walls as obstacles, or ask the skill inside for limits in its own "
            "frame; in Python, skill.skill.generate(limits=...)"
        )
    turned = (corners - frame.origin) @ np.round(frame.axes)
    return turned.min(axis=0), turned.max(axis=0)


def covariance_seen(frame: Frame, covariance: ArrayLike | None) -> Float64Array | None:
    """A covariance (d, d) of a position; None for None."""
    if covariance is None:
        return None
    size = len(frame.origin)
    given = check.array(covariance, "covariance", shape=(size, size))
    return np.asarray(frame.axes.T @ given @ frame.axes)


def beyond_seen(
    frame: Frame,
    via: Via,
    start_velocity: ArrayLike | None,
    final_velocity: ArrayLike | None,
) -> Beyond:
    """Via points and velocities, those that are given."""
    found = Beyond()
    if not isinstance(via, Sequence):
        raise InvalidInput(f"via: expected a sequence of (phase, point), got {via!r}")
    if len(via) > 0:
        if not all(isinstance(pair, tuple | list) and len(pair) == 2 for pair in via):
            raise InvalidInput(f"via: expected pairs (phase, point), got {via!r}")
        points = [check.array(point, "via", shape=frame.origin.shape) for _, point in via]
        found["via"] = [
            (pair[0], (point - frame.origin) @ frame.axes)
            for pair, point in zip(via, points, strict=True)
        ]
    if start_velocity is not None:
        found["start_velocity"] = _turned(frame, start_velocity, "start_velocity")
    if final_velocity is not None:
        found["final_velocity"] = _turned(frame, final_velocity, "final_velocity")
    return found


def _turned(frame: Frame, velocity: ArrayLike, name: str) -> Float64Array:
    return np.asarray(check.array(velocity, name, shape=frame.origin.shape) @ frame.axes)

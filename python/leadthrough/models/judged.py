"""Queries are compared with what the skill was shown, before anything is planned."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import wraps
from typing import Any, TypeVar

import numpy as np

from leadthrough import plausible
from leadthrough.check import Float64Array
from leadthrough.motion import JointTrajectory, Motion, PoseTrajectory, Trajectory
from leadthrough.shapes import Shape

_Generate = TypeVar("_Generate", bound=Callable[..., Any])


def judged(generate: _Generate) -> _Generate:
    """The method `generate` of a skill, which first looks at whether its query can be meant."""

    @wraps(generate)
    def looked_at(self: Any, **query: Any) -> Any:
        ends = {name: query[name] for name in ("start", "goal") if query.get(name) is not None}
        shapes = query.get("obstacles")
        if ends or (isinstance(shapes, Sequence) and len(shapes) > 0):
            shown = self._own_motion
            for name, place in ends.items() if shown is not None else ():
                _look_at_end(place, shown, name)
            _look_at_obstacles(shapes or (), shown)
        return generate(self, **query)

    return looked_at  # type: ignore[return-value]  # of the same signature, as wraps states


def _look_at_end(place: Any, shown: Motion, name: str) -> None:
    poses = isinstance(shown, PoseTrajectory)
    turned = poses and isinstance(place, tuple | list) and len(place) == 2
    position = _numbers(place[0] if turned else place, shown.positions.shape[1])
    if position is not None:
        compare = plausible.joints if isinstance(shown, JointTrajectory) else plausible.place
        compare(position, shown.positions, name)
    quaternion = _numbers(place[1], 4) if turned else None
    if quaternion is not None and isinstance(shown, PoseTrajectory):
        end = shown.orientations[0 if name == "start" else -1]
        plausible.orientation(quaternion, shown.orientations, end, name)


def _look_at_obstacles(shapes: Sequence[Any], shown: Motion | None) -> None:
    if isinstance(shown, Trajectory | PoseTrajectory):
        plausible.obstacles(
            [shape for shape in shapes if isinstance(shape, Shape)], shown.positions
        )


def _numbers(value: Any, count: int) -> Float64Array | None:
    """The finite numbers (count,) that a place consists of, if it does."""
    try:
        numbers = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        return None
    if numbers.shape != (count,) or not all(map(math.isfinite, numbers.tolist())):
        return None
    return numbers

"""Episodes of an arm, for policies that learn from them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from leadthrough.check import Float64Array


@dataclass(frozen=True, eq=False)
class Episode:
    """A motion of an arm, one row a frame, and the poses of objects, which stand still.

    An action is what the arm does next: the row that follows; at the end the last one again.
    """

    q: Float64Array  # (n, joints), rad
    qd: Float64Array  # (n, joints), rad/s
    tip: Float64Array  # (n, 7) in the base frame, m, then x, y, z, w
    gripper: Float64Array | None  # (n,), 1 is open, 0 closed
    objects: Float64Array  # (k,), as `Layout.objects` names them
    origin: dict[str, Any]  # numbers and texts that tell where it comes from

    @property
    def joints(self) -> Float64Array:
        """Joints, and the gripper as a further one."""
        return self.q if self.gripper is None else np.column_stack([self.q, self.gripper])


@dataclass(frozen=True)
class Layout:
    """Names and rate that all episodes of a data set share."""

    robot: str
    joints: tuple[str, ...]
    objects: tuple[str, ...]
    has_gripper: bool
    rate: float  # frames per second
    task: str  # what the arm does, in words
    origin: dict[str, Any]  # of the data set

    @property
    def state(self) -> tuple[str, ...]:
        """Names of the joints, and of the gripper."""
        return (*self.joints, "gripper") if self.has_gripper else self.joints


def following(rows: Float64Array) -> Float64Array:
    """The rows that follow, the last one again at the end."""
    return np.concatenate([rows[1:], rows[-1:]])

"""Surfaces in layers, and the poses of the links that carry them over time.

It knows no renderer: the HTML page, the notebook and the live view draw the same animation.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

import numpy as np

from leadthrough import rotations
from leadthrough.arm import Arm
from leadthrough.arm.link_geometry import link_poses
from leadthrough.check import Float64Array, ShortRepr
from leadthrough.drawing.palette import Colour
from leadthrough.motion import JointTrajectory, in_order
from leadthrough.shapes.surface import Surface
from leadthrough.show.surfaces import creased, smooth


class Layer(StrEnum):
    """Surfaces that are shown and hidden together."""

    ARM = "arm"
    DEMONSTRATIONS = "demonstrations"
    OBSTACLES = "obstacles"
    PATH = "path"
    MODES = "other modes"
    SPREAD = "uncertainty"
    START = "start"
    GOAL = "goal"
    VIA = "via points"
    PLANNED = "planned arm"


# Layers whose surfaces have no creases.
_SMOOTH = frozenset(Layer) - {Layer.ARM, Layer.OBSTACLES, Layer.PLANNED}
# A screen shows at most 60 frames per second, and a long motion is shown with fewer.
_FRAME_RATE = 60.0
_MAX_FRAMES = 1200


@dataclass(frozen=True, eq=False)
class Item(ShortRepr):
    """One surface."""

    name: str  # unique in its layer
    layer: str  # one of the layers above
    mesh: Surface  # in the frame of its link, or of the arm's base
    colour: Colour  # red, green, blue in [0, 1]
    opacity: float = 1.0  # in [0, 1]
    link: int | None = None  # index of the link that carries it; None if it stands still

    def shaded(self) -> tuple[Surface, Float64Array]:
        """Its surface, with separate vertices at creases, and unit normals (n, 3)."""
        return smooth(self.mesh) if self.layer in _SMOOTH else creased(self.mesh)


@dataclass(frozen=True, eq=False)
class Animation(ShortRepr):
    """Surfaces and the motion of the links that carry some of them."""

    links: tuple[str, ...]  # their names
    times: Float64Array  # (n,), s, from 0. Between them, poses are interpolated
    positions: Float64Array  # of the links in the frame of the arm's base, (n, links, 3), m
    orientations: Float64Array  # of the links in that frame, (n, links, 4), w, x, y, z
    items: tuple[Item, ...] = field(repr=False)  # the surfaces
    tip: int | None = None  # index of the link at the arm's tip
    readouts: dict[str, Any] | None = None  # figures at the times; see `readouts`
    remarks: tuple[str, ...] = ()  # on missing parts, such as a mesh file that is not there

    def ball(self) -> tuple[Float64Array, float]:
        """Centre (3,) and radius, m, of a ball around all surfaces and their motion."""
        still = [item.mesh.vertices for item in self.items if item.link is None]
        frames = {0, len(self.times) // 2, len(self.times) - 1}
        boxes = {item.mesh: _box(item.mesh) for item in self.items if item.link is not None}
        moving = [self._at(item, boxes, frame) for item in self.items for frame in frames]
        points = np.concatenate([self.positions.reshape(-1, 3), *still, *moving])
        lower, upper = points.min(axis=0), points.max(axis=0)
        return 0.5 * (lower + upper), max(0.5 * float(np.linalg.norm(upper - lower)), 0.1)

    def _at(self, item: Item, boxes: Mapping[Surface, Float64Array], frame: int) -> Float64Array:
        """The corners (8, 3) of the box around a moving surface at one sample."""
        if item.link is None:
            return np.zeros((0, 3))
        rotation = rotations.to_matrix(self.orientations[frame, item.link][None])[0]
        return np.asarray(boxes[item.mesh] @ rotation.T + self.positions[frame, item.link])

    def poses_at(self, time: float) -> tuple[Float64Array, Float64Array]:
        """Positions (links, 3) and orientations (links, 4) at a time, s; held beyond the ends."""
        last = len(self.times) - 1
        i = int(np.clip(np.searchsorted(self.times, time) - 1, 0, max(last - 1, 0)))
        j = min(i + 1, last)
        span = self.times[j] - self.times[i]
        passed = float(np.clip((time - self.times[i]) / span, 0.0, 1.0)) if span > 0.0 else 0.0
        position = (1.0 - passed) * self.positions[i] + passed * self.positions[j]
        orientation = (1.0 - passed) * self.orientations[i] + passed * self.orientations[j]
        return position, orientation / np.linalg.norm(orientation, axis=1, keepdims=True)


def _box(mesh: Surface) -> Float64Array:
    """The corners (8, 3) of the box around a surface."""
    reach = np.stack([mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)])
    return np.stack(np.meshgrid(*reach.T), axis=-1).reshape(-1, 3)


def sampled(arm: Arm, joints: JointTrajectory | None) -> JointTrajectory:
    """A motion at no more samples than a screen shows."""
    if joints is None:
        return JointTrajectory(np.zeros(1), _middle(arm)[None], joint_names=arm.joint_names)
    joints = in_order(joints, arm.joint_names, "joints")
    wanted = min(int(joints.duration * _FRAME_RATE) + 2, _MAX_FRAMES)
    if len(joints.times) <= wanted:
        return joints
    times = np.linspace(joints.times[0], joints.times[-1], wanted)
    columns = [np.interp(times, joints.times, column) for column in joints.positions.T]
    return JointTrajectory(times, np.column_stack(columns), joint_names=arm.joint_names)


def link_motion(arm: Arm, q: Float64Array) -> tuple[tuple[str, ...], Float64Array, Float64Array]:
    poses = link_poses(arm, q)
    positions = np.stack([position for _, position in poses.values()], axis=1)
    matrices = np.concatenate([matrix for matrix, _ in poses.values()])
    orientations = rotations.from_matrix(matrices).reshape(len(poses), len(q), 4)
    return tuple(poses), positions, np.stack([*map(rotations.align_signs, orientations)], axis=1)


def _middle(arm: Arm) -> Float64Array:
    low, high = arm.limits.lower, arm.limits.upper
    bounded = np.isfinite(low) & np.isfinite(high)
    return 0.5 * (np.where(bounded, low, 0.0) + np.where(bounded, high, 0.0))

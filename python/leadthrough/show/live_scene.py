"""What a live page draws: the arm, surfaces by layer, and figures along a motion, as messages."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from leadthrough.arm import Arm
from leadthrough.check import Float64Array
from leadthrough.motion import Demonstration, JointTrajectory
from leadthrough.shapes import Scene
from leadthrough.shapes.primitives import PRIMITIVES
from leadthrough.show import page
from leadthrough.show.animation import (
    DEMONSTRATIONS,
    GOAL,
    OBSTACLES,
    PATH,
    Animation,
    Item,
    link_motion,
)
from leadthrough.show.arm_scene import (
    arm_motion,
    arm_scene,
    demonstration_items,
    goal_item,
    obstacle_item,
    path_item,
)

LAYERS = (DEMONSTRATIONS, OBSTACLES, PATH, GOAL)


@dataclass(frozen=True, eq=False)
class LiveScene:
    """An arm and what is drawn with it."""

    arm: Arm
    motion: JointTrajectory  # that the page plays
    scene: Scene
    demonstrations: Sequence[Demonstration] = ()
    path: Float64Array | None = None  # of the tip (n, 3)
    goal: Float64Array | None = None  # (3,)

    def document(self) -> str:
        """The page."""
        return page.teaching_document(self._whole(), self.arm.robot.name)

    def message(
        self, layers: Sequence[str] = LAYERS, *, moves: bool = False, detailed: bool = True
    ) -> str:
        """Surfaces of some layers, and the motion, which the page plays from now on if it moves."""
        items = tuple(item for name in layers for item in self._items(name))
        drawn = replace(arm_motion(self.arm, self.motion), items=items)
        told = readouts(self.arm, self.motion, self.scene) if detailed else None
        data = page.packed(drawn, level=1, layers=list(layers), readouts=told)
        return json.dumps({"kind": "scene", "data": data, "moves": moves})

    def _whole(self) -> Animation:
        drawn = arm_scene(
            self.arm,
            self.motion,
            demonstrations=self.demonstrations,
            obstacles=self.scene.shapes,
        )
        return replace(drawn, items=tuple(item for item in drawn.items if item.layer != PATH))

    def _items(self, layer: str) -> Sequence[Item]:
        if layer == DEMONSTRATIONS:
            return list(demonstration_items(self.arm, self.demonstrations))
        if layer == OBSTACLES:
            return [obstacle_item(shape, i) for i, shape in enumerate(self.scene.shapes)]
        if layer == PATH and self.path is not None:
            return [path_item(self.path)]
        return [goal_item(self.goal)] if layer == GOAL and self.goal is not None else []


def poses_message(arm: Arm, q: Float64Array, blocked: str) -> str:
    """Poses of the links, and the reason why the tip does not follow."""
    _, positions, orientations = link_motion(arm, q[None])
    poses = np.concatenate([positions, orientations], axis=2).ravel().round(5).tolist()
    return json.dumps({"kind": "poses", "poses": poses, "why": blocked})


def readouts(arm: Arm, motion: JointTrajectory, scene: Scene) -> dict[str, Any] | None:
    """Clearance, m, the joint nearest to its speed limit, and the tip's speed along a motion."""
    if len(motion.times) < 2:
        return None
    times = motion.times
    rates = np.abs(np.gradient(motion.positions, times, axis=0)) / arm.limits.velocity
    tips = arm.forward_kinematics(motion.positions)[0]
    speed = np.linalg.norm(np.gradient(tips, times, axis=0), axis=1)
    clearance = np.asarray(arm.distance(motion.positions, scene)) if scene.shapes else None
    return {
        "times": (times - times[0]).round(4).tolist(),
        "joint": rates.argmax(axis=1).tolist(),
        "share": rates.max(axis=1).round(3).tolist(),
        "speed": speed.round(4).tolist(),
        "clearance": None if clearance is None else clearance.round(4).tolist(),
        "names": list(arm.joint_names),
    }


def obstacle_words(scene: Scene) -> list[str]:
    """The solids of a scene as options of the command line; meshes and clouds are left out."""
    texts = map(_written, scene.shapes)
    return [f"--obstacle {text}" for text in texts if text]


def _written(shape: Any) -> str:  # Any: only solids have sizes
    """A solid as the command line has it; empty for meshes and clouds."""
    kind = next((name for name, each in PRIMITIVES.items() if type(shape) is each), None)
    if kind is None:
        return ""
    parts = ((shape.sizes, "@"), (shape.position, "/"), (shape.orientation, ""))
    return f"{kind}:" + "".join(numbers(part) + end for part, end in parts)


def numbers(values: Float64Array) -> str:
    """Numbers as the command line has them, to 0.01 mm."""
    return ",".join(f"{x + 0.0:g}" for x in np.round(values, 5))

"""What a live page draws: the arm, surfaces by layer, and figures along a motion, as messages."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from leadthrough.arm import Arm
from leadthrough.check import Float64Array
from leadthrough.models.protocol import Skill
from leadthrough.motion import Demonstration, JointTrajectory
from leadthrough.shapes import Scene
from leadthrough.show import page
from leadthrough.show.animation import (
    DEMONSTRATIONS,
    GOAL,
    OBSTACLES,
    PATH,
    SPREAD,
    Animation,
    Item,
)
from leadthrough.show.arm_scene import (
    arm_motion,
    arm_scene,
    demonstration_items,
    goal_item,
    obstacle_item,
    path_item,
    spread_items,
)

_MOTIONLESS = Animation((), np.zeros(0), np.zeros((0, 0, 3)), np.zeros((0, 0, 4)), ())
LAYERS = (DEMONSTRATIONS, OBSTACLES, PATH, SPREAD, GOAL)


@dataclass(frozen=True, eq=False)
class LiveScene:
    """An arm and what is drawn with it."""

    arm: Arm
    motion: JointTrajectory | None  # that the page plays
    scene: Scene
    demonstrations: Sequence[Demonstration] = ()
    path: Float64Array | None = None  # of the tip (n, 3)
    goal: Float64Array | None = None  # (3,)
    skill: Skill | None = None  # whose spread is drawn

    def document(self, kind: str) -> str:
        """The page of a kind, "teach" or "view"."""
        return page.live_document(self._whole(), self.arm.robot.name, kind)

    def message(
        self, layers: Sequence[str] = LAYERS, *, moves: bool = False, detailed: bool = True
    ) -> str:
        """Surfaces of some layers, and the motion from now on if it `moves`."""
        items = tuple(item for name in layers for item in self._items(name))
        motion = arm_motion(self.arm, self.motion) if moves else _MOTIONLESS
        drawn = replace(motion, items=items)
        told = readouts(self.arm, self.motion, self.scene) if detailed else None
        data = page.packed(drawn, level=1, layers=list(layers), readouts=told)
        return json.dumps({"kind": "scene", "data": data, "moves": moves})

    def _whole(self) -> Animation:
        drawn = arm_scene(self.arm, self.motion)
        items = [item for item in drawn.items if item.layer != PATH]
        return replace(drawn, items=(*items, *(i for name in LAYERS for i in self._items(name))))

    def _items(self, layer: str) -> Sequence[Item]:
        if layer == DEMONSTRATIONS:
            return list(demonstration_items(self.arm, self.demonstrations))
        if layer == OBSTACLES:
            return [obstacle_item(shape, i) for i, shape in enumerate(self.scene.shapes)]
        if layer == PATH and self.path is not None:
            return [path_item(self.path)]
        if layer == SPREAD:
            return list(spread_items(self.arm, self.skill))
        return [goal_item(self.goal)] if layer == GOAL and self.goal is not None else []


def readouts(arm: Arm, motion: JointTrajectory | None, scene: Scene) -> dict[str, Any] | None:
    """Clearance, m, the joint nearest to its speed limit, and the tip's speed along a motion."""
    if motion is None or len(motion.times) < 2:
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

"""What a live page draws: the arm, surfaces by layer, and figures along a motion, as messages."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from leadthrough.arm import Arm
from leadthrough.check import Float64Array
from leadthrough.models.protocol import Skill
from leadthrough.motion import Demonstration, JointTrajectory
from leadthrough.shapes import Scene
from leadthrough.show import arm_scene as scenes, page
from leadthrough.show.animation import Animation, Item, Layer
from leadthrough.show.arm_scene import goal_item, path_item, start_item

_MOTIONLESS = Animation((), np.zeros(0), np.zeros((0, 0, 3)), np.zeros((0, 0, 4)), ())
_MARKS = {Layer.PATH: path_item, Layer.START: start_item, Layer.GOAL: goal_item}
LAYERS = [layer for layer in Layer if layer not in (Layer.ARM, Layer.PLANNED)]


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
    via: Sequence[Float64Array] = ()  # points (3,) that the path was moved to
    wanted: Float64Array | None = None  # path of the tip (m, 3) by the skill alone
    others: Sequence[Float64Array] = ()  # such paths by other modes

    def document(self, kind: str) -> str:
        """The page of a kind, "teach" or "view"."""
        return page.live_document(self._whole(), self.arm.robot.name, kind)

    def write(self, path: str | Path) -> None:
        """Writes a page that needs no server."""
        page.write_page(path, self.arm.robot.name, page.scene(self._whole()), whole=True)

    def message(
        self, layers: Sequence[str] = LAYERS, *, moves: bool = False, detailed: bool = True
    ) -> str:
        """Surfaces of some layers, and the motion from now on if it `moves`."""
        items = tuple(item for name in layers for item in self._items(name))
        motion = scenes.arm_motion(self.arm, self.motion) if moves else _MOTIONLESS
        drawn = replace(motion, items=items)
        told = self._readouts() if detailed else None
        data = page.packed(drawn, level=1, layers=list(layers), readouts=told)
        return json.dumps({"kind": "scene", "data": data, "moves": moves})

    def _whole(self) -> Animation:
        drawn = scenes.arm_scene(self.arm, self.motion)
        items = [item for item in drawn.items if item.layer not in LAYERS]
        items += [item for name in LAYERS for item in self._items(name)]
        return replace(drawn, items=tuple(items), readouts=self._readouts())

    def _readouts(self) -> dict[str, Any] | None:
        return scenes.readouts(self.arm, self.motion, self.scene, self.wanted)

    def _items(self, layer: str) -> Iterable[Item]:
        if layer == Layer.DEMONSTRATIONS:
            return scenes.demonstration_items(self.arm, self.demonstrations)
        if layer == Layer.OBSTACLES:
            return [scenes.obstacle_item(shape, i) for i, shape in enumerate(self.scene.shapes)]
        if layer == Layer.SPREAD:
            return scenes.spread_items(self.arm, self.skill)
        if layer == Layer.VIA:
            return scenes.via_items(self.via)
        if layer == Layer.MODES:
            return scenes.mode_items(self.others)
        marked = self.goal if layer == Layer.GOAL else self.path
        return [] if marked is None else [_MARKS[Layer(layer)](marked)]

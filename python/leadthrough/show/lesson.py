"""A lesson on a live page: the skill of demonstrations, and the command that goes on from there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from leadthrough.arm import Arm
from leadthrough.check import InvalidInput
from leadthrough.models.learn import learn, reproduction
from leadthrough.models.protocol import contradicting
from leadthrough.motion import Demonstration, PoseTrajectory
from leadthrough.shapes import Scene
from leadthrough.shapes.shape import Primitive, option_numbers
from leadthrough.show.replanner import Replanner


@dataclass(frozen=True, eq=False)
class Learned:
    """A skill of the demonstrations, and how near it comes to them."""

    planner: Replanner
    text: str


def learned(arm: Arm, demonstrations: Sequence[Demonstration[Any]], scene: Scene) -> Learned:
    """The skill of joint motions, as poses of the tip."""
    poses: list[Demonstration[PoseTrajectory]] = [
        Demonstration(arm.poses(each.motion), each.name) for each in demonstrations
    ]
    if found := contradicting([each.motion for each in poses]):
        texts = (f"{poses[i].name}: {text}" for i, text in found.items())
        raise InvalidInput(f"{'; '.join(texts)}; delete it, or trim it, and press Learn again")
    skill = learn(poses, outliers="keep")
    near = reproduction(skill, poses)
    family = type(skill.model).__name__
    text = f"Learned by {family}, within {1e3 * near.position:.3g} mm of every demonstration."
    return Learned(Replanner(arm, skill, scene=scene, demonstrations=poses), text)


def plan_command(planner: Replanner, skill_path: Path, scene: Scene) -> str:
    """The command that plans with a saved skill as the page does now, without meshes and clouds."""
    words = ["leadthrough plan", str(skill_path)]
    for name in ("start", "goal"):
        end = planner.end(name)
        if end is not None and end.moved:
            parts = [end.position] if end.orientation is None else [end.position, end.orientation]
            words.append(f"--{name}={'/'.join(map(option_numbers, parts))}")
    words += (f"--obstacle {s.option()}" for s in scene.shapes if isinstance(s, Primitive))
    return " ".join([*words, "-o", "motion.json"])

"""Base poses from which an arm can run a motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from leadthrough import check, rotations
from leadthrough.arm import Arm
from leadthrough.check import Float64Array, IkFailure, InvalidInput, ShortRepr
from leadthrough.models import Skill, TargetRegion
from leadthrough.motion import JointTrajectory, Motion, PoseTrajectory
from leadthrough.reachability.reach_map import reached
from leadthrough.shapes import Scene

_SAMPLES = 25  # of the motion, that are looked at from each place
_FOLLOWED = 20  # of the best places, which are tried until one is found from which it is run


@dataclass(frozen=True, eq=False)
class Placement(ShortRepr):
    """Fraction of a motion that an arm reaches, by base pose.

    Attributes:
        bases: (n, 4) places of the base, x, y, z in m and the yaw in rad, in the motion's frame.
        fraction: (n,) of the motion's samples that are reached from there.
        manipulability: (n,) the smallest along the motion; 0 where a sample is out of reach.
        best: (4,) the place with the largest one from which the arm follows the whole motion; None
            if there is none.
        joints: of the arm along the motion from there; None likewise.
    """

    bases: Float64Array
    fraction: Float64Array
    manipulability: Float64Array
    best: Float64Array | None
    joints: JointTrajectory | None


def place_base(
    motion: Skill[Motion] | PoseTrajectory,
    arm: Arm,
    *,
    area: TargetRegion,
    spacing: float = 0.1,
    yaws: int = 8,
    seed: int = 0,
) -> Placement:
    """The base pose from which an arm runs a motion of poses with the best manipulability.

    Args:
        motion: poses, or a skill of poses, whose own motion is taken; in a frame that stays.
        arm: with collision shapes.
        area: corners of where the base may stand, x, y and z, m in the motion's frame.
        spacing: between neighbouring places, m, > 0.
        yaws: number of directions that the base faces, evenly spread, >= 1.
        seed: of the random number generator.

    Raises:
        InvalidInput: if the motion is not of poses.
        InvalidRobot: if the robot has no collision geometry.
    """
    poses = motion if isinstance(motion, PoseTrajectory) else motion.generate()
    if not isinstance(poses, PoseTrajectory):
        raise InvalidInput(f"motion: expected poses, got {type(poses).__name__}")
    if len(area.lower) != 3:
        raise InvalidInput(f"area: expected 3 coordinates, got {len(area.lower)}")
    bases = _bases(area, check.number(spacing, "spacing", above=0.0), yaws)
    some = np.linspace(0, len(poses) - 1, min(_SAMPLES, len(poses))).round().astype(int)
    seen = [_seen_from(base, poses) for base in bases]
    positions = np.concatenate([each.positions[some] for each in seen])
    turned = np.concatenate([each.orientations[some] for each in seen])
    found, joints = reached(
        arm, positions, turned, Scene(), check.integer(seed, "seed", at_least=0)
    )
    measure = np.zeros(len(found))
    if found.any():
        measure[found] = arm.manipulability(joints[found])
    fraction = found.reshape(len(bases), -1).mean(axis=1)
    least = measure.reshape(len(bases), -1).min(axis=1)
    for i in np.argsort(-least, kind="stable")[:_FOLLOWED]:
        if least[i] <= 0.0:
            break
        try:
            followed = arm.follow(seen[i], q0=joints[i * len(some)])
        except IkFailure:
            continue
        if arm.check(followed).ok:
            return Placement(bases, fraction, least, bases[i], followed)
    return Placement(bases, fraction, least, None, None)


def _bases(area: TargetRegion, spacing: float, yaws: int) -> Float64Array:
    """All places of a grid with all yaws, (n, 4)."""
    axes = [
        low + spacing * np.arange(int(np.floor((high - low) / spacing + 1e-9)) + 1)
        for low, high in zip(area.lower, area.upper, strict=True)
    ]
    count = check.integer(yaws, "yaws", at_least=1)
    axes.append(2.0 * np.pi * np.arange(count) / count)
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 4)


def _seen_from(base: Float64Array, poses: PoseTrajectory) -> PoseTrajectory:
    """The motion in the frame of a base that stands at (x, y, z) and faces a yaw."""
    turn = rotations.exp(np.array([[0.0, 0.0, -base[3]]]))
    matrix = rotations.to_matrix(turn)[0]
    return PoseTrajectory(
        poses.times,
        (poses.positions - base[:3]) @ matrix.T,
        rotations.compose(turn.repeat(len(poses), axis=0), poses.orientations),
    )

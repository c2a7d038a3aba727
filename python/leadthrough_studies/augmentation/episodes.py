"""Episodes to train a policy on: three demonstrations, and as many as wanted made of them.

All begin in one configuration of a Panda and end at rest at a goal on either side of a region. The
goal of an episode is the position of the tip at its end.

Source: Laskey et al. 2017, "DART", for noise; Mandlekar et al. 2023, "MimicGen", section 4 and
appendix N.2, for shifting.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

from leadthrough import rotations
from leadthrough.arm import Arm
from leadthrough.augmentation import augment
from leadthrough.check import Float64Array
from leadthrough.io import stream_recordings
from leadthrough.models import DMP
from leadthrough.motion import PoseTrajectory
from leadthrough.shapes import Box
from leadthrough.trajectories import minimum_jerk_time_scaling
from leadthrough.validation import TargetRegion
from leadthrough_studies.demonstrator import Teaching, guide

RATE = 30.0  # Hz, of episodes and actions
CHUNK = 30  # actions
HOME = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7])  # rad
TABLE = Box((1.2, 1.6, 0.05), (0.7, 0.0, -0.1))
GOALS = TargetRegion(np.array([0.45, -0.25, 0.1]), np.array([0.65, 0.25, 0.3]))
_SHOWN = ((0.5, -0.15, 0.15), (0.6, 0.0, 0.25), (0.5, 0.15, 0.2))  # m, goals of demonstrations
_TEACHING = Teaching(duration=3.0, spread=0.0, bow=0.03, tremor=0.0005)
_LIFT = 0.05  # m, of the middle of a demonstration above the line between its ends
_NOISE = 0.05  # rad, standard deviation of a joint in the middle of an episode
_NOISE_WAVES = 3  # half waves of a smooth disturbance
_SEGMENT = 0.5  # fraction of a demonstration that is shifted with the goal
_STEP = 0.2  # rad between two rows at most; more is a jump to another posture

# Joints (n, joints) and chunks of the joints that follow (n, CHUNK, joints), rad.
Episode = tuple[Float64Array, Float64Array]


def demonstrations(arm: Arm, rng: np.random.Generator) -> list[PoseTrajectory]:
    """Three simulated demonstrations of a person, from home to goals in the region."""
    start, orientation = (each[0] for each in arm.forward_kinematics(HOME[None]))
    shown = []
    for goal in np.array(_SHOWN):
        middle = 0.5 * (start + goal) + [0.0, 0.0, _LIFT]
        motion = guide(np.array([start, middle, goal]), _TEACHING, rng).motion
        times = np.arange(round(_TEACHING.duration * RATE) + 1) / RATE
        points = np.column_stack([np.interp(times, motion.times, x) for x in motion.positions.T])
        tip = PoseTrajectory(times, points, np.tile(orientation, (len(times), 1)))
        shown.append(arm.poses(arm.follow(tip, q0=HOME)))
    return shown


def recorded(arm: Arm, shown: list[PoseTrajectory], count: int, seed: int) -> list[Episode]:
    """The demonstrations as they are."""
    del count, seed
    return [followed(_joints(arm, each)) for each in shown]


def ours(arm: Arm, shown: list[PoseTrajectory], count: int, seed: int) -> list[Episode]:
    """Episodes of `lt.augment` of a DMP learned from the demonstrations."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "episodes"
        skill = DMP().fit(shown)
        augment(skill, arm, [TABLE], episodes=count, out=out, goals=GOALS, seed=seed, rate=RATE)
        read = (each.recording for each in stream_recordings(out))
        return [followed(each.positions) for each in read if each is not None]


def noise(arm: Arm, shown: list[PoseTrajectory], count: int, seed: int) -> list[Episode]:
    """Demonstrations with smooth disturbances, from which the actions go back."""
    rng = np.random.default_rng(seed)
    paths = [_joints(arm, each) for each in shown]
    return [disturbed(paths[i % len(paths)], rng) for i in range(count)]


def shifting(arm: Arm, shown: list[PoseTrajectory], count: int, seed: int) -> list[Episode]:
    """Segments moved with the goal; those out of reach or in contact are discarded."""
    rng = np.random.default_rng(seed)
    found: list[Episode] = []
    while len(found) < count:
        source = shown[rng.integers(len(shown))]
        position, turn = rng.uniform(GOALS.lower, GOALS.upper), source.orientations[-1]
        q = solved(arm, shifted(source, position, turn))
        if q is not None and arm.check(q, [TABLE]).ok:
            found.append(followed(q))
    return found


DATA_SETS: dict[str, Callable[[Arm, list[PoseTrajectory], int, int], list[Episode]]] = {
    "demonstrations": recorded,
    "ours": ours,
    "noise": noise,
    "shifting": shifting,
}


def followed(q: Float64Array) -> Episode:
    """An episode whose chunks are the joints that follow, with a second of rest at the end."""
    rested = np.vstack([q, np.tile(q[-1], (CHUNK, 1))])
    ahead = np.arange(len(rested))[:, None] + np.arange(1, CHUNK + 1)
    return rested, rested[np.minimum(ahead, len(rested) - 1)]


def disturbed(q: Float64Array, rng: np.random.Generator) -> Episode:
    """An episode beside a path (n, joints), whose chunks lead back to it with minimum jerk."""
    path, wanted = followed(q)
    waves = np.sin(np.pi * np.outer(np.linspace(0.0, 1.0, len(path)), 1 + np.arange(_NOISE_WAVES)))
    scale = _NOISE / np.sqrt(0.5 * _NOISE_WAVES)
    away = waves @ rng.normal(0.0, scale, (_NOISE_WAVES, path.shape[1]))
    left = 1.0 - minimum_jerk_time_scaling(np.arange(1, CHUNK + 1) / CHUNK)
    return path + away, wanted + left[:, None] * away[:, None, :]


def shifted(
    source: PoseTrajectory, position: Float64Array, orientation: Float64Array
) -> PoseTrajectory:
    """The last segment moved rigidly with the goal, and a straight line from the start to it."""
    first = round((1.0 - _SEGMENT) * (len(source.times) - 1))
    own = source.orientations[first:]
    turn = rotations.compose(orientation[None], rotations.inverse(source.orientations[-1:]))
    arms = source.positions[first:] - source.positions[-1]
    points = position + arms @ rotations.to_matrix(turn)[0].T
    turns = rotations.compose(np.tile(turn, (len(own), 1)), own)
    rise = np.arange(first) / first
    line = source.positions[0] + rise[:, None] * (points[0] - source.positions[0])
    before, after = (np.tile(each, (first, 1)) for each in (source.orientations[0], turns[0]))
    turning = rotations.slerp(before, after, rise)
    return PoseTrajectory(source.times, np.vstack([line, points]), np.vstack([turning, turns]))


def solved(arm: Arm, motion: PoseTrajectory) -> Float64Array | None:
    """Joints (n, joints) of poses, each nearest to those before; None if one is not reached."""
    rows = [HOME]
    for position, orientation in zip(motion.positions, motion.orientations, strict=True):
        found = arm.inverse_kinematics(position, orientation, q0=rows[-1])
        if not found.success or np.abs(found.q - rows[-1]).max() > _STEP:
            return None
        rows.append(found.q)
    return np.array(rows[1:])


def _joints(arm: Arm, motion: PoseTrajectory) -> Float64Array:
    return arm.follow(motion, q0=HOME).positions

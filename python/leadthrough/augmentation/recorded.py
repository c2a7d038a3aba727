"""Recorded demonstrations of an arm as a data set for policies, as they were recorded."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from leadthrough import check
from leadthrough.arm import Arm, check_arm
from leadthrough.augmentation.data_set import GOAL_POSE, gripper_states, opens, sampled
from leadthrough.check import Float64Array
from leadthrough.io.episode_writers import writing
from leadthrough.io.episodes import Episode, Layout
from leadthrough.motion import Demonstration, JointTrajectory
from leadthrough.preprocess.resample import check_sample_count, several_samples
from leadthrough.shapes import SceneLike, as_scene


def write_data_set(
    demonstrations: Sequence[Demonstration[JointTrajectory] | JointTrajectory],
    arm: Arm,
    out: str | Path,
    scene: SceneLike = (),
    *,
    rate: float = 50.0,
    task: str = "reach the goal",
) -> Path:
    """The data set of demonstrations, an episode each, that policies can learn from.

    It has the columns of `lt.augment`: joints, the tip's poses, the gripper by events such as
    "close gripper", and the poses of the goal, where a demonstration ends, and the obstacles'
    positions; images are not made.

    Args:
        demonstrations: joint motions of the arm, at least one, each of two samples or more.
        out: folder of a LeRobot data set of version 3, which must not be there yet; or an HDF5
            file, ".hdf5" or ".h5".
        scene: obstacles in the arm's base frame.
        rate: frames per second, > 0. Durations become whole numbers of frames.
        task: of all episodes, in words.

    Raises:
        InvalidInput: if there is no demonstration or one is not of the arm's joints, if the rate
            asks for too many frames, or the data set cannot be written.
        MissingDependency: if the extra `lerobot` or `hdf5` is not installed.
    """
    check_arm(arm)
    frames = check.number(rate, "rate", above=0.0)
    if not isinstance(task, str):
        raise check.refused("task", "words", repr(task))
    if not isinstance(demonstrations, Sequence) or not demonstrations:
        got = type(demonstrations).__name__ if demonstrations else "none"
        raise check.refused("demonstrations", "a sequence of at least one", got)
    given = [several_samples(each) for each in demonstrations]
    motions = [arm.joints_of(each.motion) for each in given]
    for motion in motions:
        check_sample_count(motion.duration, frames)
    places = [shape.position for shape in as_scene(scene).shapes]
    names = [f"obstacle_{i}_{axis}" for i in range(len(places)) for axis in "xyz"]
    grips = any(opens(event.name) is not None for each in motions for event in each.events)
    layout = Layout(
        *(arm.robot.name, arm.joint_names, (*GOAL_POSE, *names), grips, frames, task),
        {"demonstrations": [each.name for each in given], "images": "none"},
    )
    with writing(out, layout) as writer:
        for each, motion in zip(given, motions, strict=True):
            rows = sampled(motion, frames)
            writer.add(_episode(rows, arm, layout, np.ravel(places), each.name))
    return Path(out)


def _episode(
    rows: JointTrajectory, arm: Arm, layout: Layout, places: Float64Array, name: str
) -> Episode:
    positions, orientations = arm.forward_kinematics(rows.positions)
    events = [(event.time, event.name) for event in rows.events]
    assert rows.velocities is not None  # of a spline
    return Episode(
        rows.positions,
        rows.velocities,
        np.hstack([positions, orientations[:, [1, 2, 3, 0]]]),
        gripper_states(events, len(rows), layout.rate) if layout.has_gripper else None,
        np.concatenate([positions[-1], orientations[-1], places]),
        {"demonstration": name},
    )

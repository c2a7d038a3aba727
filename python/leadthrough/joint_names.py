"""Joints matched by their names: another order is permuted, other names are refused."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from leadthrough import check
from leadthrough.motion import JointTrajectory, Motion, MotionT, rows_of


def in_order(motion: object, names: Sequence[str], argument: str) -> JointTrajectory:
    """The joints as columns in the order of `names`; columns without names are in this order.

    Every function that takes joints of an arm or of limits takes them through this one.

    Raises:
        InvalidInput: for other joints, or another kind of motion.
    """
    if not isinstance(motion, JointTrajectory):
        what = f"{type(motion).__name__}{check.part_to_give(motion)}"
        raise check.refused(argument, "a JointTrajectory", what)
    wanted = tuple(names)
    if motion.joint_names == wanted:
        return motion
    if not motion.joint_names:
        if (count := motion.positions.shape[1]) != len(wanted):
            expected = f"{len(wanted)} joints ({', '.join(wanted)})"
            raise check.refused(argument, expected, f"{count} without names")
        return replace(motion, joint_names=wanted)
    return _selected(motion, wanted, argument)


def alike(motions: Sequence[MotionT], argument: str) -> list[MotionT]:
    """The motions with their joints, those beside a tip's too, in the order of the first's."""
    named = [joints.joint_names for each in motions if (joints := _of_arm(each)) is not None]
    return [
        _like(each, named[0], f"{argument}[{i}]") if named else each
        for i, each in enumerate(motions)
    ]


def _of_arm(motion: Motion) -> JointTrajectory | None:
    """The joints that a motion consists of, or that go along with it."""
    return motion if isinstance(motion, JointTrajectory) else motion.joints


def _like(motion: MotionT, names: tuple[str, ...], argument: str) -> MotionT:
    joints = _of_arm(motion)
    if joints is None or joints.joint_names == names:
        return motion
    ordered: Any = _selected(joints, names, argument)
    return ordered if joints is motion else replace(motion, joints=ordered)


def _selected(joints: JointTrajectory, names: tuple[str, ...], argument: str) -> JointTrajectory:
    """The joints with their named columns in the order of `names`."""
    return columns_of(joints, check.column_order(joints.joint_names, names, argument), names)


def columns_of(
    joints: JointTrajectory, columns: Sequence[int], names: tuple[str, ...]
) -> JointTrajectory:
    """Some columns of a motion, which have names of their own."""
    rows = {name: rows[:, columns] for name, rows in rows_of(joints).items()}
    return replace(joints, joint_names=names, **rows)

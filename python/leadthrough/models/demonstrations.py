"""Demonstrations as models take them: checked once, with one wording of each error."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np

from leadthrough import sanity
from leadthrough.check import FitError, Float64Array, InvalidInput
from leadthrough.motion import (
    Demonstration,
    JointTrajectory,
    Motion,
    MotionT,
    PoseTrajectory,
    Trajectory,
    alike,
)
from leadthrough.preprocess.align import lateness

# Argument of every `fit`: demonstrations, or the motions alone.
Demonstrations: TypeAlias = Sequence[Demonstration[MotionT] | MotionT]

KINDS = (Trajectory, PoseTrajectory, JointTrajectory)
# Products of numbers beyond this overflow.
MAX_NUMBER = 1e100
# Demonstrations that are late by this fraction of the latest one are named.
_NAMED = 0.6


class MisalignmentWarning(UserWarning):
    """Demonstrations are misaligned in time: the message names them and the remedy."""


def motions_of(
    demonstrations: Demonstrations[MotionT],
    *,
    kinds: tuple[type[Motion], ...] = KINDS,
    at_least: int = 1,
) -> list[MotionT]:
    """The motions of demonstrations, all of one type and size, each of which moves."""
    if not isinstance(demonstrations, Sequence):
        raise InvalidInput(
            "demonstrations: expected a sequence of demonstrations, got one "
            f"{type(demonstrations).__name__}; put a single one in a list"
        )
    if len(demonstrations) < at_least:
        raise FitError(
            f"demonstrations: expected at least {at_least}, got {len(demonstrations) or 'none'}"
        )
    motions: list[Any] = [_motion(each, i, kinds) for i, each in enumerate(demonstrations)]
    _refuse_mixed(motions)
    motions = alike(motions, "demonstrations")
    for i, motion in enumerate(motions):
        _refuse_unfit(motion, f"demonstrations[{i}]")
        sanity.clock(motion.times, f"demonstrations[{i}]")
    return motions


def _motion(demonstration: object, index: int, kinds: tuple[type[Motion], ...]) -> object:
    motion = demonstration.motion if isinstance(demonstration, Demonstration) else demonstration
    if not isinstance(motion, kinds):
        names = " or ".join(kind.__name__ for kind in kinds)
        convertible = isinstance(motion, JointTrajectory) and PoseTrajectory in kinds
        advice = "; arm.poses(motion) makes poses of joints" if convertible else ""
        raise InvalidInput(
            f"demonstrations[{index}]: expected a Demonstration of a {names}, "
            f"got {type(motion).__name__}{advice}"
        )
    return motion


def _refuse_mixed(motions: Sequence[Motion]) -> None:
    for what, values in (
        ("one type of motion", {type(motion).__name__ for motion in motions}),
        ("the same number of columns", {motion.positions.shape[1] for motion in motions}),
    ):
        if len(values) > 1:
            got = " and ".join(str(value) for value in sorted(values))
            raise InvalidInput(f"demonstrations: expected {what} in all, got {got}")


def _refuse_unfit(motion: Motion, name: str) -> None:
    if len(motion.times) < 2:
        raise FitError(f"{name}: has a single sample, needs at least two; leave it out")
    turns = isinstance(motion, PoseTrajectory) and not _is_still(motion.orientations)
    if _is_still(motion.positions) and not turns:
        raise FitError(f"{name}: does not move; leave it out")
    if np.abs(motion.positions).max() > MAX_NUMBER:
        raise FitError(f"{name}: has numbers beyond {MAX_NUMBER:.0e}; use another unit")
    if not turns and np.ptp(motion.positions, axis=0).max() < 1.0 / MAX_NUMBER:
        raise FitError(f"{name}: moves by less than {1.0 / MAX_NUMBER:.0e}; use another unit")


def _is_still(rows: Float64Array) -> bool:
    return bool((rows == rows[0]).all())


def warn_of_misalignment(motions: Sequence[Motion]) -> None:
    """Warns of demonstrations with the same path at different times, which a mean blurs."""
    late = lateness(motions)
    if not late.any():
        return
    named = [i for i, each in enumerate(late) if each >= _NAMED * late.max()]
    sanity.warn(
        f"demonstrations {named}: misaligned, up to {late.max():.0%} of the duration ahead of or "
        "behind the mean timing of all, so that the fit blurs them; align them with "
        "preprocess.align_by_time_warping, or leave them out",
        MisalignmentWarning,
    )

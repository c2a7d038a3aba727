"""One motion from several demonstrations: their mean over normalised time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from leadthrough import events, rotations
from leadthrough.check import Float64Array
from leadthrough.errors import FitError, InvalidInput
from leadthrough.events import Event
from leadthrough.motion import (
    Demonstration,
    JointTrajectory,
    Motion,
    PoseTrajectory,
    normalised_times,
)

# Beyond this, products of numbers overflow.
LARGEST = 1e100


@dataclass(frozen=True, eq=False)
class MeanMotion:
    """What primitives are fitted to.

    phases: (n,) from 0 to 1. positions: (n, d). orientations: (n, 4) w, x, y, z, or None.
    duration: s. joint_names: of joint motions, else None. events: at phases.
    """

    phases: Float64Array
    positions: Float64Array
    orientations: Float64Array | None
    duration: float
    joint_names: tuple[str, ...] | None
    events: tuple[Event, ...] = ()

    @property
    def size(self) -> float:
        """Diagonal of the box around the positions, in their unit."""
        return float(np.linalg.norm(np.ptp(self.positions, axis=0)))


def mean_motion(demonstrations: Sequence[Demonstration], kinds: tuple[type, ...]) -> MeanMotion:
    """The mean of at least one demonstration, all of the same one of the kinds of motion.

    One alone is taken as it is, sample by sample. Several are stretched to their mean duration and
    averaged, positions and rotations, at as many even times as the longest has samples; the events
    are those that most of them have.
    Raises InvalidInput for others, FitError for one that does not move or where the orientations of
    several lie too far apart for a mean.
    """
    motions = _alike(demonstrations, kinds)
    for i, motion in enumerate(motions):
        if not _moves(motion):
            raise FitError(f"demonstrations[{i}]: does not move")
        if np.abs(motion.positions).max() > LARGEST:
            raise FitError(f"demonstrations[{i}]: has numbers beyond {LARGEST:.0e}")
    first = motions[0]
    names = first.joint_names if isinstance(first, JointTrajectory) else None
    shares = [events.moved(each.events, each.times[[0, -1]], (0.0, 1.0)) for each in motions]
    happened = events.agreed(shares)
    if len(motions) == 1:
        turned = first.orientations if isinstance(first, PoseTrajectory) else None
        return MeanMotion(
            normalised_times(first.times), first.positions, turned, first.duration, names, happened
        )
    count = max(len(motion.times) for motion in motions)
    phases = np.linspace(0.0, 1.0, count)
    positions = np.mean([_positions_at(motion, phases) for motion in motions], axis=0)
    duration = float(np.mean([motion.duration for motion in motions]))
    return MeanMotion(phases, positions, _mean_turn(motions, phases), duration, names, happened)


def _alike(demonstrations: Sequence[Demonstration], kinds: tuple[type, ...]) -> list[Motion]:
    if isinstance(demonstrations, Demonstration) or not isinstance(demonstrations, Sequence):
        got = type(demonstrations).__name__
        raise InvalidInput(f"demonstrations: expected a sequence of them, got {got}")
    if len(demonstrations) == 0:
        raise FitError("demonstrations: expected at least one, got none")
    motions = [_motion(each, i, kinds) for i, each in enumerate(demonstrations)]
    for what, values in (
        ("one type of motion", {type(motion).__name__ for motion in motions}),
        ("the same number of columns", {motion.positions.shape[1] for motion in motions}),
        ("the same joint names", {getattr(motion, "joint_names", ()) for motion in motions}),
    ):
        if len(values) > 1:
            raise InvalidInput(f"demonstrations: expected {what} in all, got {sorted(values)}")
    return motions


def _motion(demonstration: Any, index: int, kinds: tuple[type, ...]) -> Any:
    motion: Any = getattr(demonstration, "motion", None)
    name = f"demonstrations[{index}]"
    if type(motion) not in kinds:
        wanted = " or a ".join(kind.__name__ for kind in kinds)
        got = type(motion if motion is not None else demonstration).__name__
        raise InvalidInput(f"{name}: expected one with a {wanted}, got {got}")
    if len(motion.times) < 2:
        raise FitError(f"{name}: has a single sample, needs at least two")
    return motion


def _moves(motion: Motion) -> bool:
    if (motion.positions != motion.positions[0]).any():
        return True
    if not isinstance(motion, PoseTrajectory):
        return False
    return bool((motion.orientations != motion.orientations[0]).any())


def _positions_at(motion: Motion, phases: Float64Array) -> Float64Array:
    own = normalised_times(motion.times)
    return np.column_stack([np.interp(phases, own, column) for column in motion.positions.T])


def _mean_turn(motions: Sequence[Motion], phases: Float64Array) -> Float64Array | None:
    layers = [
        rotations.interpolate(normalised_times(motion.times), motion.orientations, phases)
        for motion in motions
        if isinstance(motion, PoseTrajectory)
    ]
    if not layers:
        return None
    try:
        return rotations.align_signs(rotations.mean(np.stack(layers)))
    except InvalidInput as error:
        raise FitError(f"demonstrations: have no mean orientation ({error})") from None

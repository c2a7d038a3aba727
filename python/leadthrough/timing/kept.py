"""What leaves is checked: differences of the samples keep the limits, or an error is raised."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from leadthrough import _core
from leadthrough.arm.limits import JointLimits
from leadthrough.check import Float64Array
from leadthrough.errors import LimitsInfeasible
from leadthrough.timing.binding import Kind
from leadthrough.timing.rates import AT_REST
from leadthrough.timing.request import POSITION_ROUNDING
from leadthrough.timing.samples import Samples

# A limit may be exceeded by this, relative to it. Time laws are computed to half of it.
_EXCESS = 1e-6
# How far differences of order 3 reach beyond a sample, and how many copies of it part them.
_REACH, _COPIES = 3, 2
_MOST_PASSES = 10
_TIGHTER = 0.999
_EPSILON = float(np.finfo(np.float64).eps)
_KINDS: tuple[Kind, ...] = ("velocity", "acceleration", "jerk")


def parted(motion: Samples, limits: JointLimits, rate: float) -> Samples:
    """The motion with longer rests where the jerks before and after one add up beyond a limit."""
    for _ in range(_MOST_PASSES):  # more than one where a section has but a step or two
        longer = _parted(motion, limits, rate)
        if longer is motion:
            break
        motion = longer
    return motion


@dataclass(frozen=True)
class Excess:
    """The limit that samples exceed the most."""

    joint: str  # name of the joint
    kind: Kind  # which of its limits
    ratio: float  # by how many times
    time: float  # when, s from the start

    def error(self) -> LimitsInfeasible:
        """The error that says so."""
        return LimitsInfeasible(
            f"no motion was found that keeps the limits: {self.joint} would come to "
            f"{self.ratio:.6g} times its {self.kind} limit {self.time:.6g} s after the start; "
            "please report this path",
            joint=self.joint,
        )


def check_positions(
    positions: Float64Array, limits: JointLimits
) -> tuple[Float64Array, Float64Array]:
    """The least and the largest position (joints,) of each joint."""
    least, largest = _core.extent(positions)
    outside = np.maximum(limits.lower - least, largest - limits.upper)
    if outside.max() > POSITION_ROUNDING:
        i = int(np.argmax(outside))
        name = limits.joint_names[i]
        raise LimitsInfeasible(
            f"{name} leaves its position limits along the path, by {outside[i]:.3g}; a smooth path "
            "may do so between samples that keep them",
            joint=name,
        )
    return least, largest


def excess(motion: Samples, limits: JointLimits, *, rests: tuple[bool, bool]) -> Excess | None:
    """What the samples exceed, or None."""
    positions = np.ascontiguousarray(motion.positions)
    least, largest = check_positions(positions, limits)
    still = largest - least <= AT_REST
    order, sample, joint, ratio = _core.largest_use(
        motion.times,
        positions,
        np.ascontiguousarray(motion.velocities),
        np.ascontiguousarray(motion.accelerations),
        *rests,
        *(_own(limit, still) for limit in (limits.velocity, limits.acceleration, limits.jerk)),
    )
    if ratio <= 1.0 + _EXCESS:
        return None
    return Excess(limits.joint_names[joint], _KINDS[order - 1], ratio, float(motion.times[sample]))


def tightened(limits: JointLimits, found: Excess) -> JointLimits:
    """The limits, with all of the kind that was exceeded smaller by that and a little more."""
    limit = getattr(limits, found.kind)
    return replace(limits, **{found.kind: limit * (_TIGHTER / found.ratio)})


def _parted(motion: Samples, limits: JointLimits, rate: float) -> Samples:
    last = len(motion.times) - 1
    rows = _core.stops(
        np.ascontiguousarray(motion.positions), np.ascontiguousarray(motion.velocities)
    )
    if not len(rows):
        return motion
    around = np.clip(rows[:, None] + np.arange(-_REACH, _REACH + 1), 0, last)
    q = motion.positions[around]
    copies = np.zeros(len(rows), dtype=np.intp)
    for some in range(_COPIES):
        tight = np.flatnonzero(copies == some)
        repeated = np.repeat(q[tight], [1] * _REACH + [1 + some] + [1] * _REACH, axis=1)
        copies[tight[_exceeds(repeated, limits, rate)]] += 1
    return motion.with_rests(rows, copies / rate, rate)


def _own(limit: Float64Array | None, still: NDArray[np.bool_]) -> Float64Array:
    """The limits of joints that move; those at rest may have one of 0."""
    assert limit is not None
    return np.where(still & (limit == 0.0), np.inf, limit)


def _exceeds(q: Float64Array, limits: JointLimits, rate: float) -> NDArray[np.bool_]:
    """Which of the rests (m,) differences of their samples (m, k, joints) exceed limits around."""
    size = np.abs(q).max(axis=(0, 1), initial=0.0)
    exceeds = np.zeros(len(q), dtype=np.bool_)
    for order, limit in ((2, limits.acceleration), (3, limits.jerk)):
        assert limit is not None
        rounding = 2.0**order * _EPSILON * size
        used = (np.abs(np.diff(q, order, axis=1)).max(axis=1) - rounding) * rate**order
        exceeds |= ((used > limit * (1.0 + 0.5 * _EXCESS)) & (limit > 0.0)).any(axis=1)
    return exceeds

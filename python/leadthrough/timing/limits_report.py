"""Joint limits along a motion: one verdict, and the limit that binds when.

A controller such as ROS 2's joint trajectory controller runs the quintic Hermite curve through the
positions, velocities and accelerations of the samples. That curve is judged: its positions,
velocities and accelerations everywhere, by the extremes of its polynomials, and its jerk as the
difference of the acceleration over one sample. Arrays that are missing are filled as
`with_derivatives` states. The arm is taken to stand still before the first sample and after the
last: a motion that starts or ends at speed shows the acceleration and jerk that this takes.

A receiver of positions alone interpolates linearly at its own rate: that is judged by the
differences of the positions at that rate.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np

from leadthrough import _core, check
from leadthrough.arm.limits import JointLimits
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.drawing import Drawn, Panel, bars
from leadthrough.errors import LimitsInfeasible
from leadthrough.motion import JointTrajectory, computed_joints, with_derivatives
from leadthrough.repr import ShortRepr
from leadthrough.timing.request import POSITION_ROUNDING

Kind = Literal["velocity", "acceleration", "jerk"]
KINDS: tuple[Kind, ...] = ("velocity", "acceleration", "jerk")
# A ratio above 1 by less is rounding: differences of accelerations sampled at 1 kHz carry 1e-9
# rad/s^3 of it, and a position given with seven digits 1e-7 rad.
ROUNDING = 1e-6
# A limit binds from this fraction of it on: the rest is the time law's own margin.
_BINDS = 0.95
_MAX_BAR = 3.0  # of a drawing, in multiples of the limit


@dataclass(frozen=True, eq=False)
class Peak(ShortRepr):
    """How much of one quantity's limits a trajectory uses at most.

    Attributes:
        ratios: largest magnitude of each joint over its limit, (joints,); of a position, the
            distance from the middle of the range over half the range.
        joint: name of the joint with the largest ratio.
        time: when it is reached, s.
    """

    ratios: Float64Array
    joint: str
    time: float

    @property
    def ok(self) -> bool:
        """Whether no joint exceeds its limit by more than rounding."""
        return self.ratio <= 1.0 + ROUNDING

    @property
    def ratio(self) -> float:
        """The worst joint's ratio."""
        return float(self.ratios.max())

    def __str__(self) -> str:
        return f"{self.ratio:.1%} by {self.joint} at {self.time:.3f} s"


@dataclass(frozen=True, eq=False)
class LimitsReport(Drawn):
    """A trajectory's peaks.

    Attributes:
        position: of the range of each joint.
        velocity: of the velocity limits.
        acceleration: of the acceleration limits; None if there are none.
        jerk: of the jerk limits; None if there are none.
    """

    position: Peak
    velocity: Peak
    acceleration: Peak | None
    jerk: Peak | None

    @property
    def ok(self) -> bool:
        """Whether every quantity that has limits satisfies them."""
        return all(peak is None or peak.ok for peak in self._peaks().values())

    @property
    def unchecked(self) -> tuple[str, ...]:
        """The quantities without limits."""
        return tuple(name for name, peak in self._peaks().items() if peak is None)

    def _peaks(self) -> dict[str, Peak | None]:
        return {name: getattr(self, name) for name in ("position", *KINDS)}

    def _repr_parts(self) -> list[str]:
        used = [f"{name} {peak or 'not checked'}" for name, peak in self._peaks().items()]
        return [f"ok={self.ok}", *used]

    def _panels(self) -> list[Panel]:
        rows = [
            (name, 0.0, min(peak.ratio, _MAX_BAR))
            for name, peak in self._peaks().items()
            if peak is not None
        ]
        return [bars(rows, title="limits used", x_label="fraction of the limit", limit=1.0)]


@dataclass(frozen=True)
class Binding:
    """An interval in which one limit is the nearest, and binds throughout or nowhere.

    Attributes:
        start: first time, s.
        end: last time, s.
        joint: name of the joint.
        kind: which of its limits.
        ratio: largest fraction of the limit that is used.
    """

    start: float
    end: float
    joint: str
    kind: Kind
    ratio: float

    @property
    def binds(self) -> bool:
        """Whether the motion could not be faster there: at least 95 % of the limit is used."""
        return self.ratio >= _BINDS


def check_limits(
    trajectory: JointTrajectory, limits: JointLimits, *, linear_rate: float | None = None
) -> LimitsReport:
    """How much of the arm's limits a trajectory uses; exceeding them does not raise.

    Args:
        trajectory: the motion. Missing velocities are the slopes of the cubic spline through the
            positions that starts and ends at rest, missing accelerations those of the cubic spline
            through the velocities.
        linear_rate: rate in Hz of a receiver that runs the positions alone, straight from one to
            the next, such as a script of servoj commands. By default the quintics are judged that
            a controller runs which reads velocities and accelerations too.
    """
    _joint_names(trajectory, limits)
    if linear_rate is None:
        return judged(with_derivatives(trajectory), limits)
    rate = check.number(linear_rate, "linear_rate", above=0.0)
    return _report(_played_straight(trajectory, rate), limits, trajectory.times)


def judged(
    motion: JointTrajectory, limits: JointLimits, *, rests: tuple[bool, bool] = (True, True)
) -> LimitsReport:
    """The verdict on a motion with all arrays, which stands still before and after it, or not."""
    return _report(_extremes(_standing(motion, rests)), limits, motion.times)


def binding_limits(trajectory: JointTrajectory, limits: JointLimits) -> list[Binding]:
    """The limit that is nearest in each stretch of a trajectory, in the order of time.

    A stretch in which the nearest limit binds is separate from one in which it does not.
    """
    joints = _joint_names(trajectory, limits)
    if len(trajectory.times) == 1:
        return []
    used = _extremes(with_derivatives(trajectory))
    ratios = [
        np.zeros_like(used.jerk.values) if limit is None else _ratios(values.values, limit)
        for values, limit in (
            (used.velocity, limits.velocity),
            (used.acceleration, limits.acceleration),
            (used.jerk, limits.jerk),
        )
    ]
    flat = np.hstack(ratios)
    nearest, binds = flat.argmax(axis=1), flat.max(axis=1) >= _BINDS
    changes = np.flatnonzero(np.diff(nearest) | np.diff(binds)) + 1
    return [
        Binding(
            start=float(trajectory.times[first]),
            end=float(trajectory.times[last]),
            joint=joints[int(nearest[first]) % len(joints)],
            kind=KINDS[int(nearest[first]) // len(joints)],
            ratio=float(flat[first:last].max()),
        )
        for first, last in pairwise([0, *changes, len(nearest)])
    ]


def check_type(trajectory: JointTrajectory) -> None:
    """Raises InvalidInput unless `trajectory` is a JointTrajectory."""
    if not isinstance(trajectory, JointTrajectory):
        raise InvalidInput(
            f"trajectory: expected a JointTrajectory, got {type(trajectory).__name__}"
        )


def check_positions(positions: Float64Array, limits: JointLimits) -> None:
    """Raises LimitsInfeasible if a configuration (n, joints) lies outside the position limits."""
    outside = np.maximum(limits.lower - positions, positions - limits.upper).max(axis=0)
    if outside.max() > POSITION_ROUNDING:
        i = int(np.argmax(outside))
        name = limits.joint_names[i]
        raise LimitsInfeasible(
            f"{name} leaves its position limits along the path, by {outside[i]:.3g}; a smooth path "
            "may do so between samples that satisfy them",
            joint=name,
        )


@dataclass(frozen=True, eq=False)
class _Values:
    """The largest magnitudes of a quantity in each step, (steps, joints), and when."""

    values: Float64Array
    times: Float64Array


@dataclass(frozen=True, eq=False)
class _Extremes:
    """What a motion reaches in each of its steps."""

    lowest: _Values
    highest: _Values
    velocity: _Values
    acceleration: _Values
    jerk: _Values


def _joint_names(trajectory: JointTrajectory, limits: JointLimits) -> tuple[str, ...]:
    check_type(trajectory)
    if not isinstance(limits, JointLimits):
        raise InvalidInput(f"limits: expected JointLimits, got {type(limits).__name__}")
    joints = trajectory.positions.shape[1]
    wanted = limits.joint_names
    if len(wanted) != joints:
        raise InvalidInput(f"limits: expected limits of {joints} joints, got {len(wanted)}")
    if trajectory.joint_names and trajectory.joint_names != wanted:
        raise InvalidInput(
            f"limits: expected limits of {list(trajectory.joint_names)}, got {list(wanted)}"
        )
    return wanted


def _extremes(motion: JointTrajectory) -> _Extremes:
    """The extremes of the quintics between the samples of a motion with all arrays."""
    assert motion.velocities is not None
    assert motion.accelerations is not None
    times, arrays = motion.times, (motion.positions, motion.velocities, motion.accelerations)
    if len(times) == 1:
        q, velocity, acceleration = arrays
        rows = (q, q, np.abs(velocity), np.abs(acceleration), np.zeros_like(q))
        return _Extremes(*(_Values(each, np.broadcast_to(times[0], q.shape)) for each in rows))
    values, when = _core.motion_extremes(times, *arrays)
    steps = np.diff(times)[:, None]
    with np.errstate(over="ignore", invalid="ignore"):
        jerks = np.abs(np.diff(motion.accelerations, axis=0)) / steps
    middles = np.broadcast_to(times[:-1, None] + 0.5 * steps, jerks.shape)
    lowest, highest, fastest, hardest = (_Values(*each) for each in zip(values, when, strict=True))
    return _Extremes(lowest, highest, fastest, hardest, _Values(jerks, middles))


def _standing(motion: JointTrajectory, rests: tuple[bool, bool]) -> JointTrajectory:
    """The motion with a step of standing still beyond each end that it passes but should not."""
    assert motion.velocities is not None
    assert motion.accelerations is not None
    times, states = motion.times, (motion.positions, motion.velocities, motion.accelerations)
    begins, ends = (
        rest and bool(states[1][end].any() or states[2][end].any())
        for rest, end in zip(rests, (0, -1), strict=True)
    )
    if len(times) == 1 or not (begins or ends):
        return motion
    pad = (int(begins), int(ends))
    steps = np.diff(times)[[0, -1]]
    beyond = np.concatenate(
        [times[:1][: pad[0]] - steps[0], times, times[-1:][: pad[1]] + steps[1]]
    )
    positions = np.pad(motion.positions, (pad, (0, 0)), mode="edge")
    velocities, accelerations = (np.pad(each, (pad, (0, 0))) for each in states[1:])
    return computed_joints(
        beyond, positions, velocities, accelerations, joint_names=motion.joint_names
    )


def _played_straight(trajectory: JointTrajectory, rate: float) -> _Extremes:
    """Differences over one, two and three periods of a receiver that interpolates linearly."""
    first, last = trajectory.times[[0, -1]]
    periods = max(int(np.ceil((last - first) * rate - ROUNDING)), 1)
    clock = first + np.arange(periods + 1) / rate
    played = np.column_stack(
        [np.interp(clock, trajectory.times, column) for column in trajectory.positions.T]
    )
    values, slopes = [], played
    for order in range(1, len(KINDS) + 1):
        standing = ((order > 1,) * 2, (0, 0))
        slopes = np.diff(np.pad(slopes, standing), axis=0) * rate
        middles = np.linspace(clock[0], clock[-1], len(slopes))
        values.append(_Values(np.abs(slopes), np.broadcast_to(middles[:, None], slopes.shape)))
    given = _Values(
        trajectory.positions,
        np.broadcast_to(trajectory.times[:, None], trajectory.positions.shape),
    )
    return _Extremes(given, given, *values)


def _report(used: _Extremes, limits: JointLimits, times: Float64Array) -> LimitsReport:
    def worst(when: Float64Array, ratios: Float64Array) -> Peak:
        step, joint = np.unravel_index(int(ratios.argmax()), ratios.shape)
        peaks = ratios.max(axis=0)
        peaks.setflags(write=False)
        time = float(np.clip(when[step, joint], times[0], times[-1]))
        return Peak(peaks, limits.joint_names[joint], time)

    def peak(kind: Kind) -> Peak | None:
        limit = getattr(limits, kind)
        if limit is None:
            return None
        values: _Values = getattr(used, kind)
        return worst(values.times, _ratios(values.values, limit))

    velocity = peak("velocity")
    assert velocity is not None
    return LimitsReport(
        worst(*_position_ratios(used, limits)), velocity, peak("acceleration"), peak("jerk")
    )


def _ratios(values: Float64Array, limit: Float64Array) -> Float64Array:
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        # 0 / 0 is a joint at rest that must rest; anything else not a number overflowed.
        ratios = np.where(values == 0.0, 0.0, values / limit)
    return np.where(np.isnan(ratios), np.inf, ratios)


def _position_ratios(used: _Extremes, limits: JointLimits) -> tuple[Float64Array, Float64Array]:
    """When positions are extreme, and how far from the middle of their ranges."""
    lower, upper = limits.lower, limits.upper
    bounded = np.isfinite(lower) & np.isfinite(upper) & (lower < upper)
    low, high = np.where(bounded, lower, -1.0), np.where(bounded, upper, 1.0)
    q = np.vstack([used.lowest.values, used.highest.values])
    inside = (lower <= q) & (q <= upper)
    ratios = np.where(
        bounded,
        np.abs(q - 0.5 * (low + high)) / (0.5 * (high - low)),
        np.where(inside, 0.0, np.inf),
    )
    return np.vstack([used.lowest.times, used.highest.times]), ratios

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

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import chain, pairwise
from typing import Literal

import numpy as np
from numpy.typing import NDArray

import leadthrough._core as core
from leadthrough import check, sanity
from leadthrough.arm.limits import JointLimits
from leadthrough.check import Float64Array, InvalidInput, LimitsInfeasible, ShortRepr
from leadthrough.drawing import Drawn, Panel, bars
from leadthrough.motion import JointTrajectory, computed_joints, in_order, lerp, with_derivatives
from leadthrough.timing.request import (
    POSITION_ROUNDING,
    InverseDynamics,
    checked_dynamics,
    efforts,
    known_efforts,
)

Kind = Literal["velocity", "acceleration", "jerk"]
KINDS: tuple[Kind, ...] = ("velocity", "acceleration", "jerk")
_BINDING: tuple[Kind | Literal["torque"], ...] = (*KINDS, "torque")
# A ratio above 1 by less is rounding: differences of accelerations sampled at 1 kHz carry 1e-9
# rad/s^3 of it, and a position given with seven digits 1e-7 rad.
ROUNDING = 1e-6
MAX_SAMPLES = 1e7  # of a motion
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
        kind: of its limit.
        ratio: largest fraction of the limit that is used.
    """

    start: float
    end: float
    joint: str
    kind: Kind | Literal["torque"]
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
    trajectory = _ordered(trajectory, limits)
    if linear_rate is None:
        used = extremes(with_derivatives(trajectory), (True, True))
        return report_of(used, limits, trajectory.times)
    rate = check.number(linear_rate, "linear_rate", above=0.0)
    return report_of(_played_straight(trajectory, rate), limits, trajectory.times)


def binding_limits(
    trajectory: JointTrajectory,
    limits: JointLimits,
    *,
    inverse_dynamics: InverseDynamics | None = None,
) -> list[Binding]:
    """The limit that is nearest in each stretch of a trajectory, in the order of time.

    A stretch in which the nearest limit binds is separate from one in which it does not. With
    `inverse_dynamics`, as for `retime`, torques against `limits.effort` count too.
    """
    trajectory, joints = _ordered(trajectory, limits), limits.joint_names
    if len(trajectory.times) == 1:
        return []
    motion = with_derivatives(trajectory)
    ratios = _ratios_in_steps(motion, limits)
    if (dynamics := checked_dynamics(inverse_dynamics)) is not None:
        used = np.abs(efforts(dynamics, motion.positions, *arrays_of(motion)[1:]))
        torques = np.maximum(used[1:], used[:-1]) / known_efforts(limits)
        ratios = chain(ratios, [(len(KINDS), torques)])
    nearest, most = _nearest_in_steps(ratios, len(motion.times) - 1)
    binds = most >= _BINDS
    changes = np.flatnonzero(np.diff(nearest) | np.diff(binds)) + 1
    return [
        Binding(
            start=float(trajectory.times[first]),
            end=float(trajectory.times[last]),
            joint=joints[int(nearest[first]) % len(joints)],
            kind=_BINDING[int(nearest[first]) // len(joints)],
            ratio=float(most[first:last].max()),
        )
        for first, last in pairwise([0, *changes, len(nearest)])
    ]


def check_samples(count: float, argument: str = "rate") -> None:
    """Raises InvalidInput about a rate for more samples than a motion may have."""
    if not count <= MAX_SAMPLES:
        expected = f"expected at most {MAX_SAMPLES:.0e} samples; lower the rate"
        raise InvalidInput(f"{argument}: {expected}, or check that the times are in s")


def check_positions(positions: Float64Array, limits: JointLimits) -> None:
    """Raises LimitsInfeasible if a configuration (n, joints) lies outside the position limits."""
    outside = np.maximum(limits.lower - positions, positions - limits.upper).max(axis=0)
    if outside.max() > POSITION_ROUNDING:
        i = int(np.argmax(outside))
        name = limits.joint_names[i]
        raise LimitsInfeasible(
            f"{name} leaves its position limits along the path, by {outside[i]:.3g}; "
            + (
                sanity.degrees(outside[i])
                or "a smooth path may do so between samples that satisfy them"
            ),
            joint=name,
        )


def positions_outside(used: Extremes, limits: JointLimits) -> Float64Array:
    """How far joints (joints,) leave their position limits, 0 for as much as rounding."""
    low, high = used.positions
    beyond = np.maximum(limits.lower - low, high - limits.upper)
    ranges = limits.upper - limits.lower
    half = np.where(np.isfinite(ranges), 0.5 * ranges, 0.0)
    return np.where(beyond > np.maximum(POSITION_ROUNDING, ROUNDING * half), beyond, 0.0)


@dataclass(frozen=True, eq=False)
class Extremes:
    """The largest values that joints reach, (quantities, joints), when, and in which steps."""

    values: Float64Array
    times: Float64Array
    steps: Float64Array

    @property
    def positions(self) -> Float64Array:
        return self.values[[_LOWEST, _HIGHEST]]


# Rows of the extremes: positions from below and above, and the rates.
_LOWEST, _HIGHEST, _RATES = 0, 1, {"velocity": 2, "acceleration": 3, "jerk": 4}


def _ordered(trajectory: JointTrajectory, limits: JointLimits) -> JointTrajectory:
    check.instance(limits, "limits", JointLimits, "JointLimits, as arm.limits")
    return in_order(trajectory, limits.joint_names, "trajectory")


def arrays_of(motion: JointTrajectory) -> tuple[Float64Array, Float64Array, Float64Array]:
    """Positions, velocities and accelerations (n, joints) of a motion that has them."""
    assert motion.velocities is not None
    assert motion.accelerations is not None
    return motion.positions, motion.velocities, motion.accelerations


def extremes(motion: JointTrajectory, rests: tuple[bool, bool]) -> Extremes:
    """Those of the quintics of a motion with all arrays, at rest before and after it, or not."""
    motion = _standing(motion, rests)
    arrays = arrays_of(motion)
    if len(motion.times) > 1:
        return Extremes(*core.motion_peaks(motion.times, *arrays))
    q, velocity, acceleration = (rows[0] for rows in arrays)
    values = np.array([q, q, np.abs(velocity), np.abs(acceleration), np.zeros_like(q)])
    return Extremes(values, np.full(values.shape, motion.times[0]), np.zeros_like(values))


def _nearest_in_steps(
    ratios: Iterable[tuple[int, Float64Array]], steps: int
) -> tuple[NDArray[np.intp], Float64Array]:
    """The limit of which each step uses most, by kind and joint, and its ratio, (steps,)."""
    nearest, most = np.zeros(steps, dtype=np.intp), np.zeros(steps)
    for kind, used in ratios:
        worst = used.max(axis=1)
        nearer = worst > most
        nearest[nearer] = kind * used.shape[1] + used[nearer].argmax(axis=1)
        most[nearer] = worst[nearer]
    return nearest, most


def _ratios_in_steps(
    motion: JointTrajectory, limits: JointLimits
) -> Iterator[tuple[int, Float64Array]]:
    """The fractions (steps, joints) of the limits of each kind that is limited, by its number."""
    still = np.ptp(motion.positions, axis=0) <= POSITION_ROUNDING
    for number, (kind, used) in enumerate(_used_in_steps(motion)):
        limit = getattr(limits, kind)
        if limit is not None:
            yield number, _ratios(used, limit, still)


def _used_in_steps(motion: JointTrajectory) -> Iterator[tuple[Kind, Float64Array]]:
    """The largest velocities, accelerations and jerks (steps, joints) of each step."""
    arrays = arrays_of(motion)
    velocities, accelerations = core.step_extremes(motion.times, *arrays)
    yield "velocity", velocities
    del velocities
    yield "acceleration", accelerations
    del accelerations
    with np.errstate(over="ignore", invalid="ignore"):
        yield "jerk", np.abs(np.diff(arrays[2], axis=0)) / np.diff(motion.times)[:, None]


def _standing(motion: JointTrajectory, rests: tuple[bool, bool]) -> JointTrajectory:
    """The motion with a step of standing still beyond each end that it passes but should not."""
    times, states = motion.times, arrays_of(motion)
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


def _played_straight(trajectory: JointTrajectory, rate: float) -> Extremes:
    """Differences over one, two and three periods of a receiver that interpolates linearly."""
    first, last = trajectory.times[[0, -1]]
    check_samples((last - first) * rate, "linear_rate")
    periods = max(int(np.ceil((last - first) * rate - ROUNDING)), 1)
    clock = first + np.arange(periods + 1) / rate
    played = lerp(clock, trajectory.times, trajectory.positions)
    given = trajectory.positions
    found = [
        _at(given, trajectory.times, given.argmin(axis=0)),
        _at(given, trajectory.times, given.argmax(axis=0)),
    ]
    slopes = played
    for order in range(1, len(KINDS) + 1):
        standing = ((order > 1,) * 2, (0, 0))
        slopes = np.diff(np.pad(slopes, standing), axis=0) * rate
        used = np.abs(slopes)
        found.append(_at(used, np.linspace(clock[0], clock[-1], len(used)), used.argmax(axis=0)))
    return Extremes(*(np.array(rows) for rows in zip(*found, strict=True)))


def _at(
    values: Float64Array, times: Float64Array, steps: NDArray[np.intp]
) -> tuple[Float64Array, Float64Array, Float64Array]:
    """The value of each joint in a step of its own, when, and the step."""
    return values[steps, np.arange(len(steps))], times[steps], steps.astype(np.float64)


def report_of(used: Extremes, limits: JointLimits, times: Float64Array) -> LimitsReport:
    """The verdict on a motion's extremes."""
    still = np.ptp(used.positions, axis=0) <= POSITION_ROUNDING  # those may have a limit of 0

    def peak(kind: Kind) -> Peak | None:
        limit, row = getattr(limits, kind), _RATES[kind]
        if limit is None:
            return None
        ratios = _ratios(used.values[row], limit, still)
        return _peak(ratios, used.times[row], used.steps[row], limits, times)

    velocity = peak("velocity")
    assert velocity is not None
    position = _peak(*_position_ratios(used, limits), limits, times)
    return LimitsReport(position, velocity, peak("acceleration"), peak("jerk"))


def _peak(
    ratios: Float64Array,
    when: Float64Array,
    steps: Float64Array,
    limits: JointLimits,
    times: Float64Array,
) -> Peak:
    """The peak of the joints' largest ratios; of equal ones that of the first step."""
    joint = int(np.lexsort((steps, -ratios))[0])
    ratios.setflags(write=False)
    return Peak(ratios, limits.joint_names[joint], float(np.clip(when[joint], times[0], times[-1])))


def _ratios(values: Float64Array, limit: Float64Array, still: NDArray[np.bool_]) -> Float64Array:
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        # 0 / 0 is a joint at rest that must rest; anything else not a number overflowed.
        ratios = np.where((values == 0.0) | still & (limit == 0.0), 0.0, values / limit)
    return np.where(np.isnan(ratios), np.inf, ratios)


def _position_ratios(
    used: Extremes, limits: JointLimits
) -> tuple[Float64Array, Float64Array, Float64Array]:
    """How far each joint goes from the middle of its range, when, and in which step."""
    lower, upper = limits.lower, limits.upper
    bounded = np.isfinite(lower) & np.isfinite(upper) & (lower < upper)
    low, high = np.where(bounded, lower, -1.0), np.where(bounded, upper, 1.0)
    q = used.positions
    inside = (lower - POSITION_ROUNDING <= q) & (q <= upper + POSITION_ROUNDING)
    ratios = np.where(
        bounded,
        np.abs(q - 0.5 * (low + high)) / (0.5 * (high - low)),
        np.where(inside, 0.0, np.inf),
    )
    side = ratios.argmax(axis=0), np.arange(len(lower))  # rows _LOWEST or _HIGHEST
    return ratios[side], used.times[side], used.steps[side]

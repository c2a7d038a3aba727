"""Joint limits along a trajectory, judged.

Derivatives of order k are k! times the divided differences of the samples' positions. By the mean
value theorem they are values that the true derivative takes, so samples of a smooth motion inside
its limits are never judged to be outside them. The arm is taken to stand still before the first
sample and after the last, as a controller will have it: a motion that starts or ends at full speed
shows the acceleration and jerk that this takes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from leadthrough.arm.limits import JointLimits
from leadthrough.check import Float64Array
from leadthrough.drawing.drawn import Drawn
from leadthrough.drawing.panels import Panel, bars
from leadthrough.errors import InvalidInput
from leadthrough.motion import JointTrajectory
from leadthrough.repr import ShortRepr

# A ratio above 1 by less is rounding: third differences of positions sampled at 1 kHz carry 1e-6
# rad/s^3 of it, and a position given with seven digits 1e-7 rad.
ROUNDING = 1e-6
_QUANTITIES = ("position", "velocity", "acceleration", "jerk")
_LONGEST_BAR = 3.0  # of a drawing, in multiples of the limit


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
        """Whether every quantity that has limits keeps them."""
        return all(peak is None or peak.ok for peak in self._peaks().values())

    @property
    def unchecked(self) -> tuple[str, ...]:
        """The quantities without limits."""
        return tuple(name for name in ("acceleration", "jerk") if getattr(self, name) is None)

    def _peaks(self) -> dict[str, Peak | None]:
        return {name: getattr(self, name) for name in _QUANTITIES}

    def _repr_parts(self) -> list[str]:
        told = [f"{name} {peak or 'not checked'}" for name, peak in self._peaks().items()]
        return [f"ok={self.ok}", *told]

    def _panels(self) -> list[Panel]:
        rows = [
            (name, 0.0, min(peak.ratio, _LONGEST_BAR))
            for name, peak in self._peaks().items()
            if peak is not None
        ]
        return [bars(rows, title="limits used", x_label="fraction of the limit", limit=1.0)]


def check_limits(trajectory: JointTrajectory, limits: JointLimits) -> LimitsReport:
    """How much of the arm's limits a trajectory uses; exceeding them does not raise.

    Args:
        trajectory: the motion; velocities and accelerations that it carries are judged as well.
        limits: limits of the same joints.

    Raises:
        InvalidInput: if the trajectory and the limits are not of the same joints.
    """
    names = _joint_names(trajectory, limits)
    acceleration, jerk = limits.acceleration, limits.jerk
    return LimitsReport(
        position=_position_peak(trajectory, limits, names),
        velocity=_peak(trajectory, 1, limits.velocity, names, own=trajectory.velocities),
        acceleration=None
        if acceleration is None
        else _peak(trajectory, 2, acceleration, names, own=trajectory.accelerations),
        jerk=None if jerk is None else _peak(trajectory, 3, jerk, names),
    )


def limit_ratios(
    trajectory: JointTrajectory, limits: JointLimits
) -> tuple[tuple[str, ...], Float64Array]:
    """Fractions of each limit that each joint uses between samples."""
    names = _joint_names(trajectory, limits)
    steps = len(trajectory.times) - 1
    ratios = np.zeros((steps, 3, len(names)))
    for order, limit in enumerate((limits.velocity, limits.acceleration, limits.jerk), 1):
        if limit is None or steps == 0:
            continue
        _, values = _differences(trajectory.times, trajectory.positions, order)
        used = _ratios(values, limit)
        for reach in range(order):  # differences of a higher order span several steps
            ratios[:, order - 1] = np.maximum(ratios[:, order - 1], used[reach : reach + steps])
    return names, ratios


def check_type(trajectory: JointTrajectory) -> None:
    """Refuses what is no joint trajectory."""
    if not isinstance(trajectory, JointTrajectory):
        raise InvalidInput(
            f"trajectory: expected a JointTrajectory, got {type(trajectory).__name__}"
        )


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


def _differences(
    times: Float64Array, positions: Float64Array, order: int
) -> tuple[Float64Array, Float64Array]:
    """Times (m,) and derivatives (m, joints) of a motion that starts and ends at rest."""
    if len(times) == 1:
        return times, np.zeros_like(positions)
    rest = order - 1  # samples of standing still, as far as a difference reaches beyond an end
    t = times - times[0]
    before = t[0] - (t[1] - t[0]) * np.arange(rest, 0, -1)
    after = t[-1] + (t[-1] - t[-2]) * np.arange(1, rest + 1)
    t = np.concatenate([before, t, after])
    values = np.pad(positions, ((rest, rest), (0, 0)), mode="edge")
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        for k in range(1, order + 1):
            values = k * np.diff(values, axis=0) / (t[k:] - t[:-k])[:, None]
    middles = times[0] + 0.5 * (t[order:] + t[:-order])
    return np.clip(middles, times[0], times[-1]), values


def _peak(
    trajectory: JointTrajectory,
    order: int,
    limit: Float64Array,
    names: tuple[str, ...],
    *,
    own: Float64Array | None = None,
) -> Peak:
    """The peak of a derivative: measured and, where the trajectory carries it, as given."""
    times, values = _differences(trajectory.times, trajectory.positions, order)
    if own is not None:
        times, values = np.append(times, trajectory.times), np.vstack([values, own])
    return _worst(times, _ratios(values, limit), names)


def _ratios(values: Float64Array, limit: Float64Array) -> Float64Array:
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        # 0 / 0 is a joint at rest that must rest; anything else not a number overflowed.
        ratios = np.where(values == 0.0, 0.0, np.abs(values) / limit)
    return np.where(np.isnan(ratios), np.inf, ratios)


def _position_peak(
    trajectory: JointTrajectory, limits: JointLimits, names: tuple[str, ...]
) -> Peak:
    q, lower, upper = trajectory.positions, limits.lower, limits.upper
    inside = (lower <= q) & (q <= upper)
    bounded = np.isfinite(lower) & np.isfinite(upper) & (lower < upper)
    low, high = np.where(bounded, lower, -1.0), np.where(bounded, upper, 1.0)
    ratios = np.abs(q - 0.5 * (low + high)) / (0.5 * (high - low))
    unbounded = np.where(inside, 0.0, np.inf)
    return _worst(trajectory.times, np.where(bounded, ratios, unbounded), names)


def _worst(times: Float64Array, ratios: Float64Array, names: tuple[str, ...]) -> Peak:
    sample, joint = np.unravel_index(int(ratios.argmax()), ratios.shape)
    peaks = ratios.max(axis=0)
    peaks.setflags(write=False)
    return Peak(peaks, names[joint], float(times[sample]))

"""The options of `retime` and `keep_timing` besides the limits of rates, checked."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.arm.limits import JointLimits
from leadthrough.arm.model import ArmModel
from leadthrough.check import Float64Array, Frozen, InvalidInput

Jacobian = Callable[[Float64Array], Float64Array]
InverseDynamics = Callable[[Float64Array, Float64Array, Float64Array], Float64Array]

# Rounding may take positions beyond their limits by this, rad or m.
POSITION_ROUNDING = 1e-9
_NOMINAL_TOLERANCE = 1e-5  # rad or m: nothing is smoothed up to it
# Tolerances of smooth paths. All up to the one given are tried, so that more never takes longer.
_RUNGS = [float(f"{digit}e{power}") for power in range(-5, 0) for digit in (1, 2, 3, 5)][1:]
_SAME = 1e-9
# Samples that are nearer than this fraction of the tolerance to the one before are dropped.
_FRACTION_DROPPED = 0.05


@dataclass(frozen=True, eq=False)
class TipSpeed:
    """The largest speed of an arm's tip.

    Attributes:
        limit: m/s, > 0.
        jacobian: maps q to (3, joints) or, linear rows first, (6, joints), as `Arm.jacobian`.
    """

    limit: float
    jacobian: Jacobian

    def __post_init__(self) -> None:
        check.number(self.limit, "tip_speed", above=0.0)
        check.instance(self.jacobian, "jacobian", Callable, "a function")


@dataclass(frozen=True, eq=False)
class TipTolerance(Frozen):
    """How far a fitted path may take an arm from the samples.

    No point of the arm moves by more: the bound adds up what each joint moves.

    Attributes:
        position: m, > 0.
        orientation: of the tip, rad, > 0.
        levers: (joints,) m per rad, as `Arm.levers`; 1 for prismatic joints, in m per m.
        turns: (joints,) whether a joint is revolute; by default all are.
    """

    position: float
    orientation: float
    levers: ArrayLike
    turns: ArrayLike | None = None

    def __post_init__(self) -> None:
        check.number(self.position, "position", above=0.0)
        check.number(self.orientation, "orientation", above=0.0)
        levers = check.frozen(self.levers, "levers", shape=("joints",))
        turns = np.ones(len(levers)) if self.turns is None else np.asarray(self.turns, dtype=float)
        object.__setattr__(self, "levers", levers)
        object.__setattr__(self, "turns", check.frozen(turns, "turns", shape=levers.shape))

    @property
    def in_joints(self) -> float:
        """The most, rad (m), by which all joints may be off at once."""
        levers, turns = np.asarray(self.levers), np.asarray(self.turns)
        allowed = self.position / max(levers.sum(), 1e-9), self.orientation / max(turns.sum(), 1e-9)
        return float(min(allowed))

    def allows(self, off: Float64Array) -> bool:
        """Whether joints may be off by these distances (n, joints), >= 0."""
        far, angle = (off @ np.asarray(each) for each in (self.levers, self.turns))
        return bool((far <= self.position).all() and (angle <= self.orientation).all())


@dataclass(frozen=True, eq=False)
class Request:
    """Options of `retime`, checked against the path; see there for what each one means."""

    rate: float
    lower: Float64Array  # position limits (joints,), rad or m
    upper: Float64Array  # the same from above
    path_tolerance: float
    dwell_times: Mapping[int, float]
    tip_speed: TipSpeed | None
    inverse_dynamics: InverseDynamics | None
    margins: Float64Array | float = 0.0  # by which a fitted path stays inside them, (joints,)
    smooth: bool = False  # whether a path through samples is as smooth as the tolerance allows
    blend: float = 0.0
    earliest_times: Float64Array | None = None  # s, for every row of the path
    start_velocity: Float64Array | None = None
    end_velocity: Float64Array | None = None

    def outside(self, q: Float64Array) -> float:
        """How far some of the configurations (n, joints) lies outside the position limits."""
        return float(np.maximum(self.lower - q, q - self.upper).max())

    def inside(self, margins: Float64Array) -> Request:
        """The request with position limits that are narrower by margins (joints,)."""
        return replace(self, margins=self.margins + margins)

    def clipped(self, q: Float64Array, fraction: Float64Array) -> Float64Array:
        """Configurations (n, joints) inside the limits by a fraction (n,) of the margins."""
        margins = fraction[:, None] * self.margins
        return np.clip(q, self.lower + margins, self.upper - margins)

    @property
    def dropped(self) -> float:
        """How near samples are to those kept, of which they are dropped, rad (m)."""
        return _FRACTION_DROPPED * self.path_tolerance

    def smoother(self, *, endless: bool = False) -> list[Request]:
        """The request with the nominal tolerance and with smooth paths up to its own, or any."""
        tight = replace(self, path_tolerance=min(self.path_tolerance, _NOMINAL_TOLERANCE))
        most = np.inf if endless else self.path_tolerance * (1.0 + _SAME)
        rungs = [rung for rung in _RUNGS if rung <= most]
        return [tight, *(replace(self, path_tolerance=rung, smooth=True) for rung in rungs)]

    @property
    def rests_at_ends(self) -> tuple[bool, bool]:
        start, end = self.start_velocity, self.end_velocity
        return start is None or not start.any(), end is None or not end.any()

    @property
    def along_lines(self) -> bool:
        """Whether straight lines between rests have a motion in closed form."""
        bounds = (self.earliest_times, self.tip_speed, self.inverse_dynamics)
        return all(bound is None for bound in bounds) and all(self.rests_at_ends)

    def due(self, row: int) -> float:
        """When a row may be left, s from the start: its earliest time and the rests up to it."""
        if self.earliest_times is None:
            return 0.0
        rested = sum(time for each, time in self.dwell_times.items() if each <= row)
        return float(self.earliest_times[row] - self.earliest_times[0]) + rested

    def between_rests(self, *, first: bool, last: bool) -> Request:
        return replace(
            self,
            start_velocity=self.start_velocity if first else None,
            end_velocity=self.end_velocity if last else None,
        )


def joint_tolerance(path_tolerance: float | TipTolerance, joints: int) -> float:
    """The tolerance of a path in its joints, rad (m)."""
    if not isinstance(path_tolerance, TipTolerance):
        return check.number(path_tolerance, "path_tolerance", above=0.0)
    check.array(path_tolerance.levers, "path_tolerance: levers", shape=(joints,))
    return min(path_tolerance.in_joints, _NOMINAL_TOLERANCE)


def checked_dwell_times(dwell_times: Mapping[int, float] | None, rows: int) -> dict[int, float]:
    """Seconds of rest by row; none where `dwell_times` is None."""
    if dwell_times is None:
        return {}
    check.instance(dwell_times, "dwell_times", Mapping, "a mapping from rows to seconds")
    return {
        check.integer(row, "dwell_times", at_least=0, at_most=rows - 1): check.number(
            time, f"dwell_times[{row}]", at_least=0.0
        )
        for row, time in dwell_times.items()
    }


def checked_velocity(velocity: ArrayLike | None, name: str, joints: int) -> Float64Array | None:
    return None if velocity is None else check.frozen(velocity, name, shape=(joints,))


def checked_tip_speed(tip_speed: TipSpeed | None) -> TipSpeed | None:
    """The argument, if it is a TipSpeed or None."""
    check.instance(tip_speed, "tip_speed", TipSpeed | None, "a TipSpeed")
    return tip_speed


def checked_dynamics(inverse_dynamics: InverseDynamics | None) -> InverseDynamics | None:
    """The argument, if it is a function or None."""
    check.instance(inverse_dynamics, "inverse_dynamics", Callable | None, "a function")
    return inverse_dynamics


def efforts(
    dynamics: InverseDynamics, q: Float64Array, qd: Float64Array, qdd: Float64Array
) -> Float64Array:
    """Efforts (n, joints) of states (n, joints), N m (N)."""
    if getattr(dynamics, "__func__", None) in (ArmModel.inverse_dynamics, ArmModel.motor_torques):
        return dynamics(q, qd, qdd)  # all at once
    name = "inverse_dynamics(q, qd, qdd)"
    rows = zip(q, qd, qdd, strict=True)
    return np.array([check.array(dynamics(*row), name, shape=(q.shape[1],)) for row in rows])


def known_efforts(limits: JointLimits) -> Float64Array:
    """The effort limits (joints,), N m (N), which have to be known."""
    if limits.effort is None:
        raise InvalidInput("limits: expected effort limits beside inverse_dynamics, got none")
    names = [name for name, most in zip(limits.joint_names, limits.effort, strict=True) if not most]
    if names:
        raise InvalidInput(
            "limits: expected effort limits > 0 beside inverse_dynamics, got 0 of "
            f"{', '.join(names)}; a file of limits states them"
        )
    return limits.effort

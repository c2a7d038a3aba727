"""Joint limits kept by slowing down, and velocities and accelerations of bare samples."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from leadthrough import events
from leadthrough.arm.limits import JointLimits
from leadthrough.errors import LimitsInfeasible
from leadthrough.motion import JointTrajectory
from leadthrough.timing.limits_report import LimitsReport, Peak, check_limits, check_type

# Scaled times are rounded, and so are the differences measured on them; a factor that is larger
# by this brings the few trajectories that end up an ulp outside back inside.
_MARGIN = 1e-9
_MOST_CORRECTIONS = 20


def scale_to_limits(trajectory: JointTrajectory, limits: JointLimits) -> JointTrajectory:
    """The trajectory, slowed down uniformly until `check_limits` finds all limits kept.

    It is never sped up.

    Args:
        trajectory: the motion.
        limits: limits of the same joints.

    Returns:
        The same path from the same first time, with the events, velocities and accelerations that
        the trajectory carries scaled along.

    Raises:
        InvalidInput: if the trajectory and the limits are not of the same joints.
        LimitsInfeasible: if a position lies outside its limits or a joint moves whose limit is 0.
    """
    report = check_limits(trajectory, limits)
    if not report.position.ok:
        raise LimitsInfeasible(
            f"{report.position.joint} leaves its position limits at {report.position.time:.6g} s",
            joint=report.position.joint,
        )
    scaled, factor = trajectory, 1.0
    for correction in range(_MOST_CORRECTIONS):
        if all(peak.ratio <= 1.0 for _, peak in _derivatives(report)):
            return scaled
        factor *= _slowing(report) + (_MARGIN if correction else 0.0)
        scaled = _slowed(trajectory, factor)
        report = check_limits(scaled, limits)
    raise LimitsInfeasible(
        f"{report.velocity.joint} exceeds its limits at any speed",
        joint=report.velocity.joint,
    )


def differentiate(trajectory: JointTrajectory) -> JointTrajectory:
    """The same samples with velocities and accelerations, those of the cubic spline through them.

    Args:
        trajectory: the motion; the spline starts and ends at rest, and a single sample rests.

    Raises:
        InvalidInput: if it is not a JointTrajectory.
    """
    from scipy.interpolate import CubicSpline

    check_type(trajectory)
    if len(trajectory.times) == 1:
        zeros = np.zeros_like(trajectory.positions)
        return replace(trajectory, velocities=zeros, accelerations=zeros)
    times = trajectory.times - trajectory.times[0]
    spline = CubicSpline(times, trajectory.positions, bc_type="clamped")
    velocities = spline(times, 1)
    velocities[[0, -1]] = 0.0  # the spline's own are zero to rounding
    return replace(trajectory, velocities=velocities, accelerations=spline(times, 2))


def _derivatives(report: LimitsReport) -> list[tuple[int, Peak]]:
    """The peaks of the derivatives that have limits, with their orders."""
    peaks = enumerate((report.velocity, report.acceleration, report.jerk), 1)
    return [(order, peak) for order, peak in peaks if peak is not None]


def _slowing(report: LimitsReport) -> float:
    """The factor on time that the worst ratio asks for, at least 1."""
    for _, peak in _derivatives(report):
        if not np.isfinite(peak.ratio):
            raise LimitsInfeasible(
                f"{peak.joint} moves at {peak.time:.6g} s, beyond its limits at any speed",
                joint=peak.joint,
            )
    return max(1.0, *(float(peak.ratio ** (1.0 / order)) for order, peak in _derivatives(report)))


def _slowed(trajectory: JointTrajectory, factor: float) -> JointTrajectory:
    velocities, accelerations = trajectory.velocities, trajectory.accelerations
    start = trajectory.times[0]
    times = start + (trajectory.times - start) * factor
    return replace(
        trajectory,
        times=times,
        velocities=None if velocities is None else velocities / factor,
        accelerations=None if accelerations is None else accelerations / factor**2,
        events=events.moved(trajectory.events, trajectory.times, times),
    )

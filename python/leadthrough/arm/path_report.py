"""How a joint trajectory keeps to a motion of the tip and to the arm's limits."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from leadthrough import _core, check, rotations
from leadthrough.arm import kinematics
from leadthrough.arm.first_posture import margins
from leadthrough.arm.limits import JointLimits
from leadthrough.arm.tracks import TipPath
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.motion import JointTrajectory, PoseTrajectory, Trajectory

# A share above 1 by less is rounding of the samples.
_ROUNDING = 1e-6


@dataclass(frozen=True, eq=False)
class PathReport:
    """What happens at each sample of a path; every array is (n,).

    position_error: m. orientation_error: rad, 0 where none was asked for. condition_number: of
    the Jacobian with rotations weighted 0.3 m a rad, as by `Arm.condition_number`. margin: the
    least distance of a joint to a position limit as a share of its range, 0.5 in the middle,
    negative outside. velocity_share, acceleration_share: the largest use of a joint's limit around
    the sample, by differences of the samples, the arm at rest before the first and after the last;
    the second is None where the arm's limits state no acceleration.
    position_tolerance, orientation_tolerance: m and rad, what `ok` allows.
    """

    times: Float64Array
    position_error: Float64Array
    orientation_error: Float64Array
    condition_number: Float64Array
    margin: Float64Array
    velocity_share: Float64Array
    acceleration_share: Float64Array | None
    position_tolerance: float
    orientation_tolerance: float

    @property
    def ok(self) -> bool:
        """Whether the tip is on the path within the tolerances and the limits are kept."""
        shares = [self.velocity_share, self.acceleration_share]
        return bool(
            self.position_error.max() <= self.position_tolerance
            and self.orientation_error.max() <= self.orientation_tolerance
            and self.margin.min() >= 0.0
            and all(share is None or share.max() <= 1.0 + _ROUNDING for share in shares)
        )

    def summary(self) -> str:
        """The worst of each, and when it happens, one a line."""
        rows = [
            ("position error", self.position_error, "m", np.argmax),
            ("orientation error", self.orientation_error, "rad", np.argmax),
            ("condition number", self.condition_number, "", np.argmax),
            ("margin to limits", self.margin, "of the range", np.argmin),
            ("velocity", self.velocity_share, "of the limit", np.argmax),
        ]
        if self.acceleration_share is not None:
            rows.append(("acceleration", self.acceleration_share, "of the limit", np.argmax))
        lines = [f"{len(self.times)} samples, {'ok' if self.ok else 'not ok'}"]
        for name, values, unit, worst in rows:
            i = int(worst(values))
            lines.append(f"{name:<18} {values[i]:9.3g} {unit:<12} at {self.times[i]:.6g} s")
        return "\n".join(lines)


def path_report(
    chain: _core.Chain,
    limits: JointLimits,
    trajectory: JointTrajectory,
    motion: Trajectory | PoseTrajectory,
    *,
    position_tolerance: float = 1e-4,
    orientation_tolerance: float = 1e-3,
) -> PathReport:
    """See `Arm.path_report`."""
    path = TipPath.of(motion)
    q = _joints(trajectory, path, limits)
    positions, orientations = chain.forward_kinematics(q)
    turned = np.zeros(len(path))
    if len(path.orientations):
        turned = rotations.distance(orientations, path.orientations)
    times = trajectory.times
    stated = limits.acceleration
    return PathReport(
        times=times,
        position_error=_read_only(np.linalg.norm(positions - path.positions, axis=1)),
        orientation_error=_read_only(turned),
        condition_number=_read_only(kinematics.condition_number(chain, q)),
        margin=_read_only(margins(limits.lower, limits.upper, q)),
        velocity_share=_read_only(_velocity_share(times, q, limits.velocity)),
        acceleration_share=None
        if stated is None
        else _read_only(_acceleration_share(times, q, stated)),
        position_tolerance=check.number(position_tolerance, "position_tolerance", above=0.0),
        orientation_tolerance=check.number(
            orientation_tolerance, "orientation_tolerance", above=0.0
        ),
    )


def _read_only(values: Any) -> Float64Array:
    result = np.asarray(values, dtype=np.float64)
    result.setflags(write=False)
    return result


def _joints(trajectory: Any, path: TipPath, limits: JointLimits) -> Float64Array:
    if not isinstance(trajectory, JointTrajectory):
        what = type(trajectory).__name__
        raise InvalidInput(f"trajectory: expected a JointTrajectory, got {what}")
    expected = (len(path), len(limits.joint_names))
    if trajectory.positions.shape != expected:
        raise InvalidInput(
            f"trajectory: expected a sample for each of the motion's, {expected}, "
            f"got {trajectory.positions.shape}"
        )
    return trajectory.positions


def _velocity_share(times: Float64Array, q: Float64Array, limit: Float64Array) -> Float64Array:
    """The larger of the two intervals beside each sample."""
    between = _share(np.diff(q, axis=0) / np.diff(times)[:, None], limit)
    padded = np.concatenate([[0.0], between, [0.0]])
    return np.asarray(np.maximum(padded[:-1], padded[1:]))


def _acceleration_share(times: Float64Array, q: Float64Array, limit: Float64Array) -> Float64Array:
    if len(times) == 1:
        return np.zeros(1)
    steps = np.diff(times)
    velocities = np.pad(np.diff(q, axis=0) / steps[:, None], ((1, 1), (0, 0)))
    steps = np.pad(steps, 1, mode="edge")
    return _share(2.0 * np.diff(velocities, axis=0) / (steps[1:] + steps[:-1])[:, None], limit)


def _share(rates: Float64Array, limit: Float64Array) -> Float64Array:
    with np.errstate(divide="ignore", invalid="ignore"):
        # 0 / 0 is a joint at rest that must rest.
        shares = np.where(rates == 0.0, 0.0, np.abs(rates) / limit)
    return np.asarray(shares.max(axis=1, initial=0.0))

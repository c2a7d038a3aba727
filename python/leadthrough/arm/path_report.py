"""How a joint trajectory keeps to a motion of the tip and to the arm's limits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import leadthrough._core as core
from leadthrough import check, rotations
from leadthrough.arm import kinematics
from leadthrough.arm.limits import JointLimits, margins
from leadthrough.arm.tip_path import TipPath
from leadthrough.check import Float64Array
from leadthrough.drawing import Drawn, Panel, over
from leadthrough.motion import JointTrajectory, PoseTrajectory, Trajectory, in_order

# A ratio above 1 by less is rounding of the samples.
_ROUNDING = 1e-6


@dataclass(frozen=True, eq=False)
class PathReport(Drawn):
    """How joints keep to a path of the tip and to the arm's limits; arrays are (n,) but for `turn`.

    The ratios are differences of the samples around each sample over the limit, the largest of all
    joints; the arm is at rest before the first sample and after the last.

    Attributes:
        times: of the samples in s.
        position_error: in m.
        orientation_error: in rad, 0 if the motion is of points.
        turn: (n, 3) rad, the rotation vector from the motion's orientation to the tip's, about the
            axes "rx", "ry" and "rz" that `follow` may leave free; 0 if the motion is of points.
        condition_number: of the Jacobian with rotations weighted 0.3 m per rad, as by
            `Arm.condition_number`.
        margin: the least distance of a joint to a position limit as a fraction of its range: 0.5 in
            the middle, negative outside.
        velocity_ratio: velocity over its limit.
        acceleration_ratio: acceleration over its limit; None if the arm has no such limits.
        position_tolerance: the largest position error in m that `ok` allows.
        orientation_tolerance: the largest orientation error in rad that `ok` allows.
    """

    times: Float64Array
    position_error: Float64Array
    orientation_error: Float64Array
    turn: Float64Array
    condition_number: Float64Array
    margin: Float64Array
    velocity_ratio: Float64Array
    acceleration_ratio: Float64Array | None
    position_tolerance: float
    orientation_tolerance: float

    @property
    def ok(self) -> bool:
        """Whether the tip is on the path within the tolerances and the limits are satisfied."""
        ratios = [self.velocity_ratio, self.acceleration_ratio]
        return bool(
            self.position_error.max() <= self.position_tolerance
            and self.orientation_error.max() <= self.orientation_tolerance
            and self.margin.min() >= 0.0
            and all(ratio is None or ratio.max() <= 1.0 + _ROUNDING for ratio in ratios)
        )

    def summary(self) -> str:
        """The worst value of each quantity and its time, one per line."""
        lines = [f"{len(self.times)} samples, {'ok' if self.ok else 'not ok'}"]
        for name, value, unit, time in self._worst():
            lines.append(f"{name:<18} {value:9.3g} {unit:<12} at {time:.6g} s")
        return "\n".join(lines)

    def _worst(self) -> list[tuple[str, float, str, float]]:
        """Name, worst value, unit and time of each quantity."""
        rows = [
            ("position error", self.position_error, "m", np.argmax),
            ("orientation error", self.orientation_error, "rad", np.argmax),
            ("condition number", self.condition_number, "", np.argmax),
            ("margin to limits", self.margin, "of the range", np.argmin),
            ("velocity", self.velocity_ratio, "of the limit", np.argmax),
        ]
        if self.acceleration_ratio is not None:
            rows.append(("acceleration", self.acceleration_ratio, "of the limit", np.argmax))
        rows_of_worst = []
        for name, values, unit, worst in rows:
            i = int(worst(values))
            rows_of_worst.append((name, float(values[i]), unit, float(self.times[i])))
        return rows_of_worst

    def _repr_parts(self) -> list[str]:
        parts = [f"{name} {value:.3g} {unit}".strip() for name, value, unit, _ in self._worst()]
        return [f"ok={self.ok}", f"{len(self.times)} samples", *parts]

    def _panels(self) -> list[Panel]:
        errors = np.column_stack([self.position_error, self.orientation_error])
        ratios = {"velocity": self.velocity_ratio, "margin": self.margin}
        if self.acceleration_ratio is not None:
            ratios["acceleration"] = self.acceleration_ratio
        used = np.column_stack(list(ratios.values()))
        return [
            over(self.times, errors, ("position, m", "orientation, rad"), title="errors"),
            over(self.times, used, list(ratios), title="of the limits, and margin to them"),
        ]


def path_report(
    chain: core.Chain,
    limits: JointLimits,
    trajectory: JointTrajectory,
    motion: Trajectory | PoseTrajectory,
    *,
    position_tolerance: float,
    orientation_tolerance: float,
) -> PathReport:
    """See `Arm.path_report`."""
    path = TipPath.of(motion)
    q = _joints(trajectory, path, limits)
    positions, orientations = chain.forward_kinematics(q)
    angles, turn = np.zeros(len(path)), np.zeros((len(path), 3))
    if len(path.orientations):
        angles = rotations.distance(orientations, path.orientations)
        turn = rotations.log(rotations.compose(rotations.inverse(path.orientations), orientations))
    times = trajectory.times
    stated = limits.acceleration
    weight = kinematics.ROTATION_WEIGHT
    return check.computed(
        PathReport,
        times=times,
        position_error=np.linalg.norm(positions - path.positions, axis=1),
        orientation_error=angles,
        turn=turn,
        condition_number=kinematics.condition_number(kinematics.jacobian(chain, q), weight),
        margin=margins(limits.lower, limits.upper, q),
        velocity_ratio=_velocity_ratio(times, q, limits.velocity),
        acceleration_ratio=None if stated is None else _acceleration_ratio(times, q, stated),
        position_tolerance=check.number(position_tolerance, "position_tolerance", above=0.0),
        orientation_tolerance=check.number(
            orientation_tolerance, "orientation_tolerance", above=0.0
        ),
    )


def _joints(trajectory: JointTrajectory, path: TipPath, limits: JointLimits) -> Float64Array:
    own = in_order(trajectory, limits.joint_names, "trajectory")
    if len(own) != len(path):
        raise check.refused("trajectory", f"{len(path)} samples as of the motion", len(own))
    return own.positions


def _velocity_ratio(times: Float64Array, q: Float64Array, limit: Float64Array) -> Float64Array:
    """The larger ratio of the two intervals beside each sample."""
    between = _ratio(np.diff(q, axis=0) / np.diff(times)[:, None], limit)
    padded = np.concatenate([[0.0], between, [0.0]])
    return np.asarray(np.maximum(padded[:-1], padded[1:]))


def _acceleration_ratio(times: Float64Array, q: Float64Array, limit: Float64Array) -> Float64Array:
    if len(times) == 1:
        return np.zeros(1)
    steps = np.diff(times)
    velocities = np.pad(np.diff(q, axis=0) / steps[:, None], ((1, 1), (0, 0)))
    steps = np.pad(steps, 1, mode="edge")
    return _ratio(2.0 * np.diff(velocities, axis=0) / (steps[1:] + steps[:-1])[:, None], limit)


def _ratio(rates: Float64Array, limit: Float64Array) -> Float64Array:
    with np.errstate(divide="ignore", invalid="ignore"):
        # 0 / 0 is a joint at rest that must rest.
        ratios = np.where(rates == 0.0, 0.0, np.abs(rates) / limit)
    return np.asarray(ratios.max(axis=1, initial=0.0))

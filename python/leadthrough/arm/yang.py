"""The plain damped least squares of Yang, Liu and Pears, "Enhancing Learning from Demonstration
with DLS-IK and ProMPs", equations 3 to 7: a reference for studies of singularities.

One step of joint velocity is

    J^T (J J^T + (lambda^2 + alpha) I)^-1 xdot + (I - J^+ J) qdot_middle,

with J^+ of the undamped Jacobian, so that the second part leaves the tool alone. The paper lets
lambda grow with the condition number kappa of J (4) but gives no rule; ours is

    lambda^2 = damping^2 (1 - (condition_threshold / kappa)^2) where kappa > condition_threshold,

and 0 below: it starts smoothly and ends at `damping` in the singularity.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from leadthrough import _core, check
from leadthrough.arm.options import tolerance
from leadthrough.arm.results import Columns
from leadthrough.arm.tracks import TipPath
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.motion import JointTrajectory, PoseTrajectory, Trajectory

if TYPE_CHECKING:
    from leadthrough.arm.arm import Arm


@dataclass(frozen=True)
class DampedLeastSquares:
    """The numbers of the method.

    damping: lambda in the singularity, m a rad, >= 0; 0 is the plain pseudo-inverse (2).
    alpha: of equation 5, added to lambda^2 everywhere, >= 0.
    condition_threshold: kappa from which on lambda grows, >= 1. kappa is dimensionless only with
        the rotation rows of J in metres: they count `rotation_weight` m a rad, > 0, and so do the
        task and the damping. 0.3 m is about an arm's reach from its wrist: the Panda's kappa is
        then 4.5 in its ready posture and 11 in the middle of random ones. With a weight of 1, where
        the paper weighs nothing, these are 8.2 and 18, and its thresholds of 8 and 10 are low.
    nullspace_gain: share of the way to the middle of the joints' ranges, 1/s, >= 0.
    Raises InvalidInput.
    """

    damping: float = 0.1
    alpha: float = 0.0
    condition_threshold: float = 10.0
    nullspace_gain: float = 0.5
    rotation_weight: float = 0.3

    def __post_init__(self) -> None:
        check.number(self.damping, "damping", at_least=0.0)
        check.number(self.alpha, "alpha", at_least=0.0)
        check.number(self.condition_threshold, "condition_threshold", at_least=1.0)
        check.number(self.nullspace_gain, "nullspace_gain", at_least=0.0)
        check.number(self.rotation_weight, "rotation_weight", above=0.0)

    def _core(self) -> _core.YangOptions:
        return _core.YangOptions(
            self.damping,
            self.alpha,
            self.condition_threshold,
            self.nullspace_gain,
            self.rotation_weight,
        )


@dataclass(frozen=True, eq=False)
class DampedPath:
    """Joints along a motion, and for each sample the step that led there.

    condition, damping: (n,) kappa and lambda (m a rad) where the step began. position_error,
    orientation_error: (n,) m and rad, of the tool after the step.
    """

    joints: JointTrajectory
    condition: Float64Array
    damping: Float64Array
    position_error: Float64Array
    orientation_error: Float64Array


def follow_path(
    arm: Arm,
    motion: Trajectory | PoseTrajectory,
    *,
    start: Float64Array,
    settings: DampedLeastSquares | None = None,
) -> DampedPath:
    """One step a sample along a motion; what a step leaves is part of the next one's task.

    motion: poses, or points in 3-D that leave the orientation free. start: (joints,), where the
    first step, which lasts as long as the second, begins. The joints are clamped to their limits,
    of which the paper says nothing. Raises InvalidInput.
    """
    chain, path = arm._chain, TipPath.of(motion)
    q, *columns = _core.yang_path(
        chain,
        path.positions,
        path.orientations,
        check.array(start, "start", shape=(len(chain.joint_names),)),
        _steps(path.times),
        _settings(settings)._core(),
    )
    joints = JointTrajectory(
        path.times, q, joint_names=tuple(chain.joint_names), events=motion.events
    )
    return DampedPath(joints, *columns)


def solve(
    chain: _core.Chain,
    positions: Float64Array,
    orientations: Float64Array,
    seeds: Float64Array,
    *,
    threads: int,
    position_tolerance: float = 1e-6,
    orientation_tolerance: float = 1e-6,
    max_iterations: int = 2000,
    settings: DampedLeastSquares | None = None,
) -> Columns:
    """Steps of one second each from the seeds to poses, checked arrays; no restarts."""
    return _core.solve_yang(
        chain,
        positions,
        orientations,
        seeds,
        tolerance(position_tolerance, orientation_tolerance),
        check.integer(max_iterations, "max_iterations", at_least=1, at_most=10**9),
        _settings(settings)._core(),
        threads,
    )


def _steps(times: Float64Array) -> Float64Array:
    """(n,) s, to each sample."""
    if len(times) == 1:
        return np.ones(1)
    steps = np.diff(times)
    return np.concatenate([steps[:1], steps])


def _settings(value: DampedLeastSquares | None) -> DampedLeastSquares:
    if value is None:
        return DampedLeastSquares()
    if not isinstance(value, DampedLeastSquares):
        raise InvalidInput(f"settings: expected DampedLeastSquares, got {type(value).__name__}")
    return value

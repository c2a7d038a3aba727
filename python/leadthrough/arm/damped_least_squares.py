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

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check
from leadthrough.arm.inverse_kinematics import (
    IkBatch,
    batch_of_results,
    many_poses,
    many_starts,
    tolerance,
)
from leadthrough.arm.model import ArmModel
from leadthrough.arm.tip_path import TipPath
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.drawing import Drawn, Panel, over
from leadthrough.motion import JointTrajectory, PoseTrajectory, Trajectory, with_derivatives


@dataclass(frozen=True)
class DampedLeastSquares:
    """The settings of the method.

    Attributes:
        damping: lambda at the singularity in m per rad, >= 0; 0 is the plain pseudo-inverse (2).
        alpha: of equation 5, added to lambda^2 everywhere, >= 0.
        condition_threshold: condition number kappa above which lambda grows, >= 1. kappa is
            dimensionless only with the rotation rows of J in metres, see `rotation_weight`; with
            0.3 m per rad the Panda's kappa is 4.5 in its ready posture and 11 in the middle of
            random ones. With a weight of 1, where the paper weighs nothing, these are 8.2 and 18,
            and its thresholds of 8 and 10 are low.
        nullspace_gain: rate at which the joints approach the middle of their ranges, 1/s, >= 0.
        rotation_weight: weight of rotations in J, in the task and in the damping, in m per rad,
            > 0. 0.3 m is about an arm's reach from its wrist.
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

    def compiled(self) -> core.YangOptions:
        """The settings as the core takes them."""
        return core.YangOptions(
            self.damping,
            self.alpha,
            self.condition_threshold,
            self.nullspace_gain,
            self.rotation_weight,
        )


@dataclass(frozen=True, eq=False)
class DampedPath(Drawn):
    """Joints along a motion, and what the step that led to each sample was like."""

    joints: JointTrajectory  # the joints, with the motion's times and events
    condition: Float64Array  # condition number kappa (n,) where each step began
    damping: Float64Array  # lambda (n,) in m per rad where each step began
    position_error: Float64Array  # (n,) in m, of the tip after each step
    orientation_error: Float64Array  # (n,) in rad, of the tip after each step

    def _panels(self) -> list[Panel]:
        errors = np.column_stack([self.position_error, self.orientation_error])
        names = ("position, m", "orientation, rad")
        return [
            *self.joints._panels()[:1],
            over(self.joints.times, errors, names, title="errors of the tip"),
        ]


def damped_inverse_kinematics(
    arm: ArmModel,
    positions: ArrayLike,
    orientations: ArrayLike | None = None,
    *,
    q0: ArrayLike | None = None,
    threads: int = 1,
    settings: DampedLeastSquares | None = None,
    position_tolerance: float = 1e-6,
    orientation_tolerance: float = 1e-6,
    max_iterations: int = 2000,
) -> IkBatch:
    """The configurations in which damped least-squares steps towards poses end.

    This is a reference for studies of singularities; `Arm.inverse_kinematics` reaches more poses
    and is faster. Each iteration is a step of one second.

    Args:
        positions: (m, 3) in m, base frame.
        orientations: (m, 4) w, x, y, z; None leaves them free.
        q0: configurations (m, joints) where the steps start, or (joints,) for all of them; by
            default the middle of the joints' ranges.
        threads: number of threads, 1 to 256; does not change the answer.
        settings: those of the method; by default `DampedLeastSquares()`.
        position_tolerance: error in m that counts as reached, > 0.
        orientation_tolerance: error in rad that counts as reached, > 0.
        max_iterations: budget of steps for each pose.

    Returns:
        One row per pose.

    Source: Yang, Liu and Pears, equations 3 to 7.
    """
    targets = many_poses(positions, orientations)
    columns = core.solve_yang(
        arm._chain,
        *targets,
        many_starts(arm._chain, q0, len(targets[0])),
        tolerance(position_tolerance, orientation_tolerance),
        check.integer(max_iterations, "max_iterations", at_least=1, at_most=10**9),
        _checked(settings).compiled(),
        check.integer(threads, "threads", at_least=1, at_most=256),
    )
    return batch_of_results(columns)


def follow_path(
    arm: ArmModel,
    motion: Trajectory | PoseTrajectory,
    *,
    q0: ArrayLike,
    settings: DampedLeastSquares | None = None,
) -> DampedPath:
    """One step per sample along a motion; the error that a step leaves joins the next one's task.

    Source: Yang, Liu and Pears, equations 3 to 7.
    """
    chain, path = arm._chain, TipPath.of(motion)
    q, *columns = core.yang_path(
        chain,
        path.positions,
        path.orientations,
        check.array(q0, "q0", shape=(chain.joints,)),
        _steps(path.times),
        _checked(settings).compiled(),
    )
    joints = JointTrajectory(
        path.times, q, joint_names=tuple(chain.joint_names), events=motion.events
    )
    return DampedPath(with_derivatives(joints), *columns)


def _steps(times: Float64Array) -> Float64Array:
    """Intervals (n,) in s that lead to each sample."""
    if len(times) == 1:
        return np.ones(1)
    steps = np.diff(times)
    return np.concatenate([steps[:1], steps])


def _checked(value: DampedLeastSquares | None) -> DampedLeastSquares:
    """The settings, or the defaults."""
    if value is None:
        return DampedLeastSquares()
    if not isinstance(value, DampedLeastSquares):
        raise InvalidInput(f"settings: expected DampedLeastSquares, got {type(value).__name__}")
    return value
